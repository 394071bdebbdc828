"""Share of frames within 100 mm against the speed of the stroke."""

from __future__ import annotations

import numpy as np
import pandas as pd
from markupsafe import Markup

from pjpdaf.targets import TARGETS
from reports.page.charts.line_chart import Series, line_chart
from reports.words import LABELS
from sim.event_names import stroke_speed_mps


def speed_chart(frames: pd.DataFrame) -> Markup | None:
    """Draw the share of frames within 100 mm against the speed, None without strokes.

    frames: rows of all seeds of a scenario. Frames without an estimate are not within.
    """
    series = speed_series(frames)
    if not series:
        return None
    ticks = sorted({float(s) for line in series for s in line.x})
    return line_chart(
        series,
        ("speed of the stroke [m/s]", "within 100 mm [%]"),
        log_x=True,
        y_range=(0.0, 103.0),
        x_ticks=ticks,
    )


def speed_series(frames: pd.DataFrame) -> list[Series]:
    """A line per hand: speeds [m/s], frames within 100 mm [%]; empty without strokes."""
    speeds = label_speeds(frames["labels"])
    chosen = frames[np.isfinite(speeds)].assign(speed_mps=speeds[np.isfinite(speeds)])
    series = []
    for target in TARGETS[1:] if len(chosen) else ():
        groups = chosen[chosen["target"] == target].groupby("speed_mps", sort=True)["error_mm"]
        within = groups.apply(lambda e: 100.0 * float((e.to_numpy() <= 100.0).mean()))
        texts = tuple(
            f"{LABELS[target]}, {speed:g} m/s: {share:.1f} % of {n} frames"
            for (speed, share), n in zip(within.items(), groups.size(), strict=True)
        )
        x = np.array(within.index, dtype=np.float64)
        series.append(Series(target, x, within.to_numpy(dtype=np.float64), texts))
    return series


def label_speeds(labels: pd.Series) -> np.ndarray:
    """Speed of the stroke [m/s] in each row (n,) of the column `labels`, NaN without a stroke."""
    speeds = [[stroke_speed_mps(name) for name in str(text).split(";")] for text in labels]
    # Of several the last counts.
    return np.array([([np.nan] + [s for s in row if s == s])[-1] for row in speeds])
