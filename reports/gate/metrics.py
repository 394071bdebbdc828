"""The metrics that the gate judges, and their margins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.errors import BenchError, did_you_mean
from reports.score.gospa import CUT_OFF_M

REACH = 10.0  # margins; see Metric.reach


@dataclass(frozen=True)
class Metric:
    """A measure of an episode; more is always worse.

    margin: the greatest difference of the means that does not matter, in `unit`. short: it in a few
    words, without a comma; meaning: its definition in words. event: it happens
    in an episode or not. counted: judged by its count alone, not as a sample. reach: the most that
    the difference of one episode counts; beyond it the episode was lost or swapped, which other
    metrics count, and a few such episodes would hide a change in all others.
    """

    name: str
    unit: str
    margin: float
    short: str
    meaning: str
    event: bool = False
    counted: bool = False
    reach: float = float("inf")


METRICS = (
    Metric(
        "error_mm",
        "mm",
        3.0,
        "3-D error",
        "median 3-D error of a target, mean over the targets",
        reach=30.0,
    ),
    Metric(
        "missed",
        "1",
        0.02,
        "share beyond 100 mm",
        "share of target-frames not within 100 mm",
        reach=0.2,
    ),
    Metric(
        "err_acc_px",
        "px",
        0.5,
        "error in the picture",
        "median distance in the picture (Eq. 4.1), mean over targets",
        reach=5.0,
    ),
    Metric(
        "gospa_mm",
        "mm",
        4.0,
        "GOSPA",
        f"mean GOSPA of a frame, cut-off {CUT_OFF_M * 1000:.0f} mm",
        reach=40.0,
    ),
    Metric(
        "swapped",
        "1",
        0.02,
        "swapped hands",
        "episodes in which the hands were swapped",
        event=True,
    ),
    Metric("lost", "1", 0.02, "lost targets", "episodes in which a target was lost", event=True),
    Metric(
        "failed",
        "1",
        0.0,
        "episodes without a result",
        "episodes that gave a result in the base only",
        event=True,
        counted=True,
    ),
)


def with_margins(margins: Mapping[str, float]) -> tuple[Metric, ...]:
    """Give metrics other margins, by name. Raises BenchError for unknown names, margins < 0."""
    known = {metric.name: metric for metric in METRICS}
    for name, margin in margins.items():
        if name not in known:
            raise BenchError(f"No metric {name[:60]!r}.{did_you_mean(name, known)}")
        if not (np.isfinite(margin) and margin >= 0):
            raise BenchError(f"margin of {name} must be a number of 0 or more, got {margin}")
    metrics = []
    for metric in METRICS:
        margin = float(margins.get(metric.name, metric.margin))
        metrics.append(replace(metric, margin=margin, reach=max(metric.reach, REACH * margin)))
    return tuple(metrics)
