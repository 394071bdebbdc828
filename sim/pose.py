"""Poses: the places of all moving parts of the scene at a moment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from pjpdaf.arrays import Floats, readonly

SIDES = ("right", "left")  # the person's own; index 0 = right, 1 = left everywhere in sim


@dataclass(frozen=True, eq=False)
class Transform:
    """A rigid pose in the world: position_m (3,), rotation (3, 3) part -> world."""

    position_m: Floats
    rotation: Floats

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "position_m", readonly(self.position_m, (3,), "Transform.position_m")
        )
        object.__setattr__(self, "rotation", readonly(self.rotation, (3, 3), "Transform.rotation"))


@dataclass(frozen=True, eq=False)
class Pose:
    """All moving parts at time_s.

    World: x from the person to the cameras, y to the person's left, z up.

    Part frames:
      torso     origin at the mid-shoulder point; x forward, y left, z up the spine.
      head      origin at the head's centre; x out of the face, y to its left, z to the crown.
      upper_arms, forearms (right, left): origin at the proximal joint, +x along the bone to the
                distal joint (shoulder -> elbow, elbow -> wrist); y, z complete it, z up-ish.
      hands (right, left): origin at the palm's centre; +x to the finger tips, +z out of the back of
                the hand, y = z x x. Right thumb at +y, left thumb at -y. The wrist is at
                -wrist_to_palm_m on x.
    curls (2, 5): flexion of thumb, index, middle, ring, little finger; 0 straight, 1 a fist.
    objects: name -> Transform of every movable object (origin at the centre of its base, z up).
    """

    time_s: float
    torso: Transform
    head: Transform
    upper_arms: tuple[Transform, Transform]
    forearms: tuple[Transform, Transform]
    hands: tuple[Transform, Transform]
    curls: Floats
    objects: Mapping[str, Transform] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        object.__setattr__(self, "curls", readonly(self.curls, (2, 5), "Pose.curls"))
