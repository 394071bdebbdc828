"""Charts of tracks in real footage: positions and status over time, and paths in 3-D."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from pjpdaf.arrays import Floats
from pjpdaf.targets import TARGETS
from reports.footage.track_record import Sample
from reports.page.charts.panel_chart import Panel, Span, panel_chart
from reports.page.charts.path_chart import CAMERA_AXES, path_chart
from reports.words import LABELS

MARKERS_UP_TO = 120  # samples; above, lines alone
BEGUN = ("tracked", "coasting", "lost")


def time_chart(samples: Sequence[Sample], missing_frames: Sequence[int]) -> Markup:
    """Draw x, y, z of each target over time, above lanes of its status.

    Hollow marks: coasting or lost. Frames with a missing picture are shaded.
    """
    points_m = _points_m(samples)
    titles = ("x, right [m]", "y, down [m]", "z, depth [m]")
    return panel_chart(
        np.array([s.time_s for s in samples]),
        [Panel(title, points_m[:, :, a], down=a == 1) for a, title in enumerate(titles)],
        status_spans(samples),
        hollow=np.array([[status != "tracked" for status in s.status] for s in samples]),
        shades=_missing_spans(samples, missing_frames),
        marks=len(samples) <= MARKERS_UP_TO,
    )


def paths_chart(samples: Sequence[Sample]) -> Markup:
    """Draw the paths in the left camera's frame, seen from behind the cameras."""
    return path_chart(None, 1000 * _points_m(samples), axes=CAMERA_AXES)


def _points_m(samples: Sequence[Sample]) -> Floats:
    return np.array([s.positions_m for s in samples]).reshape(-1, len(TARGETS), 3)


def status_spans(samples: Sequence[Sample]) -> list[Span]:
    """The times for which each target kept a status; a sample lasts until the next one."""
    ends_s = [s.time_s for s in samples[1:]]
    step_s = samples[1].time_s - samples[0].time_s if len(samples) > 1 else 1.0
    ends_s.append(samples[-1].time_s + step_s)
    spans = []
    for t, target in enumerate(TARGETS):
        first = 0
        for i, sample in enumerate(samples):
            status = sample.status[t]
            if i + 1 < len(samples) and samples[i + 1].status[t] == status:
                continue
            if status in BEGUN:
                start_s, end_s = samples[first].time_s, ends_s[i]
                text = f"{LABELS[target]} {status}, {start_s:.2f} to {end_s:.2f} s"
                spans.append(Span(target, status, start_s, end_s, text))
            first = i + 1
    return spans


def _missing_spans(samples: Sequence[Sample], frames: Sequence[int]) -> list[tuple[float, float]]:
    """The times of frames with a missing picture."""
    if len(samples) < 2:
        return []
    period_s = (samples[1].time_s - samples[0].time_s) / (samples[1].frame - samples[0].frame)
    return [((frame - 0.5) * period_s, (frame + 0.5) * period_s) for frame in frames]
