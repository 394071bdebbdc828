"""Measurement of a performance: whether a person could make the motion, and its speeds."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from pjpdaf.arrays import Floats
from sim.contact.arm_shape import POINTS_OF_PART, arm_shape
from sim.contact.contact import ALLOWED_PENETRATION_M, Penetration, part_name, penetration
from sim.contact.solids import StandingObject
from sim.motion.motion import Body, Performer, object_at_rest
from sim.person.kinematics import (
    MAX_ADDUCTION_RAD,
    MAX_ELBOW_FLEXION_RAD,
    MAX_EXTENSION_RAD,
    MAX_STRETCH,
    MAX_WRIST_BEND_RAD,
    Arm,
    elbow_flexion,
    shoulder_angles,
    wrist_bend,
)
from sim.pose import SIDES
from sim.vectors import norm

ALLOWED_SHORT_M = 0.010  # a palm may miss its target by this much
FASTEST_MPS = 6.0  # no hand of a seated person is faster
TARGETS = ("head", "right hand", "left hand")
STEP_S = 1.0 / 3.0  # the thesis's frame

_BEND_SLACK_RAD = math.radians(3.0)  # the wrist's iteration ends within 3 degrees of its limit
_SLACK_RAD = math.radians(0.5)
# Of an arm's joints [rad]: what a joint does -> how far at most.
GREATEST_ANGLES: Mapping[str, float] = {
    "wrist bends": MAX_WRIST_BEND_RAD + _BEND_SLACK_RAD,
    "elbow bends": MAX_ELBOW_FLEXION_RAD + _SLACK_RAD,
    "upper arm goes backward": MAX_EXTENSION_RAD + _SLACK_RAD,
    "upper arm goes across the body": MAX_ADDUCTION_RAD + _SLACK_RAD,
}
_MOMENT_S = 0.005  # speeds are differences over this
_BETWEEN = 4  # planned speeds are judged over this share of the time between two moments
# Upright things that a hand cannot go through; the others are small, thin or soft.
_STANDING = {
    "post": True,
    "can": True,
    "cup": True,
    "box": False,
    "block": False,
    "sheet": False,
    "book": False,
}


class MotionFault(str):
    """The reason why a person could not make a motion, and when it shows [s]."""

    time_s: float

    def __new__(cls, reason: str, time_s: float) -> MotionFault:
        """Build the text with its field."""
        self = super().__new__(cls, f"at {time_s:.2f} s {reason}")
        self.time_s = time_s
        return self


@dataclass(frozen=True)
class Speeds:
    """Speeds of a target [m/s]: median, 95 % and greatest. step_m: displacement over 1/3 s [m] at
    50, 90, 99 % of the moments; missed_m: error of a constant-velocity prediction, at 50 and 90 %.
    """

    median_mps: float
    high_mps: float
    top_mps: float
    step_m: tuple[float, float, float]
    missed_m: tuple[float, float]


@dataclass(frozen=True)
class Measures:
    """A performance at a number of moments.

    penetration_m: deepest overlap of each pair of parts, <= 0 is clear. wrist_bend_rad,
    elbow_flexion_rad, stretch (of upper arm + forearm), short_m: the largest of both arms.
    extension_rad, adduction_rad: of the upper arms, backward and across the body. hands_gap_m: the
    least distance of the hands' surfaces, negative where they overlap. speeds: of each target, and
    of both "hands" together.
    """

    penetration_m: Mapping[tuple[str, str], float]
    wrist_bend_rad: float
    elbow_flexion_rad: float
    extension_rad: float
    adduction_rad: float
    stretch: float
    short_m: float
    hands_gap_m: float
    speeds: Mapping[str, Speeds]

    @property
    def deepest(self) -> tuple[str, str]:
        """The pair of parts that overlaps most."""
        return max(self.penetration_m, key=self.penetration_m.__getitem__)

    @property
    def deepest_m(self) -> float:
        """The overlap of that pair [m]."""
        return self.penetration_m[self.deepest]


def standing_objects(performer: Performer) -> tuple[StandingObject, ...]:
    """Objects that stand in the room and are never held: a hand must not go through them."""
    held = {hold.name for hold in performer.plan.holds}
    room = performer.scene.room
    return tuple(
        StandingObject(
            spec.name,
            spec.size_m,
            object_at_rest(room, spec.name).position_m,
            spec.yaw_rad,
            round=_STANDING[spec.kind],
        )
        for spec in room.objects
        if spec.name not in held and spec.kind in _STANDING
    )


def overlaps_of(performer: Performer, body: Body, objects: Sequence[StandingObject]) -> Penetration:
    """Depths of the arms in the body, in each other, in the table and in standing objects."""
    anatomy, curls = performer.scene.anatomy, body.curls
    depths = penetration(anatomy, body.arms, curls, performer.obstacles(body.torso, body.head))
    if not objects:
        return depths
    pairs = dict(depths.pairs)
    for side, arm in enumerate(body.arms):
        shape = arm_shape(anatomy, side, curls[side])
        points = shape.points(arm)
        for standing in objects:
            for part, chosen in enumerate(POINTS_OF_PART):
                depth = standing.depth_m(points[chosen], shape.point_radii_m[chosen])
                pairs[part_name(side, part), standing.name] = depth
    return Penetration(pairs)


def _angles(body: Body, side: int) -> tuple[float, ...]:
    """Angles of an arm's joints [rad], in the order of `GREATEST_ANGLES`."""
    arm = body.arms[side]
    return (wrist_bend(arm), elbow_flexion(arm), *shoulder_angles(side, body.torso.rotation, arm))


