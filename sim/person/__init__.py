"""The seated person: body, head and hands as surfaces, and the kinematics of the arms."""
