"""BVH files (Biovision Hierarchy): a skeleton and the angles of its joints become a clip.

Rigs name and build their arms differently. The wrist is recognised by its name; elbow and shoulder
are the joints above it, so that they need no names. The unit follows from the length of the arm.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError
from sim.clips.bvh_skeleton import Node, Skeleton, read_bvh
from sim.clips.clips import PALM_PER_FOREARM, Clip, clip_of

# Upper arm + forearm of an average adult: .3165 of a stature of 1.70 m (see `sim.anatomy`).
_ARM_M = 0.54
_ARM_SPREAD = 1.35  # of children and giants
# Units in use; the last is that of the CMU data base's skeletons (1 / 0.45 inch).
UNITS_M = {"mm": 0.001, "cm": 0.01, "m": 1.0, "inch": 0.0254, "1/0.45 inch": 0.0254 / 0.45}

MOST_PLACES = 8_000_000  # frames x joints: 110 minutes at 60 Hz with 20 joints
# A first frame is a pose of its own where an arm's joint then moves by this share of the upper arm,
# and so many times as far as it ever does later from frame to frame.
_POSE_JUMP, _POSE_FACTOR = 0.3, 4.0

# Where the torso goes and turns slower than this, it is not gesture but standing elsewhere.
_WANDER_S = 2.0

# LeftWrist, mixamorig:LeftHand; lHand, b_l_wrist, Bip01 L Hand; hand_l, Hand.L, HandLeft.
_WRISTS = tuple(
    re.compile(pattern, re.IGNORECASE)
    for pattern in (
        r"^.*?(?P<side>left|right)[ _.-]*(?P<part>wrist|hand|hnd)$",
        r"^(?:.*[ _.:-])?(?P<side>[lr])[ _.-]*(?P<part>wrist|hand|hnd)$",
        r"^(?:.*[ _.:-])?(?P<part>wrist|hand|hnd)[ _.-]*(?P<side>left|right|[lr])$",
    )
)
_HEAD = re.compile(r"^(?:.*[ _.:-]|mixamorig\d*)?head$", re.IGNORECASE)
_BETWEEN = re.compile(r"roll|twist", re.IGNORECASE)  # joints inside a bone
_FINGERS = ("mid", "index", "ring", "finger")  # in this order; the thumb says nothing
_PALM_SHARE = 0.8  # of the way from the wrist to the knuckles, as our hands are built
_KNUCKLES_FROM = 0.22  # of the forearm: nearer to the wrist are metacarpals


class _Side(NamedTuple):
    """Indices of an arm's joints."""

    shoulder: int
    elbow: int
    wrist: int


def _arm(nodes: tuple[Node, ...], side: str, path: str) -> _Side:
    named: dict[str, int] = {}
    for index, node in enumerate(nodes):
        match = next((m for pattern in _WRISTS if (m := pattern.match(node.name))), None)
        if match is not None and match["side"][0].lower() == side[0]:
            named.setdefault(match["part"].lower(), index)
    if not named:
        listed = ", ".join(node.name for node in nodes)
        listed = listed if len(listed) <= 200 else listed[:197] + "..."
        raise BenchError(
            f"{path}: has no {side} hand: needed is a joint named like {side.capitalize()}Hand, "
            f"{side[0]}Hand or hand_{side[0]}; it has {listed}"
        )
    # A rig with a wrist has its hand joint further out.
    wrist = next(named[part] for part in ("wrist", "hand", "hnd") if part in named)
    chain: list[int] = []
    above = nodes[wrist].parent
    while above >= 0 and len(chain) < 2:
        if not _BETWEEN.search(nodes[above].name):
            chain.append(above)
        above = nodes[above].parent
    if len(chain) < 2:
        raise BenchError(f"{path}: {nodes[wrist].name} has no elbow and shoulder above it")
    return _Side(chain[1], chain[0], wrist)


def _knuckles(nodes: tuple[Node, ...], arm: _Side, first: Floats) -> int | None:
    """The joint of a finger's root, None where the rig has none; first (k, 3): any frame."""
    inside = [arm.wrist]
    for k, node in enumerate(nodes):
        if node.parent in inside:
            inside.append(k)
    forearm = np.linalg.norm(first[arm.wrist] - first[arm.elbow])
    for word in _FINGERS:
        for k in inside[1:]:
            name = nodes[k].name.lower()
            away = np.linalg.norm(first[k] - first[arm.wrist])
            if word in name and "thumb" not in name and away > _KNUCKLES_FROM * forearm:
                return k
    return None


