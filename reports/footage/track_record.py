"""A run over footage, gathered frame by frame for its page; its size is bounded."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import STATUSES, Detections, Estimates
from pjpdaf.targets import TARGETS
from reports.footage.gallery import Gallery
from reports.footage.stated import DOUBTFUL, StatedDoubt, StatedError, StatedErrors
from reports.summary.text import count
from reports.words import LABELS

MAX_SAMPLES = 2000  # of the curves; longer footage is thinned, so that memory and page stay small
MAX_NAMED = 20  # missing pictures that the page names
# Where tracking never began, by whether most frames had detections enough in both views.
_REMEDY = {
    True: "if these are head and hands, left and right view may be exchanged, or the calibration "
    "be of other cameras, of another size or --unit",
    False: "a sample of the skin (--skin-sample) or a better background may help",
}


@dataclass(frozen=True, eq=False)
class Sample:
    """A frame of the curves. positions_m (T, 3)."""

    frame: int
    time_s: float
    positions_m: Floats
    status: tuple[str, ...]


@dataclass(frozen=True)
class TargetSummary:
    """A target over the whole footage.

    frames, shares: by status; shares 0-1 are of the frames since tracking began, of all frames
    where it never did; longest_gap_s: longest time without a frame "tracked"; sd_mm: mean standard
    deviation along x, y, z while tracked, NaN where it never was. stated: what the tracker says of
    its error in all frames since tracking began, whatever their status.
    """

    target: str
    frames: Mapping[str, int]
    shares: Mapping[str, float]
    longest_gap_s: float
    sd_mm: tuple[float, float, float]
    stated: StatedError


class TrackRecord:
    """Counts, samples and pictures of a run over footage; `add` takes the next frame."""

    def __init__(self, period_s: float) -> None:
        self.frames = 0
        self.missing_pictures = 0
        self.missing_frames: list[int] = []
        self.enough_detected = 0  # frames with three or more detections in every view
        self.first_frame: int | None = None
        self.first_s = float("nan")
        self.samples: list[Sample] = []
        self._period_s = period_s
        self._stride = 1
        self._counts = np.zeros((len(TARGETS), len(STATUSES)), dtype=np.int64)
        self._gap = np.zeros(len(TARGETS), dtype=np.int64)
        self._longest = np.zeros(len(TARGETS), dtype=np.int64)
        self._sd_sums_m = np.zeros((len(TARGETS), 3))
        self._stated = StatedErrors()
        self._gallery = Gallery()
        self._last_s = 0.0

    def add(
        self,
        frame: StereoFrame,
        detections: Sequence[Detections],
        estimates: Estimates,
        picture: Callable[[], bytes],
    ) -> None:
        """Add the next frame; `picture` makes its JPEG, called only for frames of the page."""
        self.frames += 1
        self._last_s = frame.time_s
        missing = sum(p is None for p in frame.pictures)
        if missing and len(self.missing_frames) < MAX_NAMED:
            self.missing_frames.append(frame.index)
        self.missing_pictures += missing
        self.enough_detected += all(len(view) >= len(TARGETS) for view in detections)
        if self.first_frame is None and "waiting" not in estimates.status:
            self.first_frame, self.first_s = frame.index, frame.time_s
        tracked = np.array([s == "tracked" for s in estimates.status])
        if self.first_frame is not None:
            self._gap = np.where(tracked, 0, self._gap + 1)
            self._longest = np.maximum(self._longest, self._gap)
        for t, status in enumerate(estimates.status):
            self._counts[t, STATUSES.index(status)] += 1
        variances = np.einsum("tii->ti", estimates.covariances_m2)
        self._sd_sums_m[tracked] += np.sqrt(np.maximum(variances[tracked], 0.0))
        if self.first_frame is not None:
            self._stated.add(estimates)
        self._sample(frame, estimates)
        self._gallery.offer(frame, estimates, picture)

    @property
    def seconds(self) -> float:
        """Length of the footage."""
        return self._last_s + self._period_s if self.frames else 0.0

    @property
    def pictures(self) -> list[tuple[str, bytes]]:
        """Caption and JPEG of the frames that the page shows, in order."""
        return self._gallery.pictures(self._period_s)

    @property
    def doubt(self) -> StatedDoubt:
        """What the tracker says of right and left."""
        return self._stated.doubt()

    def summaries(self) -> list[TargetSummary]:
        """The summary of each target."""
        summaries = []
        for t, target in enumerate(TARGETS):
            frames = dict(zip(STATUSES, self._counts[t].tolist(), strict=True))
            begun = self.frames - frames["waiting"]
            whole = {s: max(begun, 1) for s in STATUSES} | {"waiting": max(self.frames, 1)}
            n = frames["tracked"]
            sd = self._sd_sums_m[t] * 1000 / n if n else np.full(3, np.nan)
            summaries.append(
                TargetSummary(
                    target,
                    frames,
                    {s: frames[s] / whole[s] for s in STATUSES},
                    float(self._longest[t] * self._period_s),
                    (float(sd[0]), float(sd[1]), float(sd[2])),
                    self._stated.error(t),
                )
            )
        return summaries

    def verdict(self) -> str:
        """The outcome in one or two sentences."""
        if self.first_frame is None:
            often = 2 * self.enough_detected > self.frames
            return (
                "Tracking never began: it waits for a frame in which head and both hands are found "
                "in both views. "
                f"{count(self.enough_detected, 'frame')} of {self.frames} had three or more "
                f"detections in both. The pictures show what was detected; {_REMEDY[often]}."
            )
        shares = ", ".join(
            f"{LABELS[s.target]} {_percent(s.shares['tracked'])}" for s in self.summaries()
        )
        since = f"since tracking began in frame {self.first_frame} ({self.first_s:.1f} s)"
        if not self.first_frame:
            since = "from the first frame on"
        return f"Found {since}: {shares}. {self._doubt_words()}"

    def _doubt_words(self) -> str:
        doubt = self.doubt
        if not doubt.frames:
            return "The tracker does not say how sure it is of right and left."
        return (
            f"The tracker doubts which hand is which ({_percent(DOUBTFUL)} or more that they are "
            f"exchanged) in {_percent(doubt.doubtful)} of the frames."
        )

    def _sample(self, frame: StereoFrame, estimates: Estimates) -> None:
        """Keep every frame of the stride, which doubles where the samples are full."""
        if frame.index % self._stride:
            return
        if len(self.samples) == MAX_SAMPLES:
            self._stride *= 2
            self.samples = [s for s in self.samples if s.frame % self._stride == 0]
            if frame.index % self._stride:
                return
        positions = np.array(estimates.positions_m)
        self.samples.append(Sample(frame.index, frame.time_s, positions, estimates.status))


def _percent(share: float) -> str:
    return f"{100 * share:.0f}\N{NO-BREAK SPACE}%"
