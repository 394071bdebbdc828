"""The verb `scenarios clip`: what a clip of recorded motion is, and the clip in metres."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pjpdaf.errors import BenchError
from sim.clips.bvh import UNITS_M
from sim.clips.clip_files import SHORT, load_clip
from sim.clips.clips import HANDS, Clip
from sim.files import disk_faults, written_whole_file


@dataclass(frozen=True)
class ClipRequest:
    """The options of `scenarios clip`; unit: of a BVH file's lengths, None = guessed."""

    file: Path
    unit: str | None = None
    begin_s: float = 0.0
    end_s: float | None = None
    out: Path | None = None


def read_unit(text: str | None) -> float | None:
    """Length [m] of a unit: a name of `UNITS_M` or a number of metres. Raises BenchError."""
    if text is None or text in UNITS_M:
        return None if text is None else UNITS_M[text]
    try:
        length_m = float(text)
    except ValueError:
        length_m = 0.0
    if not 1e-6 < length_m < 1e3:
        raise BenchError(
            f"--unit must be one of {', '.join(UNITS_M)} or a number of metres, got {text[:40]!r}"
        )
    return length_m


def describe_clip(request: ClipRequest) -> list[str]:
    """Lines about a clip; writes it as NPZ where asked for. Raises BenchError.

    Only what lies between begin_s and end_s is judged and written.
    """
    end_s = np.inf if request.end_s is None else request.end_s
    if not 0.0 <= request.begin_s < end_s:
        raise BenchError(f"--begin {request.begin_s:g} must be 0 or more, and before --end")
    clip = load_clip(request.file, (request.begin_s, end_s), read_unit(request.unit))
    kept = (clip.times_s >= request.begin_s) & (clip.times_s <= end_s)
    if kept.sum() < 2:
        raise BenchError(f"{request.file}: has {clip.duration_s:.2f} s; --begin leaves no motion")
    lines = [
        f"{request.file}: {kept.sum()} frames, {clip.times_s[kept][-1] - request.begin_s:.2f} s of "
        f"{clip.duration_s:.2f} s; joints: {', '.join(clip.joints)}",
        *(
            f"{hand}: fastest {clip.speeds(hand)[kept[1:] & kept[:-1]].max():.2f} m/s"
            for hand in HANDS
        ),
        *(f"note: {note}" for note in clip.notes),
    ]
    if request.out is not None:
        _write(clip, kept, request.out)
        lines.append(f"written: {request.out}")
    return lines


def _write(clip: Clip, kept: np.ndarray, out: Path) -> None:
    if out.suffix.lower() != ".npz":
        raise BenchError(f"{out}: a clip in metres is written as .npz")
    short = {joint: name for name, joint in SHORT.items()}
    times_s = clip.times_s[kept]
    with written_whole_file(out, "the clip") as part, disk_faults(out, "the clip"):
        np.savez_compressed(
            part,
            t=times_s - times_s[0],
            joints=np.array([short[joint] for joint in clip.joints]),
            xyz=clip.xyz[kept],
        )
