"""Rooms that differ: walls, openings, furniture, clutter, a second person, light, from a seed."""
