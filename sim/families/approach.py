"""The approach of two hands that are about to meet: crossed, broken off, or lowered."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, project, to_camera
from sim.contact.arm_shape import hand_capsules
from sim.contact.capsules import Capsules
from sim.motion.bisection import bisect
from sim.motion.motion import Cue
from sim.motion.planner import RISING_M, HandPlanner, meet, raised
from sim.motion.stage import Stage
from sim.motion.strokes import (
    Glide,
    HandState,
    Stroke,
    between,
    minimum_jerk,
    minimum_jerk_rate,
    minimum_jerk_second,
)
from sim.person.kinematics import OUTWARD
from sim.scene.rig import stereo_rig
from sim.vectors import norm

# The nearer arm reaches in from outside, the farther arm over it: so the forearms pass each other.
_RISE_M = 0.045  # of the farther hand over the nearer hand
_TILT_RAD = 0.6  # between the hands, so that their fingers meet all the same
_SWIVEL_RAD = 0.8  # between the elbows, outward that of the nearer arm
_SHARES = 101  # of a stroke at which the outlines of the hands are compared
_ROUNDING_PX = 1e-6  # far more than the rounding of a gap
_SURELY_PX = 4.0  # outlines that overlap by this much are a single blob in any picture


Pair = tuple[HandState, HandState]


@dataclass(frozen=True, eq=False)
class Approach:
    """Both hands up, apart, at different depths, about to stroke through the middle.

    apart, crossed: both hands (right, left) before and after the strokes; bows_m: of the strokes.
    """

    hands: tuple[HandPlanner, HandPlanner]
    apart: Pair
    crossed: Pair
    bows_m: tuple[Floats, Floats]


def approach(
    stage: Stage, bow_m: float = 0.0, hands: tuple[HandPlanner, HandPlanner] | None = None
) -> Approach:
    """Raise both hands, as the parameters `PARAMETERS` say, ready to stroke across the middle.

    bow_m: bow of the strokes to come, along the depth, away from each other; hands: what they did
    before, None: they rested.
    """
    front = stage.side("front")
    gap = stage.number("depth_gap")
    spread, past = stage.number("spread"), stage.number("past")
    apart, crossed, bows = [], [], []
    for side in (0, 1):
        ahead = 0.5 if side == front else -0.5
        away = np.array([ahead * gap, 0.0, -ahead * _RISE_M])
        centre = stage.centre_m + away
        lateral = np.array([0.0, OUTWARD[side], 0.0])
        held = raised(
            side,
            centre,
            1.0,
            -0.35 - ahead * _TILT_RAD,
            1.2,
            curl=0.16,
            swivel_rad=ahead * _SWIVEL_RAD,
        )
        apart.append(replace(held, position_m=centre + spread * lateral))
        crossed.append(replace(held, position_m=centre - past * lateral))
        bows.append(np.array([2.0 * ahead * bow_m, 0.0, 0.0]))
    hands = hands or stage.planners(stage.start_s)
    for side in (0, 1):
        hands[side].move(apart[side], stage.number("raise_speed"), RISING_M)
    meet(hands, 0.4)
    return Approach(hands, (apart[0], apart[1]), (crossed[0], crossed[1]), (bows[0], bows[1]))


def merged_shares(stage: Stage, a: Approach, here: Pair, there: Pair) -> tuple[float, float]:
    """Shares of the way from `here` to `there` between which the hands are a single blob.

    From the first share on both views show a single blob; up to the last at least one view does.
    For hands that never meet in the pictures both are the share at which they come nearest.
    """
    shares = np.linspace(0.0, 1.0, _SHARES)
    cameras = stereo_rig(stage.scene.rig).cameras
    shapes = [hand_capsules(stage.scene.anatomy, s, here[s].curls) for s in (0, 1)]

    def gaps_at(u: float) -> Floats:
        bars = [
            shapes[s].placed(
                between(here[s], there[s], u, a.bows_m[s]).position_m, here[s].rotation
            )
            for s in (0, 1)
        ]
        return np.array([_blob_gap(camera, bars[0], bars[1]) for camera in cameras])

    gaps = _all_gaps(cameras, shapes, a, here, there, shares)
    # All at once is as good as one by one, but for the last bits where these decide.
    farther = gaps.max(axis=1)
    near = np.abs(gaps[..., None] - [0.0, -_SURELY_PX]).min(axis=(1, 2)) < _ROUNDING_PX
    near |= farther < farther.min() + _ROUNDING_PX
    for row in np.flatnonzero(near).tolist():
        gaps[row] = gaps_at(float(shares[row]))
    both, either = gaps.max(axis=1) < -_SURELY_PX, gaps.min(axis=1) < 0.0
    if not both.any():
        nearest = float(shares[gaps.max(axis=1).argmin()])
        return nearest, nearest
    return float(shares[both.argmax()]), float(shares[np.flatnonzero(either)[-1]])


def _all_gaps(
    cameras: tuple[Camera, ...],
    shapes: list[Capsules],
    a: Approach,
    here: Pair,
    there: Pair,
    shares: Floats,
) -> Floats:
    """`_blob_gap` of every share in every view, (n, N)."""
    hands = []
    for side, bars in enumerate(shapes):
        still = bars.placed(np.zeros(3), here[side].rotation)
        points = np.concatenate(
            [still.starts_m, 0.5 * (still.starts_m + still.ends_m), still.ends_m]
        )
        u, bow_m = shares[:, None], a.bows_m[side]
        first_m, last_m = here[side].position_m, there[side].position_m
        places = (1.0 - u) * first_m + u * last_m + (4.0 * u * (1.0 - u)) * bow_m
        hands.append((places[:, None] + points, np.tile(bars.radii_m, 3)))
    gaps = np.empty((len(shares), len(cameras)))
    for view, camera in enumerate(cameras):
        (right, right_r), (left, left_r) = (
            (project(camera, points), radii * camera.K[0, 0] / to_camera(camera, points)[..., 2])
            for points, radii in hands
        )
        # Three in a hundred shares at a time: the differences stay in the cache.
        for rows in np.array_split(np.arange(len(shares)), len(shares) // 3):
            x = right[rows, :, None, 0] - left[rows, None, :, 0]
            y = right[rows, :, None, 1] - left[rows, None, :, 1]
            x *= x
            y *= y
            x += y
            np.sqrt(x, out=x)
            x -= right_r[rows, :, None]
            x -= left_r[rows, None, :]
            gaps[rows, view] = x.min(axis=(1, 2))
    return gaps


def _blob_gap(camera: Camera, right: Capsules, left: Capsules) -> float:
    """Distance [px] of two hands' outlines in a view, negative where they overlap."""
    places, radii = [], []
    for bars in (right, left):
        points = np.concatenate([bars.starts_m, 0.5 * (bars.starts_m + bars.ends_m), bars.ends_m])
        places.append(project(camera, points))
        radii.append(np.tile(bars.radii_m, 3) * camera.K[0, 0] / to_camera(camera, points)[:, 2])
    offsets = places[0][:, None] - places[1][None]
    distances = np.sqrt((offsets * offsets).sum(axis=-1))
    return float((distances - radii[0][:, None] - radii[1][None]).min())


