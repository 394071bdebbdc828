"""Contact of hands and arms with each other and with the scene, and its removal."""
