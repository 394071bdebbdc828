"""Videos of one view, read frame by frame with the times of the frames."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from pjpdaf.errors import BenchError

VIDEO_SUFFIXES = (".avi", ".mp4", ".m4v", ".mov", ".mkv", ".webm", ".mpg", ".mpeg")
SAME_S = 1e-3  # containers keep times in milliseconds: such a difference is rounding


@dataclass(frozen=True)
class Video:
    """A video of one view. count and rate_hz as in its container, 0 = unknown."""

    path: Path
    count: int
    rate_hz: float


@dataclass(frozen=True, eq=False)
class VideoFrame:
    """A frame: picture uint8 BGR, None = damaged; time_s since the first, None = unknown."""

    picture: np.ndarray | None
    time_s: float | None


def open_video(path: Path) -> Video:
    """Open a video file. Raises BenchError where it cannot be read."""
    capture = cv2.VideoCapture(str(path))
    try:
        if not capture.isOpened():
            raise BenchError(
                f"{path}: not a video that can be read here; convert it to one of "
                f"{', '.join(s[1:] for s in VIDEO_SUFFIXES)}, or give a folder of pictures."
            )
        count = capture.get(cv2.CAP_PROP_FRAME_COUNT)
        rate = capture.get(cv2.CAP_PROP_FPS)
    finally:
        capture.release()
    # Streams and some containers report garbage (negative, 1e18) for values they do not know.
    return Video(path, int(count) if 0 < count < 1e8 else 0, float(rate) if 0 < rate < 1e4 else 0.0)


def video_frames(video: Video) -> Iterator[VideoFrame]:
    """Yield the frames of a video, turned upright as its container says.

    Times are the frames' own, not index / rate: phones and webcams film at a variable rate. Where
    they agree with index / rate but for rounding, or are no times (they do not grow), that is it.
    """
    capture: Any = cv2.VideoCapture(str(video.path))
    try:
        first_s: float | None = None
        before_s = -math.inf
        index = 0
        while capture.grab():
            own_s = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000.0
            read, picture = capture.retrieve()
            first_s = own_s if first_s is None else first_s
            time_s: float | None = own_s - first_s
            even_s = index / video.rate_hz if video.rate_hz else None
            if time_s is None or not math.isfinite(time_s) or time_s <= before_s:
                time_s = None
            elif even_s is not None and abs(time_s - even_s) < SAME_S:
                time_s = even_s
            before_s = time_s if time_s is not None else before_s
            yield VideoFrame(picture if read else None, time_s)
            index += 1
    finally:
        capture.release()
