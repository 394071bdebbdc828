"""A preset: parameters of detector and tracker, and where they depart from the thesis."""

from __future__ import annotations

from dataclasses import dataclass

from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters
from pjpdaf.tracker.parameters import TrackerParameters


@dataclass(frozen=True)
class Departure:
    """A place where a preset leaves the printed thesis: its name, both versions, why, and how much.

    effect: measured on rendered pictures (docs/algorithm.md has the set-up and the whole table):
    the share of target-frames within 100 mm, mean of five scenarios of 10 tuning seeds each, with
    all other fields as in 'thesis', which has 94.4 %.
    """

    name: str
    thesis: str
    ours: str
    reason: str
    effect: str


@dataclass(frozen=True)
class Preset:
    """A named pair of parameter records and the departures they stand for.

    The type of the tracker's record says which tracker and detector they are of.
    """

    name: str
    detector: DetectorParameters
    tracker: TrackerParameters | HypothesisParameters
    departures: tuple[Departure, ...]
