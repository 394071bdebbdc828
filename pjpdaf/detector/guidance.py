"""What detections take from a tracker's prediction, and for which other predictions they stay."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, Protocol, runtime_checkable

from pjpdaf.detector.face import ExpectedHead, HeadPlace
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates


class Guidance(NamedTuple):
    """All that a view's detections take from a prediction.

    min_area_px: the smallest component; head: where it is expected, None where it is not.
    """

    min_area_px: float
    head: ExpectedHead | None = None


class Scope(NamedTuple):
    """Guidance for which a view's detections are the same.

    min_area_px above `above_px` and up to `upto_px`; place: of the head; None: any.
    """

    above_px: float
    upto_px: float
    place: HeadPlace | None = None

    def holds(self, guidance: Guidance) -> bool:
        """Whether this guidance leads to the same detections."""
        same_place = self.place is None or self.place.serves(guidance.head)
        return same_place and self.above_px < guidance.min_area_px <= self.upto_px


ANY = Scope(float("-inf"), float("inf"))


@runtime_checkable
class ScopedDetector(Protocol):
    """What a `Detector` may add that has no memory: for which predictions an answer holds.

    Then detections can be kept, and given to another tracker.
    """

    @property
    def recipe(self) -> str:
        """All parameters: the same frames and the same recipe give the same detections."""
        ...

    def learn(self, background: Iterable[StereoFrame]) -> ScopedDetector:
        """Return a detector that knows the person-free scene."""
        ...

    def guidance(self, predicted: Estimates | None) -> tuple[Guidance, ...]:
        """Return what each view's detections take from a prediction; needs no background."""
        ...

    def detect(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[tuple[Detections, ...], tuple[Scope, ...]]:
        """Return the detections of each view as a call does, and the scope of each.

        A frame's detections are the same for a prediction whose guidance every scope holds.
        """
        ...
