"""Planners of hand paths: a clock per hand, and the states that hands are usually in."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from pjpdaf.arrays import Floats
from sim.contact.arm_shape import height_above_table
from sim.motion.strokes import HandPath, HandState, Move, Stroke, quaternion_of, stroke_duration
from sim.person.kinematics import OUTWARD, hand_rotation
from sim.pose import Transform
from sim.specs import ObjectSpec, SceneSpec

LEAST_STROKE_S = 0.2
_STILL = np.zeros(3)
RISING_M = np.array([0.0, 0.0, 0.02])  # the bow of a stroke off the table or back to it


@dataclass
class HandPlanner:
    """Collects the moves of a hand; `clock_s` is when the last move is over."""

    first: HandState
    clock_s: float = 0.0
    moves: list[Move] = field(default_factory=list)

    @property
    def state(self) -> HandState:
        """The state in which the hand is once all moves so far are over."""
        return self.moves[-1].to if self.moves else self.first

    def wait(self, duration_s: float) -> None:
        """Hold still."""
        self.clock_s += duration_s

    def until(self, t_s: float) -> None:
        """Hold still until t_s, if that is still to come."""
        self.clock_s = max(self.clock_s, t_s)

    def move(
        self,
        to: HandState,
        peak_mps: float,
        bulge_m: ArrayLike = _STILL,
        least_s: float = LEAST_STROKE_S,
    ) -> Stroke:
        """A minimum-jerk stroke to a state, with this peak speed."""
        bow = np.asarray(bulge_m, dtype=np.float64)
        way = to.position_m - self.state.position_m
        duration = max(stroke_duration(way, bow, peak_mps), least_s)
        stroke = Stroke(self.clock_s, duration, to, bow)
        self.add(stroke)
        return stroke

    def take(
        self, grasp: Grasp, peak_mps: float, near: float = 0.5, closing_s: float = 0.4
    ) -> float:
        """Reach for an object and close the hand round it; returns when it is held [s].

        near: share of the peak speed on the last piece of the way; closing_s: least time of that.
        """
        self.move(grasp.before, peak_mps, [0.0, 0.0, 0.03])
        self.move(grasp.open, near * peak_mps)
        self.move(grasp.closed, peak_mps, least_s=closing_s)
        return self.clock_s

    def let_go(
        self, grasp: Grasp, put: HandState, moved_m: Floats, peak_mps: float, away_mps: float
    ) -> None:
        """Open the hand, at `put`, round an object that has moved by moved_m (3,); draw it back."""
        self.move(replace(put, curls=grasp.open.curls), peak_mps, least_s=0.4)
        self.move(grasp.before.moved(moved_m), away_mps)

    def add(self, move: Move) -> None:
        """Any other kind of move, begun at the clock."""
        self.moves.append(move)
        self.clock_s = move.end_s

    def path(self) -> HandPath:
        """The path of all moves so far."""
        return HandPath(self.first, tuple(self.moves))


def meet(hands: tuple[HandPlanner, HandPlanner], wait_s: float = 0.0) -> float:
    """Let both hands hold still until the later hand is ready, and on for wait_s; returns when."""
    ready = max(hand.clock_s for hand in hands) + wait_s
    for hand in hands:
        hand.until(ready)
    return ready


def curled(fingers: float, thumb: float | None = None) -> Floats:
    """Curls (5,): all fingers alike, the little finger a bit more, the thumb as given."""
    spread = np.array([0.0, -0.03, 0.0, 0.02, 0.04])
    curls = np.clip(fingers + spread, 0.0, 1.0)
    curls[0] = fingers if thumb is None else thumb
    return curls


def resting(
    scene: SceneSpec, side: int, x_m: float, y_m: float, inward_rad: float, curl: float
) -> HandState:
    """A hand flat on the table at (x, |y|), palm down, tips a little lower than the wrist."""
    rotation = hand_rotation(side, inward_rad, math.radians(2.0), math.radians(4.0))
    curls = curled(curl, thumb=0.1)
    # A millimetre of air, so that resting is not touching.
    z = scene.room.table_height_m + height_above_table(scene.anatomy, side, rotation, curls) + 1e-3
    return HandState(
        np.array([x_m, OUTWARD[side] * abs(y_m), z]), quaternion_of(rotation), curls, air=0.0
    )


def raised(
    side: int,
    position_m: ArrayLike,
    inward_rad: float,
    down_rad: float,
    thumb_up_rad: float,
    curl: float = 0.15,
    swivel_rad: float = 0.0,
) -> HandState:
    """A hand held free in the air, turned as in `sim.person.kinematics.hand_rotation`."""
    rotation = hand_rotation(side, inward_rad, down_rad, thumb_up_rad)
    return HandState(
        np.asarray(position_m, dtype=np.float64),
        quaternion_of(rotation),
        curled(curl),
        air=1.0,
        swivel_rad=swivel_rad,
    )


@dataclass(frozen=True, eq=False)
class Grasp:
    """A hand about to take an upright object from outside: open beside it, open at it, closed."""

    before: HandState
    open: HandState
    closed: HandState


def grasp(scene: SceneSpec, side: int, taken: ObjectSpec, place: Transform) -> Grasp:
    """Grasp of an object that stands at `place`: from outside, thumb up, fingers round it."""
    anatomy = scene.anatomy
    rotation = hand_rotation(side, 0.45, 0.0, 1.45)
    thickness = 0.15 * anatomy.hand_breadth_m
    radius = 0.5 * min(taken.size_m[0], taken.size_m[1])
    # From the palm's centre to the object's axis: under the finger roots, on the palm's side.
    offset = rotation @ np.array([0.16 * anatomy.hand_length_m, 0.0, -(radius + thickness + 0.003)])
    height = max(0.5 * anatomy.hand_breadth_m + 0.022, min(0.55 * taken.size_m[2], 0.08))
    position = place.position_m - offset
    position[2] = place.position_m[2] + height
    # The wider the object, the straighter the fingers: 0.50 for a can, 0.42 for a wide box.
    closing = min(max(0.66 - 4.5 * radius, 0.3), 0.6)
    quaternion = quaternion_of(rotation)
    closed = HandState(position, quaternion, curled(closing, thumb=0.55), air=0.0)
    open_ = replace(closed, curls=curled(0.12, thumb=0.05))
    back = -0.06 * rotation[:, 0] + 0.035 * rotation[:, 2]
    before = replace(open_, position_m=position + back + np.array([0.0, 0.0, 0.01]), air=1.0)
    return Grasp(before, open_, closed)
