"""Disturbances of a scene: a passing shadow, other skin that moves, a changed room.

None of it touches the person, and none is a target.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from pjpdaf.arrays import Floats, readonly
from sim.pose import Transform
from sim.scene.extras import NO_EXTRAS, Extras, Track
from sim.scene.room import WALL_X, key_direction
from sim.specs import RGB, ObjectSpec
from sim.surfaces.assets import check_word
from sim.surroundings.lights import key_way
from sim.vectors import about_z, cross

SHADOW_PERIODS_S: Mapping[str, tuple[float, float]] = {"slow": (9.0, 13.0), "fast": (2.2, 3.2)}
SHADOWS = ("none", *SHADOW_PERIODS_S)
MOVERS = ("none", "arm", "balloon")
CHANGES = ("none", "box", "picture", "chair")
WOOD: RGB = (0.74, 0.55, 0.40)  # much like skin
# Under the floor: seen by no camera, and in the way of no light.
ABSENT = Transform(np.array([0.0, 0.0, -4.0]), np.eye(3))

_SCREEN_M = (0.02, 0.30, 1.0)
_SCREEN_FROM_AIM_M = 2.45  # towards the light, which is 3 m away: behind and above the cameras
_SWEPT_M = np.array([0.30, 0.0, 0.90])  # the middle of the space over which the shadow sweeps
_SWEEP_M = 0.75
_ARM_M = (0.62, 0.075, 0.075)


@dataclass(frozen=True, eq=False)
class Swing:
    """A `sim.scene.extras.Track`: to and fro about a place, as a cosine, with a bob beside it.

    middle_m, reach_m, bob_m (3,); at t = 0 the object is at middle_m + reach_m, at rest but for the
    bob. rotation (3, 3) stays.
    """

    middle_m: Floats
    reach_m: Floats
    period_s: float
    rotation: Floats
    bob_m: Floats
    bob_s: float = 1.7

    def __post_init__(self) -> None:
        for name, shape in (
            ("middle_m", (3,)),
            ("reach_m", (3,)),
            ("rotation", (3, 3)),
            ("bob_m", (3,)),
        ):
            object.__setattr__(self, name, readonly(getattr(self, name), shape, f"Swing.{name}"))

    def at(self, t_s: float) -> Transform:
        """The place at t_s [s]."""
        swing = math.cos(2 * math.pi * t_s / self.period_s)
        bob = math.sin(2 * math.pi * t_s / self.bob_s)
        return Transform(self.middle_m + swing * self.reach_m + bob * self.bob_m, self.rotation)


def together(all_extras: Iterable[Extras]) -> Extras:
    """Several disturbances at once; the names of their objects differ."""
    objects: list[ObjectSpec] = []
    tracks: dict[str, Track] = {}
    learnt: dict[str, Transform] = {}
    for extras in all_extras:
        objects += extras.objects
        tracks |= extras.tracks
        learnt |= extras.learnt
    if not objects:
        return NO_EXTRAS
    return Extras(tuple(objects), MappingProxyType(tracks), MappingProxyType(learnt))


def moving_shadow(
    kind: str,
    azimuth_rad: float,
    rng: np.random.Generator,
    duration_s: float,
    elevation_rad: float | None = None,
) -> Extras:
    """Somebody passes between the key light and the table: a shadow that sweeps to and fro.

    kind: one of SHADOWS. azimuth_rad: of the light, as in `sim.specs.RoomSpec`. duration_s: in
    which it is to come and go. elevation_rad: of the light of varied surroundings, None in the
    nominal room. At t = 0 the shadow is beside the person, while the background is learnt there is
    none.
    """
    check_word("shadow", kind, SHADOWS)
    if kind == "none":
        return NO_EXTRAS
    if elevation_rad is None:
        along = key_direction(azimuth_rad)
    else:
        along = key_way(azimuth_rad, elevation_rad)
    across = cross(along, np.array([0.0, 0.0, 1.0]))
    across /= np.linalg.norm(across)
    # The screen faces the light: thin along the light, high across it.
    facing = np.column_stack([along, across, cross(along, across)])
    middle = _SWEPT_M - _SCREEN_FROM_AIM_M * along - 0.5 * _SCREEN_M[2] * facing[:, 2]
    side = 1.0 if rng.random() < 0.5 else -1.0
    track = Swing(
        middle_m=middle,
        reach_m=side * _SWEEP_M * across,
        period_s=_period(rng, SHADOW_PERIODS_S[kind], duration_s),
        rotation=facing,
        bob_m=np.zeros(3),
    )
    place = track.at(0.0).position_m.tolist()
    screen = ObjectSpec(
        "shadow_screen", "box", _SCREEN_M, (0.3, 0.3, 0.3), (place[0], place[1]), base_m=place[2]
    )
    return _moving(screen, track)


def mover(
    kind: str,
    skin: RGB,
    table_height_m: float,
    table_near_x_m: float,
    rng: np.random.Generator,
    duration_s: float,
) -> Extras:
    """A moving object of the colour of skin, one of MOVERS.

    arm: somebody beside the table reaches over its edge, and draws back, again and again, beyond
    the person's hands. balloon: a balloon floats to and fro behind the person. duration_s: in which
    it is to come and go.
    """
    check_word("mover", kind, MOVERS)
    if kind == "none":
        return NO_EXTRAS
    side = 1.0 if rng.random() < 0.5 else -1.0
    if kind == "arm":
        # Reaching inwards and a little towards the person.
        yaw = -side * math.pi / 2 - side * float(rng.uniform(0.10, 0.30))
        way = about_z(yaw)[:, 0]
        tip = np.array([table_near_x_m + 0.45, side * 0.33, table_height_m + 0.14])
        reach = 0.5 * float(rng.uniform(0.42, 0.50))
        return _swinging(
            ObjectSpec("other_arm", "arm", _ARM_M, skin, (0.0, 0.0), yaw_rad=yaw),
            middle_m=tip - (_ARM_M[0] / 2 + reach) * way,
            reach_m=-reach * way,
            period_s=_period(rng, (5.0, 8.0), duration_s),
            bob_m=np.array([0.0, 0.0, 0.012]),
        )
    size = float(rng.uniform(0.20, 0.25))
    return _swinging(
        ObjectSpec("balloon", "balloon", (size, size, 1.2 * size), skin, (0.0, 0.0)),
        middle_m=np.array([-0.85, 0.0, float(rng.uniform(1.12, 1.26))]),
        reach_m=np.array([0.0, side * 0.62, 0.0]),
        period_s=_period(rng, (7.0, 11.0), duration_s),
        bob_m=np.array([0.03, 0.0, 0.04]),
    )


def _period(rng: np.random.Generator, usual_s: tuple[float, float], duration_s: float) -> float:
    """A period that a short sequence has time for, as far as that is not wild."""
    return max(min(float(rng.uniform(*usual_s)), duration_s), 2.0)


def _swinging(
    spec: ObjectSpec, middle_m: Floats, reach_m: Floats, period_s: float, bob_m: Floats
) -> Extras:
    return _moving(spec, Swing(middle_m, reach_m, period_s, about_z(spec.yaw_rad), bob_m))


def _moving(spec: ObjectSpec, track: Track) -> Extras:
    return Extras(
        (spec,), MappingProxyType({spec.name: track}), MappingProxyType({spec.name: ABSENT})
    )


def background_change(kind: str, table_near_x_m: float, rng: np.random.Generator) -> Extras:
    """A wooden object that came into the room after the background was learnt, one of CHANGES.

    box: a block on the table, beside the person's hands; picture: on the wall; chair: behind.
    """
    check_word("background_change", kind, CHANGES)
    if kind == "none":
        return NO_EXTRAS
    side = 1.0 if rng.random() < 0.5 else -1.0
    turn = float(rng.uniform(-0.4, 0.4))
    spec = {
        "box": ObjectSpec(
            "changed_box",
            "block",
            (0.08, 0.13, 0.07),
            WOOD,
            (table_near_x_m + 0.24, side * 0.46),
            yaw_rad=turn,
        ),
        "picture": ObjectSpec(
            "changed_picture",
            "picture",
            (0.02, 0.42, 0.32),
            (0.46, 0.33, 0.22),
            (WALL_X + 0.014, -0.32),
            base_m=1.22 + 0.2 * turn,
        ),
        "chair": ObjectSpec(
            "changed_chair",
            "chair",
            (0.44, 0.44, 0.92),
            WOOD,
            (-0.72, side * 0.62),
            yaw_rad=turn,
            base_m=0.0,
        ),
    }[kind]
    return Extras((spec,), learnt=MappingProxyType({spec.name: ABSENT}))
