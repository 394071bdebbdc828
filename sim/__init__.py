"""The simulated world: a seated person, a room, two cameras. Alone in importing mujoco."""
