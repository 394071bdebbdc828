"""Sizes of the objects that several families use: extents x, y, z [m]."""

CAN = (0.066, 0.066, 0.122)  # a 0.33 l can
BOX = (0.055, 0.075, 0.075)
