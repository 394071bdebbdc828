"""Closed-form arms: where the elbow is, and the frames of the bones, for a given palm."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.vectors import (
    Vector,
    about,
    about_x,
    about_y,
    about_z,
    bone_frame,
    cross,
    cross_of,
    dot_of,
    length_of,
    norm,
)

# Outward is -y for the right side (index 0), +y for the left (index 1).
OUTWARD = (-1.0, 1.0)

# Limits of a healthy adult's joints (American Academy of Orthopaedic Surgeons), with a margin.
MAX_ELBOW_FLEXION_RAD = math.radians(145.0)
MAX_WRIST_BEND_RAD = math.radians(55.0)  # forearm against hand: flexion 80, extension 70, ulnar 30
MAX_STRETCH = 0.985  # of upper arm + forearm: an arm in use never locks its elbow
MAX_SWIVEL_RAD = math.radians(100.0)
MAX_EXTENSION_RAD = math.radians(60.0)  # upper arm behind the plane of the trunk
FARTHEST_BACK = math.sin(MAX_EXTENSION_RAD - math.radians(2.0))  # of the upper arm's length
MAX_ADDUCTION_RAD = math.radians(50.0)  # upper arm across the body, from straight ahead


@dataclass(frozen=True, eq=False)
class Arm:
    """An arm, world frame: joints (3,) [m]; hand (3, 3) -> world as in `sim.pose`.

    short_m: how far the palm was pulled in because the target lay out of reach (0 = reached).
    swivel_rad: of the elbow, as it came out; swing (3,): how the elbow moves with it [m/rad].
    """

    shoulder_m: Floats
    elbow_m: Floats
    wrist_m: Floats
    palm_m: Floats
    hand: Floats
    short_m: float
    swivel_rad: float
    swing: Floats

    # Contact solves for many arms of which only the last has its bones looked at.
    @cached_property
    def upper_arm(self) -> Floats:
        """Rotation (3, 3) of the upper arm."""
        return bone_frame(self.shoulder_m, self.elbow_m)

    @cached_property
    def forearm(self) -> Floats:
        """Rotation (3, 3) of the forearm."""
        return bone_frame(self.elbow_m, self.wrist_m)


def hand_rotation(side: int, inward_rad: float, down_rad: float, thumb_up_rad: float) -> Floats:
    """Hand -> world (3, 3), mirrored between the sides.

    All zero: palm down, fingers forward. inward_rad turns the fingers towards the mid-plane,
    down_rad dips the finger tips, thumb_up_rad rolls the thumb up (pi/2: palms facing).
    """
    inward = -OUTWARD[side]
    return about_z(inward * inward_rad) @ about_y(down_rad) @ about_x(inward * thumb_up_rad)


def reach_limits(upper_m: float, forearm_m: float) -> tuple[float, float]:
    """Least and greatest distance shoulder - wrist [m] that elbow flexion and stretch allow."""
    inner = math.pi - MAX_ELBOW_FLEXION_RAD
    least = math.sqrt(
        upper_m * upper_m + forearm_m * forearm_m - 2 * upper_m * forearm_m * math.cos(inner)
    )
    return least, MAX_STRETCH * (upper_m + forearm_m)


def within_reach(shoulder_m: Floats, wrist_m: Floats, upper_m: float, forearm_m: float) -> Floats:
    """The wrist (3,), moved along its line to the shoulder into reach if it is outside."""
    least, most = reach_limits(upper_m, forearm_m)
    start = shoulder_m.tolist()
    offset = [b - a for a, b in zip(start, wrist_m.tolist(), strict=True)]
    distance = length_of(offset)
    if distance < 1e-9:
        offset, distance = [1.0, 0.0, 0.0], 1.0
    k = min(max(distance, least), most) / distance
    return np.array([a + o * k for a, o in zip(start, offset, strict=True)])


_UP = [0.0, 0.0, 1.0]


@dataclass(frozen=True, eq=False)
class ElbowCircle:
    """Where the elbow may be: centre + radius (cos swivel down + sin swivel outward)."""

    centre_m: Vector
    radius_m: float
    down: Vector
    outward: Vector

    def elbow(self, swivel_rad: float) -> Floats:
        """Elbow (3,) at a swivel: 0 hangs straight down, pi/2 points away from the body."""
        c, s, r = math.cos(swivel_rad), math.sin(swivel_rad), self.radius_m
        at = zip(self.centre_m, self.down, self.outward, strict=True)
        return np.array([m + r * (c * down + s * out) for m, down, out in at])

    def swing(self, swivel_rad: float) -> Floats:
        """How the elbow moves with the swivel (3,) [m/rad]."""
        c, s, r = math.cos(swivel_rad), math.sin(swivel_rad), self.radius_m
        ways = zip(self.down, self.outward, strict=True)
        return np.array([r * (c * out - s * down) for down, out in ways])

    def least_swivel(self, height_m: float) -> float:
        """The smallest swivel in [0, MAX_SWIVEL_RAD] that keeps the elbow at or above a height."""
        return self.least_swivel_towards(_UP, height_m)

    def least_swivel_towards(self, direction: Vector, level_m: float) -> float:
        """The smallest swivel in [0, MAX_SWIVEL_RAD] that keeps the elbow at or beyond a level
        along a unit direction (3,).
        """
        a = self.radius_m * dot_of(self.down, direction)
        b = self.radius_m * dot_of(self.outward, direction)
        need = level_m - dot_of(self.centre_m, direction)  # a cos s + b sin s >= need
        if a >= need:
            return 0.0
        size = math.hypot(a, b)
        # size cos(s - phase) is below `need` at 0 and rises to it before its crest at `phase`.
        phase = math.atan2(b, a) % (2.0 * math.pi)
        crossing = phase - math.acos(need / size) if need < size else phase
        return min(max(crossing, 0.0), MAX_SWIVEL_RAD)


def _hanging(side: int, axis: Vector) -> Vector:
    """Where an elbow at rest points, not yet square to the arm's axis.

    Straight down; backwards when the arm hangs down, forwards when it is raised, where "down" along
    the arm has no meaning; forwards and out when the hand is raised beside and behind the head.
    Continuous but for hands that reach through the back.
    """
    x, _, z = axis
    steep = max(0.0, abs(z) - 0.8) / 0.2
    behind = _smooth((0.25 - x) / 0.5) * _smooth(z / 0.6)
    still = 1.0 - behind
    return [
        still * math.copysign(steep, z) + 0.8 * behind,
        0.6 * behind * OUTWARD[side],
        still * (-1.0 + 0.7 * steep) + 0.2 * behind,
    ]


def _smooth(share: float) -> float:
    """0 below 0, 1 above 1, a cubic without corners between."""
    s = min(max(share, 0.0), 1.0)
    return s * s * (3.0 - 2.0 * s)


def elbow_circle(
    side: int, shoulder_m: Floats, wrist_m: Floats, upper_m: float, forearm_m: float
) -> ElbowCircle:
    """Two-link closed form (law of cosines); the wrist must be `within_reach`."""
    start = shoulder_m.tolist()
    offset = [b - a for a, b in zip(start, wrist_m.tolist(), strict=True)]
    d = length_of(offset)
    axis = [x / d for x in offset]
    along = (d * d + upper_m * upper_m - forearm_m * forearm_m) / (2.0 * d)
    radius = math.sqrt(max(upper_m * upper_m - along * along, 0.0))
    down = _hanging(side, axis)
    tilt = dot_of(down, axis)
    down = [x - tilt * a for x, a in zip(down, axis, strict=True)]
    if length_of(down) < 1e-3:
        down = cross_of(axis, [0.0, 1.0, 0.0])
    length = length_of(down)
    down = [x / length for x in down]
    # Always the same way round: turning it over where it points inward would throw the elbow over.
    outward = [OUTWARD[side] * x for x in cross_of(axis, down)]
    centre = [a + along * x for a, x in zip(start, axis, strict=True)]
    return ElbowCircle(centre, radius, down, outward)


def solve_arm(
    anatomy: Anatomy,
    side: int,
    shoulder_m: Floats,
    palm_m: Floats,
    hand: Floats,
    swivel_rad: float,
    elbow_above_m: float = -math.inf,
    forward: Floats | None = None,
) -> Arm:
    """The arm whose palm centre is at palm_m (3,) with the hand turned as `hand` (3, 3).

    A target out of reach is pulled in along the line shoulder - wrist; a hand bent further against
    the forearm than a wrist allows is turned back, about its palm, to the limit. The elbow swivels
    outward beyond swivel_rad where it would sink below elbow_above_m, or where the shoulder cannot
    take it further back (forward (3,): out of the chest).
    """
    a, b, offset = anatomy.upper_arm_m, anatomy.forearm_m, anatomy.wrist_to_palm_m

    def turned(circle: ElbowCircle) -> float:
        swivel = swivel_rad
        if elbow_above_m > -math.inf:
            swivel = max(swivel, circle.least_swivel(elbow_above_m))
        if forward is not None:
            behind = float(shoulder_m @ forward) - a * FARTHEST_BACK
            swivel = max(swivel, circle.least_swivel_towards(forward.tolist(), behind))
        return swivel

    # A round leaves at most a fifth of the excess, or overshoots a little: the forearm follows.
    for turns in range(6):
        fingers = hand[:, 0]
        wrist = within_reach(shoulder_m, palm_m - offset * fingers, a, b)
        circle = elbow_circle(side, shoulder_m, wrist, a, b)
        swivel = turned(circle)
        elbow = circle.elbow(swivel)
        if turns == 5:
            break
        fore = (wrist - elbow) / b
        bend = math.acos(min(1.0, max(-1.0, float(fore @ fingers))))
        if bend <= MAX_WRIST_BEND_RAD + 1e-4:
            break
        axis = cross(fingers, fore)
        hand = about(axis / norm(axis), bend - MAX_WRIST_BEND_RAD) @ hand
    palm = wrist + offset * fingers
    return Arm(
        shoulder_m=shoulder_m,
        elbow_m=elbow,
        wrist_m=wrist,
        palm_m=palm,
        hand=hand,
        short_m=norm(palm_m - palm),
        swivel_rad=swivel,
        swing=circle.swing(swivel),
    )


def wrist_bend(arm: Arm) -> float:
    """Angle between forearm and hand [rad]."""
    return math.acos(min(1.0, max(-1.0, float(arm.forearm[:, 0] @ arm.hand[:, 0]))))


def elbow_flexion(arm: Arm) -> float:
    """0 for a straight arm [rad]."""
    return math.acos(min(1.0, max(-1.0, float(arm.upper_arm[:, 0] @ arm.forearm[:, 0]))))


def shoulder_angles(side: int, torso: Floats, arm: Arm) -> tuple[float, float]:
    """How far the upper arm points backward, and across the body, of a torso (3, 3) [rad].

    Both are angles out of a plane: the trunk's front, the upright plane through the shoulder.
    """
    forward, left, _ = (torso.T @ arm.upper_arm[:, 0]).tolist()
    inward = -OUTWARD[side] * left
    return math.asin(min(1.0, max(-1.0, -forward))), math.asin(min(1.0, max(-1.0, inward)))


def shoulders(anatomy: Anatomy, torso_m: Floats, torso: Floats) -> tuple[Floats, Floats]:
    """Shoulder joints (right, left), each (3,) [m], of a torso at torso_m turned by torso."""
    half, drop = anatomy.shoulder_half_breadth_m, anatomy.shoulder_drop_m
    right = torso_m + torso @ np.array([0.0, -half, -drop])
    left = torso_m + torso @ np.array([0.0, half, -drop])
    return right, left
