"""Recorded motion on another body: scaled, lifted over the table, kept in reach, interpolated.

Palms are played where they were recorded, as far as this body, its table and its own limbs let
them; data that a clip lacks (elbows, the way hands point) is filled in as a person would.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.clips.clips import Clip
from sim.clips.fit import Fit, fit_of
from sim.clips.limits import above, at_a_table, in_reach, limited
from sim.motion.carriage import Carriage
from sim.motion.motion import elbow_floor_over, table_of
from sim.motion.planner import curled
from sim.motion.posture import shoulders_over
from sim.motion.strokes import HandState, minimum_jerk, minimum_jerk_over, quaternion_of
from sim.person.elbow_circles import ElbowCircles, elbow_circles, within_reach_over
from sim.person.kinematics import OUTWARD, hand_rotation
from sim.pose import SIDES
from sim.specs import SceneSpec
from sim.vectors import dots

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

_TRUSTED_M = 0.08  # a palm that far from its record no longer has the recorded elbow

# A hand on the table lies flat; in the air its thumb is half up.
_FLAT_M, _FINGERS_M = 0.03, 0.12
_FLAT_FROM_M, _FLAT_OVER_M = 0.05, 0.10
_FLAT_RAD, _ROLL_RAD = 0.12, 0.75
_LYING, _RELAXED = curled(0.08, thumb=0.10), curled(0.24, thumb=0.15)

_GRID_HZ = 30.0  # of everything but the palms' places
_STEADY_S = 0.08  # hands turn no quicker than this, elbows likewise
_MAX_LEAN_RAD = math.radians(18.0)
_MAX_TURN_RAD = math.radians(30.0)
_MAX_HEAD_M = 0.05  # head off its place on the neck
_NECK_M = 0.20  # from the point about which the head bends
_SWIVELS_RAD = (math.radians(-10.0), math.radians(95.0))
_SPINE_H = (
    0.345  # hips to shoulders, of the stature: `sim.motion.posture` bends the torso about the hips
)


@dataclass(frozen=True, eq=False)
class Retargeted:
    """A clip for a body, over the clip's own time [s].

    palms: -> (2, 3) right, left, world [m]; turns: -> (2, 4) quaternions; swivels: -> (2,) beyond
    the person's habit; carriage_: -> (8,), the fields of `Carriage`. table_m: height of
    the table top. changed: share of the clip's frames in which a palm was kept off the table or
    within reach by over 1 cm.
    """

    fit: Fit
    palms: CubicSpline
    turns: CubicSpline
    swivels: CubicSpline
    carriage_: CubicSpline
    table_m: float
    changed: float

    def hand(self, side: int, clip_s: float) -> HandState:
        """The state of a hand at a moment of the clip."""
        palm = self.palms(clip_s)[side]
        return HandState(
            palm,
            self.turns(clip_s)[side],
            _curls(float(palm[2]) - self.table_m),
            air=0.0,  # its tremor is in the recording
            swivel_rad=float(self.swivels(clip_s)[side]),
        )

    def carriage(self, clip_s: float, share: float = 1.0) -> Carriage:
        """How torso and head are held at a moment of the clip, or on the way there."""
        return _carriage(share * self.carriage_(clip_s))


def _curls(height_m: float) -> Floats:
    """Relaxed fingers: straighter on the table than in the air."""
    share = minimum_jerk((height_m - _FLAT_FROM_M) / _FLAT_OVER_M)
    return (1.0 - share) * _LYING + share * _RELAXED


def retarget(
    clip: Clip, scene: SceneSpec, swivel_rad: float, scale: float = 1.0, lift_m: float = 0.0
) -> Retargeted:
    """A clip for the person of this scene, whose elbows habitually swivel by swivel_rad.

    scale multiplies the scale of the fit, lift_m is added to its lift.
    """
    from scipy.interpolate import CubicSpline  # late, as in `bvh`

    anatomy = scene.anatomy
    fit = fit_of(clip, scene, scale, lift_m)
    held = _carriages(clip, fit.scale, anatomy)
    carriage = CubicSpline(clip.times_s, held)
    wished = np.stack([fit.placed(clip.path(f"{side}_hand")) for side in SIDES], axis=1)
    grid = _grid(clip.duration_s)
    joints = shoulders_over(anatomy, carriage(grid)[:, :3])
    reached = in_reach(wished, CubicSpline(grid, joints)(clip.times_s), anatomy)
    palms = at_a_table(reached, scene.room)
    moved = np.linalg.norm(palms - wished, axis=2)
    changed = float((moved > 0.01).any(axis=1).mean())
    palm_spline = CubicSpline(clip.times_s, palms)
    track = _Track(
        grid,
        palm_spline(grid),
        joints,
        np.stack([np.interp(grid, clip.times_s, moved[:, side]) for side in (0, 1)], axis=1),
    )
    turns, swivels = _arms(clip, fit, scene, track, swivel_rad)
    return Retargeted(
        fit,
        palm_spline,
        CubicSpline(grid, turns),
        CubicSpline(grid, swivels),
        carriage,
        scene.room.table_height_m,
        changed,
    )


def _grid(duration_s: float) -> Floats:
    return np.linspace(0.0, duration_s, max(int(duration_s * _GRID_HZ), 3) + 1)


def _carriage(row: Floats) -> Carriage:
    forward, sideways, turn, yaw, pitch = row[:5].tolist()
    return Carriage(forward, sideways, turn, yaw, pitch, row[5:])


def _carriages(clip: Clip, scale: float, anatomy: Anatomy) -> Floats:
    """(n, 8): lean forward, sideways, turn, look yaw, look pitch, head x, y, z; about their means.

    How a person sits on the whole is the body's own affair; the clip moves it from there.
    """
    rows = np.zeros((len(clip.times_s), 8))
    spine = _SPINE_H * anatomy.stature_m
    head = scale * clip.path("head") if clip.has("head") else None
    if clip.has("left_shoulder", "right_shoulder"):
        left, right = clip.path("left_shoulder"), clip.path("right_shoulder")
        middle = 0.5 * scale * (left + right)
        across = left - right
        moved = middle - np.median(middle, axis=0)
        rows[:, 0] = limited(moved[:, 0] / spine, _MAX_LEAN_RAD)
        rows[:, 1] = limited(moved[:, 1] / spine, _MAX_LEAN_RAD)
        turn = np.arctan2(-across[:, 0], across[:, 1])
        rows[:, 2] = limited(turn - np.median(turn), _MAX_TURN_RAD)
        if head is not None:
            on_neck = head - middle
            shift = on_neck - np.median(on_neck, axis=0)
            c, s = np.cos(rows[:, 2]), np.sin(rows[:, 2])
            ahead, aside = c * shift[:, 0] + s * shift[:, 1], -s * shift[:, 0] + c * shift[:, 1]
            rows[:, 4] = limited(ahead / _NECK_M, 0.5)
            own = np.column_stack([ahead, aside, np.minimum(shift[:, 2], 0.0)])
            size = np.linalg.norm(own, axis=1, keepdims=True)
            rows[:, 5:] = own * limited(size, _MAX_HEAD_M) / np.maximum(size, 1e-9)
    elif head is not None:
        # Who sits moves the head by the torso, about the hips.
        moved = head - np.median(head, axis=0)
        whole = spine + anatomy.neck_to_head_centre_m
        rows[:, 0] = limited(moved[:, 0] / whole, _MAX_LEAN_RAD)
        rows[:, 1] = limited(moved[:, 1] / whole, _MAX_LEAN_RAD)
    return rows


@dataclass(frozen=True, eq=False)
class _Track:
    """Over the grid times_s (m,): palms and shoulder joints (m, 2, 3), how far each palm is from
    where it was recorded (m, 2).
    """

    times_s: Floats
    palms: Floats
    joints: Floats
    moved: Floats


def _arms(
    clip: Clip, fit: Fit, scene: SceneSpec, track: _Track, swivel_rad: float
) -> tuple[Floats, Floats]:
    """Quaternions (m, 2, 4) of the hands and swivels (m, 2) beyond the habit, over the grid."""
    from scipy.interpolate import CubicSpline  # late, as in `bvh`
    from scipy.ndimage import gaussian_filter1d

    anatomy, table, grid = scene.anatomy, table_of(scene.room), track.times_s
    upper, fore = anatomy.upper_arm_m, anatomy.forearm_m + anatomy.wrist_to_palm_m
    steady = _STEADY_S / float(grid[1] - grid[0])
    turns, swivels = np.empty((len(grid), 2, 4)), np.zeros((len(grid), 2))
    for side, name in enumerate(SIDES):
        palms, joints = track.palms[:, side], track.joints[:, side]
        ends = within_reach_over(joints, palms, upper, fore)
        circles = elbow_circles(side, joints, ends, upper, fore)
        # The recorded elbow and wrist hold as far as the palm is where it was.
        trust = np.exp(-((track.moved[:, side] / _TRUSTED_M) ** 2))
        if clip.has(f"{name}_elbow"):
            elbows = fit.placed(CubicSpline(clip.times_s, clip.path(f"{name}_elbow"))(grid))
            bends = _bends(circles, elbows)
            usual = 0.1 * np.array([math.cos(swivel_rad), math.sin(swivel_rad)])
            bends = trust[:, None] * bends + (1.0 - trust)[:, None] * usual
            # As a vector, as long as the elbow is off the arm's axis: a straight arm says little.
            bends = gaussian_filter1d(bends, steady, axis=0, mode="nearest")
            angles = np.arctan2(bends[:, 1], bends[:, 0])
            low, high = _SWIVELS_RAD
            middle, half = 0.5 * (low + high), 0.5 * (high - low)
            swivels[:, side] = middle + limited(angles - middle, half) - swivel_rad
        floors = elbow_floor_over(anatomy, table, palms)
        along = _forearms(circles, ends, floors, swivels[:, side] + swivel_rad)
        if clip.has(f"{name}_wrist"):
            pointing = clip.path(f"{name}_hand") - clip.path(f"{name}_wrist")
            pointing = CubicSpline(clip.times_s, pointing)(grid)
            # As long as it is: a wrist recorded on the palm has no direction.
            size = max(float(np.median(np.linalg.norm(pointing, axis=1))), 0.01)
            along = along + trust[:, None] * pointing / size
        along = gaussian_filter1d(along, steady, axis=0, mode="nearest")
        turns[:, side] = _turns(side, along, palms[:, 2] - scene.room.table_height_m)
    return turns, swivels


def _bends(circles: ElbowCircles, elbows: Floats) -> Floats:
    """How far recorded elbows (m, 3) are off the arm's axis, down and outward (m, 2) [m]."""
    off = elbows - circles.centre_m
    return np.column_stack([np.vecdot(off, circles.down), np.vecdot(off, circles.outward)])