def clip_of_bvh(
    text: str, path: str, unit_m: float | None = None, judged_s: tuple[float, float] | None = None
) -> Clip:
    """A BVH text as a clip; `path` names it in faults. unit_m: of its lengths, None = guessed.

    The figure's slow walking and turning is taken out (everything below about 0.1 Hz): places are
    relative to where the shoulders then were on the whole. judged_s: as of `clip_of`. Raises
    BenchError.
    """
    skeleton = read_bvh(text, path)
    arms = {side: _arm(skeleton.nodes, side, path) for side in ("left", "right")}
    if len(skeleton.values) < 2:
        raise BenchError(f"{path}: has {len(skeleton.values)} frames; a motion needs at least 2")
    skeleton, arms, knuckles = _needed(skeleton, arms, path)
    nodes = skeleton.nodes
    positions, rotations = skeleton.places()
    notes: tuple[str, ...] = ()
    if _begins_with_a_pose(positions[:, [j for a in arms.values() for j in a]]):
        skeleton = Skeleton(nodes, skeleton.values[1:], skeleton.frame_s)
        positions, rotations = positions[1:], rotations[1:]
        notes = ("the first frame is a pose of its own (bind or T pose) and is left out",)
    arm = np.mean(
        [
            np.linalg.norm(positions[0, upper] - positions[0, lower])
            for a in arms.values()
            for upper, lower in ((a.shoulder, a.elbow), (a.elbow, a.wrist))
        ]
    )
    unit, basis = _unit(2.0 * float(arm), unit_m, path)
    positions = positions * unit
    places: dict[str, Floats] = {}
    for side, a in arms.items():
        wrist, elbow = positions[:, a.wrist], positions[:, a.elbow]
        places |= {f"{side}_shoulder": positions[:, a.shoulder], f"{side}_elbow": elbow}
        places |= {f"{side}_wrist": wrist}
        root = knuckles[side]
        if root is not None:
            places[f"{side}_hand"] = wrist + _PALM_SHARE * (positions[:, root] - wrist)
            continue
        forearm = wrist - elbow
        length = np.linalg.norm(forearm, axis=1, keepdims=True)
        along = forearm / np.maximum(length, 1e-6)
        ends = [end for end in nodes[a.wrist].ends if np.linalg.norm(end) * unit > 0.01]
        if ends:
            # An End Site says where the hand points, not where its palm is.
            along = rotations[:, a.wrist] @ (ends[0] / np.linalg.norm(ends[0]))
        places[f"{side}_hand"] = wrist + PALM_PER_FOREARM * length * along
        notes += (f"no fingers: {side} palm put {PALM_PER_FOREARM:.2f} of the forearm ahead",)
    head = _head(nodes, positions, rotations, unit)
    if head is not None:
        places = {"head": head} | places
    frame, origin = _torso(positions, arms, skeleton.frame_s)
    joints = tuple(places)
    xyz = np.stack([places[joint] for joint in joints], axis=1) - origin[:, None]
    turned: Floats = xyz @ frame
    times: Floats = np.arange(len(xyz), dtype=np.float64) * skeleton.frame_s
    return clip_of(path, times, joints, turned, (basis, *notes), judged_s)


def _needed(
    skeleton: Skeleton, arms: Mapping[str, _Side], path: str
) -> tuple[Skeleton, dict[str, _Side], dict[str, int | None]]:
    """The part of a skeleton that moves arms and head; its arms, and the roots of their fingers.

    Rigs with fingers and faces have ten times as many joints.
    """
    first = Skeleton(skeleton.nodes, skeleton.values[:1], skeleton.frame_s).places()[0][0]
    knuckles = {side: _knuckles(skeleton.nodes, arm, first) for side, arm in arms.items()}
    head = next((k for k, node in enumerate(skeleton.nodes) if _HEAD.match(node.name)), None)
    tips = [joint for arm in arms.values() for joint in arm]
    tips += [joint for joint in (*knuckles.values(), head) if joint is not None]
    if head is not None:  # its child says how large it is
        tips += [k for k, node in enumerate(skeleton.nodes) if node.parent == head][:1]
    reduced, index = skeleton.above(tips)
    if len(reduced.values) * len(reduced.nodes) > MOST_PLACES:
        raise BenchError(
            f"{path}: has {len(reduced.values)} frames of {len(reduced.nodes)} joints between root "
            f"and hands; at most {MOST_PLACES} places are read: cut it"
        )
    return (
        reduced,
        {side: _Side(*(index[joint] for joint in arm)) for side, arm in arms.items()},
        {side: None if k is None else index[k] for side, k in knuckles.items()},
    )