def _stretch(performer: Performer, arm: Arm) -> float:
    anatomy = performer.scene.anatomy
    return norm(arm.wrist_m - arm.shoulder_m) / (anatomy.upper_arm_m + anatomy.forearm_m)


def fault_of(
    performer: Performer, times_s: Iterable[float], possible: Sequence[bool] = ()
) -> MotionFault | None:
    """The reason why a person could not make this motion at these times, or None.

    Judged: parts inside one another, joints past their range, palms short of their targets, speed.
    possible: of the times in order, whether all but the speed is known to be possible there.
    """
    times = sorted(times_s)
    too_fast = _too_fast(performer, times)
    if too_fast is not None:
        return too_fast
    objects = standing_objects(performer)
    for t_s, known in zip_longest(times, possible):
        if known:
            continue
        fault = _fault_at(performer, performer.body(t_s), objects)
        if fault is not None:
            return MotionFault(fault, t_s)
    return None


def _fault_at(performer: Performer, body: Body, objects: Sequence[StandingObject]) -> str | None:
    overlap = overlaps_of(performer, body, objects)
    if overlap.worst_m > ALLOWED_PENETRATION_M:
        part, other = overlap.worst
        return (
            f"the {part} is {1000 * overlap.worst_m:.1f} mm in the {other} (allowed "
            f"{1000 * ALLOWED_PENETRATION_M:.0f} mm): use another seed, or move the paths apart"
        )
    for side, arm in enumerate(body.arms):
        limits = zip(GREATEST_ANGLES.items(), _angles(body, side), strict=True)
        for (joint, most), angle in limits:
            if angle > most:
                return (
                    f"the {SIDES[side]} {joint} by {math.degrees(angle):.0f} degrees "
                    f"(at most {math.degrees(most):.0f})"
                )
        stretch = _stretch(performer, arm)
        if stretch > MAX_STRETCH + 1e-6:
            return f"the {SIDES[side]} arm is stretched to {stretch:.3f} of its length"
        if arm.short_m > ALLOWED_SHORT_M:
            return (
                f"the {SIDES[side]} palm stays {1000 * arm.short_m:.0f} mm short of its target "
                f"(allowed {1000 * ALLOWED_SHORT_M:.0f} mm): use another seed, or bring it nearer"
            )
    return None


