"""Names and groups of the person's geoms."""

from __future__ import annotations

from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND

# Geom groups, so that parts can be hidden: the room stays when the person goes.
ROOM, CLOTHES = 0, 1
LEGS = 5  # the parts of the person that never move
TARGET_GROUPS = {HEAD: 2, RIGHT_HAND: 3, LEFT_HAND: 4}
SKIN = "skin:"  # prefix of the names of all geoms that are a target's visible skin
HAND_TARGETS = (RIGHT_HAND, LEFT_HAND)  # in the order of SIDES
