"""Recorded motion: where head and hands of a person were, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, readonly
from pjpdaf.errors import BenchError
from sim.motion.splines import monotone
from sim.pose import SIDES

ARM_JOINTS = ("shoulder", "elbow", "wrist", "hand")
JOINTS = ("head", *(f"{side}_{joint}" for side in ("left", "right") for joint in ARM_JOINTS))
HANDS = tuple(f"{side}_hand" for side in SIDES)

MAX_M = 3.0  # of a coordinate, and of a step
MAX_MPS = 12.0  # a thrown ball leaves a hand at 10-40 m/s, a gesture peaks at 4
BRIDGED_S = 2.0  # a hand that is missing for longer is not made up
MIN_S = 0.1  # least duration of a clip

# Wrist to palm over elbow to wrist, as in `sim.anatomy`: for clips that end at the wrist.
PALM_PER_FOREARM = 0.045 / 0.1545


@dataclass(frozen=True)
class Gap:
    """A joint is not recorded between two moments of the clip [s]; its motion there is invented.

    Gaps of hands are at most BRIDGED_S long.
    """

    joint: str
    from_s: float
    to_s: float


@dataclass(frozen=True, eq=False)
class Clip:
    """A recorded motion, checked, without gaps in its joints.

    times_s (n,) from 0, increasing; joints (k,) names from JOINTS, both hands (palm centres) among
    them; xyz (n, k, 3) [m] in the torso's frame: x forward, y to the person's left, z up, origin
    mid-shoulder. gaps: bridged stretches; notes: guesses of the reader.
    """

    name: str
    times_s: Floats
    joints: tuple[str, ...]
    xyz: Floats
    gaps: tuple[Gap, ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n, k = len(self.times_s), len(self.joints)
        object.__setattr__(self, "times_s", readonly(self.times_s, (n,), "Clip.times_s"))
        object.__setattr__(self, "xyz", readonly(self.xyz, (n, k, 3), "Clip.xyz"))

    @property
    def duration_s(self) -> float:
        """How long it plays at its own pace [s]."""
        return float(self.times_s[-1])

    def has(self, *joints: str) -> bool:
        """Whether all of these joints were recorded."""
        return all(joint in self.joints for joint in joints)

    def path(self, joint: str) -> Floats:
        """(n, 3) of a joint. Raises ValueError where it was not recorded."""
        path: Floats = self.xyz[:, self.joints.index(joint)]
        return path

    def speeds(self, joint: str) -> Floats:
        """(n - 1,) [m/s] between its frames."""
        steps = np.linalg.norm(np.diff(self.path(joint), axis=0), axis=1)
        speeds: Floats = steps / np.diff(self.times_s)
        return speeds


def mirrored(clip: Clip) -> Clip:
    """The clip seen in a mirror: the left hand does as the right hand did."""

    def other(joint: str) -> str:
        side, _, part = joint.partition("_")
        return {"left": f"right_{part}", "right": f"left_{part}"}.get(side, joint)

    return Clip(
        clip.name,
        clip.times_s,
        tuple(other(joint) for joint in clip.joints),
        clip.xyz * np.array([1.0, -1.0, 1.0]),
        tuple(Gap(other(gap.joint), gap.from_s, gap.to_s) for gap in clip.gaps),
        clip.notes,
    )


def clip_of(
    name: str,
    times_s: Floats,
    joints: tuple[str, ...],
    xyz: Floats,
    notes: tuple[str, ...] = (),
    judged_s: tuple[float, float] | None = None,
) -> Clip:
    """A checked clip of the data of a file; xyz (n, k, 3) with NaN = not recorded.

    Joints that are never there are left out; palms are put ahead of the wrists where only these
    are known; time begins with the first frame that has both hands and ends with the last; gaps are
    bridged. judged_s: only between these times of the clip are jumps and gaps of the hands faults;
    None: everywhere. Raises BenchError naming the clip, the joint or frame, the time, and the rule.
    """
    _check_times(name, times_s)
    tracks = {joint: xyz[:, k] for k, joint in enumerate(joints) if joint in JOINTS}
    for joint, path in tracks.items():
        _check_places(name, joint, times_s, path)
    tracks = {joint: path for joint, path in tracks.items() if not np.isnan(path[:, 0]).all()}
    notes += _with_palms(tracks)
    for hand in HANDS:
        if hand not in tracks:
            there = ", ".join(tracks) or "nothing"
            raise BenchError(f"{name}: {hand} is never recorded; the clip has: {there}")
    both = ~np.isnan(tracks[HANDS[0]][:, 0]) & ~np.isnan(tracks[HANDS[1]][:, 0])
    if both.sum() < 2:
        raise BenchError(
            f"{name}: both hands are recorded together in {int(both.sum())} frames; 2 are needed"
        )
    first, last = int(both.argmax()), len(both) - int(both[::-1].argmax())
    if times_s[last - 1] - times_s[first] < MIN_S:
        raise BenchError(
            f"{name}: both hands are recorded for {times_s[last - 1] - times_s[first]:.3f} s; "
            f"{MIN_S:g} s are needed"
        )
    if first or last < len(both):
        cut_s = (times_s[first] - times_s[0]) + (times_s[-1] - times_s[last - 1])
        notes += (f"{cut_s:.2f} s without both hands at the ends are left out",)
    kept_s = times_s[first:last]
    gaps: list[Gap] = []
    paths = []
    for joint in JOINTS:
        if joint in tracks and not np.isnan(tracks[joint][first:last, 0]).all():
            path = tracks[joint][first:last]
            gaps += _gaps(joint, kept_s, path)
            paths.append((joint, _bridged(kept_s, path)))
    start_s = float(kept_s[0])
    low_s, high_s = (start_s + t for t in judged_s or (0.0, np.inf))
    _check_gaps(name, [gap for gap in gaps if gap.to_s >= low_s and gap.from_s <= high_s])
    near = (kept_s >= low_s) & (kept_s <= high_s)
    for joint, path in paths:
        if near.sum() > 1:
            _check_steps(name, joint, kept_s[near], path[near])
    return Clip(
        name,
        kept_s - start_s,
        tuple(joint for joint, _ in paths),
        np.stack([path for _, path in paths], axis=1),
        tuple(Gap(gap.joint, gap.from_s - start_s, gap.to_s - start_s) for gap in gaps),
        notes,
    )


def _check_times(name: str, times_s: Floats) -> None:
    if len(times_s) < 2:
        raise BenchError(f"{name}: has {len(times_s)} frames; a motion needs at least 2")
    bad = ~np.isfinite(times_s)
    if bad.any():
        raise BenchError(f"{name}: the time of frame {int(bad.argmax())} is not a number")
    back = np.diff(times_s) <= 0
    if back.any():
        k = int(back.argmax())
        raise BenchError(
            f"{name}: times must increase, but frame {k + 1} is at {times_s[k + 1]:.4f} s "
            f"after {times_s[k]:.4f} s"
        )


def _check_places(name: str, joint: str, times_s: Floats, path: Floats) -> None:
    """Raises BenchError for a coordinate that is infinite, far off, or missing beside others."""
    missing = np.isnan(path)
    part: NDArray[np.bool_] = np.logical_xor(missing.any(axis=1), missing.all(axis=1))
    far: NDArray[np.bool_] = np.logical_not(missing | (np.abs(path) <= MAX_M))
    wrong = part | far.any(axis=1)
    if not wrong.any():
        return
    k = int(wrong.argmax())
    where = f"{name}: {joint} at {times_s[k]:.3f} s (frame {k})"
    axis = int((missing if part[k] else far)[k].argmax())
    letter = "xyz"[axis]
    if part[k]:
        raise BenchError(f"{where}: {letter} is not recorded, but the others are")
    raise BenchError(
        f"{where}: {letter} is {path[k, axis]:.4g} m, more than {MAX_M:g} m from the shoulders; "
        "are the units metres?"
    )


def _check_steps(name: str, joint: str, times_s: Floats, path: Floats) -> None:
    """Raise BenchError for the greatest jump, if there is any."""
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    speeds = steps / np.diff(times_s)
    k = int(speeds.argmax())
    if speeds[k] > MAX_MPS or steps[k] > MAX_M:
        raise BenchError(
            f"{name}: {joint} jumps by {steps[k]:.2f} m within "
            f"{1000 * (times_s[k + 1] - times_s[k]):.0f} ms at {times_s[k]:.3f} s (frame {k}), "
            f"{speeds[k]:.0f} m/s; at most {MAX_MPS:g} m/s can be played"
        )


def _check_gaps(name: str, gaps: list[Gap]) -> None:
    """Raises BenchError where a hand is missing for too long, listing all such gaps."""
    long = [gap for gap in gaps if gap.joint in HANDS and gap.to_s - gap.from_s > BRIDGED_S]
    if not long:
        return
    listed = ", ".join(f"{gap.joint} {gap.from_s:.2f}-{gap.to_s:.2f} s" for gap in long[:6])
    more = f" and {len(long) - 6} more" if len(long) > 6 else ""
    raise BenchError(
        f"{name}: not recorded: {listed}{more}; gaps of up to {BRIDGED_S:g} s are bridged: cut the "
        "clip there"
    )


def _gaps(joint: str, times_s: Floats, path: Floats) -> list[Gap]:
    """Where it is not recorded: from the last frame that has it to the next."""
    missing = np.isnan(path[:, 0])
    edges = np.diff(np.concatenate([[False], missing, [False]]).astype(int))
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    last = len(times_s) - 1
    return [
        Gap(joint, float(times_s[max(a - 1, 0)]), float(times_s[min(b, last)]))
        for a, b in zip(starts.tolist(), ends.tolist(), strict=True)
    ]


def _bridged(times_s: Floats, path: Floats) -> Floats:
    """The path without gaps: smooth and monotone across each, held still before and after all."""
    there: NDArray[np.bool_] = ~np.isnan(path[:, 0])
    if there.all():
        return path
    if there.sum() == 1:
        return np.broadcast_to(path[there], path.shape)
    known_s = times_s[there]
    missing_s = np.clip(times_s[~there], known_s[0], known_s[-1])
    filled = path.copy()
    filled[~there] = monotone(known_s, path[there])(missing_s)
    return filled


def _with_palms(tracks: dict[str, Floats]) -> tuple[str, ...]:
    """Add a palm where only a wrist is recorded: ahead of it, along the forearm. Returns notes."""
    notes: list[str] = []
    for side in SIDES:
        hand, wrist, elbow = (f"{side}_{part}" for part in ("hand", "wrist", "elbow"))
        if hand not in tracks and wrist in tracks and elbow in tracks:
            tracks[hand] = tracks[wrist] + PALM_PER_FOREARM * (tracks[wrist] - tracks[elbow])
            notes.append(f"{hand} taken {PALM_PER_FOREARM:.2f} of the forearm beyond the wrist")
    return tuple(notes)