def _forearms(circles: ElbowCircles, ends: Floats, floors: Floats, swivels: Floats) -> Floats:
    """Unit directions (m, 3) from the elbows to the arms' ends (m, 3), with straight wrists.

    floors (m,): least heights of the elbows [m].
    """
    swivels = np.maximum(swivels, circles.least_swivels(floors)).tolist()
    cos, sin = (np.array([of(swivel) for swivel in swivels]) for of in (math.cos, math.sin))
    forearms = ends - circles.elbows(cos, sin)
    return np.asarray(forearms / np.sqrt(dots(forearms, forearms))[:, None])


def _turns(side: int, along: Floats, heights: Floats) -> Floats:
    """Quaternions (m, 4) of hands that point along (m, 3), at heights (m,) above the table.

    The shortest turn from a hand held before the chest, rolled as a relaxed hand is, and flat the
    nearer it is to the table. Only a hand that points back over the shoulder has no shortest turn;
    it is kept from it.
    """
    usual = hand_rotation(side, 0.45, 0.10, 0.0)
    x0 = usual[:, 0]
    along = _unit(along)
    # Finger tips above the table.
    along[:, 2] = above(along[:, 2], -np.maximum(heights - _FLAT_M, 0.0) / _FINGERS_M)
    along = _unit(along)
    back = np.maximum(0.0, -(along @ x0) - 0.6)
    along = _unit(along + (1.5 * back)[:, None] * np.array([0.0, 0.0, 1.0]))
    # The quaternion of the shortest turn from x0 to `along`: (1 + cos, x0 x along).
    w, v = 1.0 + along @ x0, np.cross(np.broadcast_to(x0, along.shape), along)
    turn = _unit(np.column_stack([w, v]))
    roll = -OUTWARD[side] * (
        _FLAT_RAD
        + (_ROLL_RAD - _FLAT_RAD) * minimum_jerk_over((heights - _FLAT_FROM_M) / _FLAT_OVER_M)
    )
    zero = np.zeros_like(roll)
    rolled = np.column_stack([np.cos(0.5 * roll), np.sin(0.5 * roll), zero, zero])
    quaternions = _times(_times(turn, quaternion_of(usual)[None]), rolled)
    # One of q and -q, such that neighbours are near.
    same = (quaternions[1:] * quaternions[:-1]).sum(axis=1)
    quaternions[1:] *= np.cumprod(np.where(same < 0, -1.0, 1.0))[:, None]
    return quaternions


def _unit(vectors: Floats) -> Floats:
    unit: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-6)
    return unit


def _times(a: Floats, b: Floats) -> Floats:
    """Products of quaternions (m, 4): first b, then a."""
    w, x, y, z = a.T
    p, q, r, s = b.T
    return np.column_stack(
        [
            w * p - x * q - y * r - z * s,
            w * q + x * p + y * s - z * r,
            w * r - x * s + y * p + z * q,
            w * s + x * r - y * q + z * p,
        ]
    )
