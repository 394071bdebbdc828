"""The simulated world: a seated person, a room and two cameras. The only package that imports mujoco."""