def _too_fast(performer: Performer, times: Sequence[float]) -> MotionFault | None:
    """The fault of a planned speed, also between the moments: a stroke may lie between frames."""
    if not times:
        return None
    fine = np.interp(
        np.arange((len(times) - 1) * _BETWEEN + 1) / _BETWEEN, np.arange(len(times)), times
    )
    for side, hand in enumerate(performer.plan.hands):
        path = np.array([hand.at(t_s).position_m for t_s in fine.tolist()])
        speeds = np.linalg.norm(np.diff(path, axis=0), axis=1) / np.maximum(np.diff(fine), 1e-9)
        if len(speeds) and speeds.max() > FASTEST_MPS:
            worst = int(speeds.argmax())
            return MotionFault(
                f"the {SIDES[side]} hand moves at {speeds[worst]:.1f} m/s "
                f"(at most {FASTEST_MPS:g} m/s)",
                float(fine[worst]),
            )
    return None


def measure(performer: Performer, times_s: Iterable[float]) -> Measures:
    """All figures of a performance at these moments. Raises ValueError where there are none."""
    times = sorted(times_s)
    if not times:
        raise ValueError("measure needs at least one moment")
    objects = standing_objects(performer)
    bodies = _each_once(performer)
    deepest: dict[tuple[str, str], float] = {}
    angles: list[tuple[float, ...]] = []
    stretch = short = 0.0
    hands = -math.inf
    for t_s in times:
        body = bodies(t_s)
        overlap = overlaps_of(performer, body, objects)
        for pair, depth in overlap.pairs.items():
            deepest[pair] = max(deepest.get(pair, -math.inf), depth)
        hands = max(hands, overlap.hands_m)
        for side, arm in enumerate(body.arms):
            angles.append(_angles(body, side))
            stretch = max(stretch, _stretch(performer, arm))
            short = max(short, arm.short_m)
    bend, flexion, extension, adduction = np.max(angles, axis=0).tolist()
    return Measures(
        penetration_m=deepest,
        wrist_bend_rad=bend,
        elbow_flexion_rad=flexion,
        extension_rad=extension,
        adduction_rad=adduction,
        stretch=stretch,
        short_m=short,
        hands_gap_m=-hands,
        speeds=_speeds(bodies, times),
    )


def _each_once(performer: Performer) -> Callable[[float], Body]:
    """The performer's bodies, each moment posed once."""
    known: dict[float, Body] = {}

    def body(t_s: float) -> Body:
        key = round(t_s, 6)
        if key not in known:
            known[key] = performer.body(key)
        return known[key]

    return body


def _speeds(bodies: Callable[[float], Body], times: Sequence[float]) -> dict[str, Speeds]:
    def at(t_s: float) -> Floats:
        body = bodies(t_s)
        return np.array([body.head.position_m, *(arm.palm_m for arm in body.arms)])

    here = np.array([at(t) for t in times])
    soon = np.array([at(t + _MOMENT_S) for t in times])
    speeds = np.linalg.norm(soon - here, axis=2) / _MOMENT_S
    # Steps end within the performance.
    starts = [t for t in times if t + 2 * STEP_S <= times[-1] + 1e-6] or [times[0]]
    first, second, third = (np.array([at(t + k * STEP_S) for t in starts]) for k in range(3))
    steps = np.linalg.norm(second - first, axis=2)
    missed = np.linalg.norm(third - 2.0 * second + first, axis=2)
    which = {name: [index] for index, name in enumerate(TARGETS)} | {"hands": [1, 2]}
    measured = {}
    for name, columns in which.items():
        median, high = np.quantile(speeds[:, columns], (0.5, 0.95)).tolist()
        s50, s90, s99 = np.quantile(steps[:, columns], (0.5, 0.9, 0.99)).tolist()
        m50, m90 = np.quantile(missed[:, columns], (0.5, 0.9)).tolist()
        top = float(speeds[:, columns].max())
        measured[name] = Speeds(median, high, top, (s50, s90, s99), (m50, m90))
    return measured
