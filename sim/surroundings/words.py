"""The words that a room's surroundings are described by (`sim.specs.Surroundings`)."""

from __future__ import annotations

WALLS = ("paint", "wallpaper", "brick", "panel")
FLOORS = ("carpet", "planks", "tiles")
DOORS = ("none", "panelled", "glazed", "plain")
WINDOWS = ("none", "curtains", "blind", "bare")
SHELVES = ("none", "board", "bookcase", "cupboard")
SCREENS = ("none", "wall", "table")
CHAIRS = ("slats", "padded", "office", "stool")
TABLE_SHAPES = ("straight", "rounded", "half_round")
TABLE_LEGS = ("four", "trestle", "pedestal")
BYSTANDERS = ("none", "still", "moving")
LAMPS = ("none", "standing", "ceiling")