def share_time(u: float) -> float:
    """The share s of the time with minimum_jerk(s) = u, by bisection to 1e-15."""
    low, high = bisect(0.0, 1.0, 60, lambda s: minimum_jerk(s) >= u)
    return 0.5 * (low + high)


def during(name: str, stroke: Stroke, shares: tuple[float, float]) -> Cue:
    """The cue of the time in which a stroke goes from a share of its way to another."""
    first, last = (stroke.start_s + stroke.duration_s * share_time(u) for u in shares)
    return Cue(name, first, last)


def lower(stage: Stage, hands: tuple[HandPlanner, HandPlanner]) -> None:
    """Add the moves of both hands back to their places on the table."""
    for side in (0, 1):
        hands[side].move(stage.rest(side), stage.number("raise_speed"), RISING_M)


def brake(
    hand: HandPlanner, stroke: Stroke, begun: HandState, share: float, stop_m: Floats
) -> Glide:
    """Break off the hand's last stroke, which began in `begun`, after `share` of its way.

    The hand goes on without a jump, comes to rest at stop_m (3,) and turns back to `begun`.
    """
    s, T = share_time(share), stroke.duration_s
    rate, second = minimum_jerk_rate(s) / T, minimum_jerk_second(s) / (T * T)
    way_m = stroke.to.position_m - begun.position_m
    along = way_m + 4.0 * (1.0 - 2.0 * share) * stroke.bulge_m
    velocity = rate * along
    acceleration = second * along - 8.0 * rate * rate * stroke.bulge_m
    broken_s = stroke.start_s + s * T
    # Twice the way over the speed: a brake that neither overshoots nor creeps.
    way = norm(stop_m - stroke.at(broken_s, begun).position_m)
    glide = Glide(
        start_s=broken_s,
        duration_s=max(2.0 * way / norm(velocity), 0.15),
        to=replace(begun, position_m=stop_m),
        velocity_mps=velocity,
        acceleration_mps2=acceleration,
        begun=begun,
        begun_share=share,
        begun_rate=rate,
    )
    hand.moves.append(glide)
    hand.clock_s = glide.end_s
    return glide


PARAMETERS = (
    "speed",
    "raise_speed",
    "depth_gap",
    "front",
    "height",
    "centre_x",
    "spread",
    "past",
    "bow",
    "merge_gap",
    "wait",
    "hold",
)