def _begins_with_a_pose(positions: Floats) -> bool:
    """Whether the first frame jumps to the second as nothing does later; positions (n, k, 3).

    Most files of motion capture begin with the pose in which their skeleton was drawn.
    """
    if len(positions) < 3:
        return False
    here = positions - positions.mean(axis=1, keepdims=True)  # not how the figure walks
    steps = np.linalg.norm(np.diff(here, axis=0), axis=2).max(axis=1)
    arm = float(np.linalg.norm(here[0, 0] - here[0, 1]))
    return bool(steps[0] > _POSE_JUMP * arm and steps[0] > _POSE_FACTOR * steps[1:].max())


def _unit(arm: float, unit_m: float | None, path: str) -> tuple[float, str]:
    """The file's unit [m], and how that is known. arm: upper arm + forearm in this unit."""
    if unit_m is not None:
        return unit_m, f"unit {unit_m:g} m, as given"
    for name, size in UNITS_M.items():
        if _ARM_M / _ARM_SPREAD <= arm * size <= _ARM_M * _ARM_SPREAD:
            return size, f"unit taken to be {name}: the arm is {arm:.4g} long"
    if not 0.0 < arm < math.inf or not 1e-9 < _ARM_M / arm < 1e9:
        raise BenchError(f"{path}: upper arm and forearm are {arm:.4g} long: no person's")
    size = _ARM_M / arm
    return size, (
        f"unit guessed to be {size:.4g} m, by which the person has a stature of 1.70 m: upper arm "
        f"and forearm are {arm:.4g} long, in none of {', '.join(UNITS_M)} a person's"
    )


def _head(
    nodes: tuple[Node, ...], positions: Floats, rotations: Floats, unit: float
) -> Floats | None:
    """The head's centre (n, 3): halfway from its joint, at the skull's base, to its End Site."""
    k = next((k for k, node in enumerate(nodes) if _HEAD.match(node.name)), None)
    if k is None:
        return None
    child = next((nodes[c].offset for c in range(len(nodes)) if nodes[c].parent == k), None)
    top = nodes[k].ends[0] if nodes[k].ends else child
    half = np.zeros(3) if top is None else 0.5 * unit * top
    centre: Floats = positions[:, k] + rotations[:, k] @ half
    return centre


def _torso(positions: Floats, arms: dict[str, _Side], frame_s: float) -> tuple[Floats, Floats]:
    """Frames (n, 3, 3) torso -> file, columns x, y, z, and origins (n, 3): slow means."""
    left, right = (positions[:, arms[side].shoulder] for side in ("left", "right"))
    middle = 0.5 * (left + right)
    # Up is the axis of the file along which the shoulders are above the root.
    rise = (middle - positions[:, 0]).mean(axis=0)
    up = np.zeros(3)
    up[int(np.abs(rise).argmax())] = math.copysign(1.0, float(rise[np.abs(rise).argmax()]))
    across = left - right
    across = _slow(across - (across @ up)[:, None] * up, frame_s)
    y = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-9)
    frame: Floats = np.stack([np.cross(y, up), y, np.broadcast_to(up, y.shape)], axis=2)
    return frame, _slow(middle, frame_s)


def _slow(values: Floats, frame_s: float) -> Floats:
    """The slow mean (n, 3) of values, of deviation _WANDER_S.

    Of long clips at a high rate it is taken of every k-th frame, still 50 in a deviation.
    """
    # Late: loading it takes a twentieth of the start of a worker, and few read clips.
    from scipy.ndimage import gaussian_filter1d

    sigma = _WANDER_S / frame_s
    every = max(1, int(sigma / 50)) if sigma * len(values) > 5e6 else 1
    few = gaussian_filter1d(values[::every], sigma / every, axis=0, mode="nearest")
    if every == 1:
        return np.asarray(few)
    at, known = np.arange(len(values)), np.arange(0, len(values), every)
    return np.stack([np.interp(at, known, few[:, axis]) for axis in range(3)], axis=1)
