"""Plots of tracks in real footage, as figures of plotly.js."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pjpdaf.targets import TARGETS
from reports.footage.track_record import Sample
from reports.words import LABELS

Figure = dict[str, Any]

DASHES = {"head": "solid", "right_hand": "dash", "left_hand": "dot"}
SYMBOLS = {"head": "circle", "right_hand": "square", "left_hand": "diamond"}
MARKERS_UP_TO = 300  # samples; above, lines alone


def paths_figure(samples: Sequence[Sample]) -> Figure:
    """Plot 3-D paths in the left camera's frame, seen from behind the camera."""
    traces: list[Figure] = []
    for t, target in enumerate(TARGETS):
        x, y, z = _columns(samples, t)
        traces.append(
            {
                "type": "scatter3d",
                "mode": "lines+markers" if len(samples) <= MARKERS_UP_TO else "lines",
                "name": LABELS[target],
                "x": x,
                "y": z,  # depth runs away from the viewer
                "z": y,
                "text": [f"frame {s.frame}, {s.time_s:.2f} s, {s.status[t]}" for s in samples],
                "line": {"color": f"@{target}", "width": 4},
                "marker": {"symbol": SYMBOLS[target], "size": 2.5, "color": f"@{target}"},
                "hovertemplate": "%{text}<br>x %{x:.3f}, y %{z:.3f}, z %{y:.3f} m",
            }
        )
    titles = {"x": "x, right [m]", "y": "z, depth [m]", "z": "y, down [m]"}
    axes: dict[str, Figure] = {
        f"{axis}axis": {
            "title": {"text": title},
            "gridcolor": "@grid",
            "color": "@ink",
            "showbackground": False,
            "nticks": 6,
        }
        for axis, title in titles.items()
    }
    axes["zaxis"]["autorange"] = "reversed"
    layout: Figure = {
        "height": 560,
        "margin": {"l": 0, "r": 0, "t": 8, "b": 0},
        "legend": {"orientation": "h", "x": 0, "y": 0, "yanchor": "top"},
        "scene": {
            **axes,
            "aspectmode": "data",
            "camera": {"eye": {"x": -1.0, "y": -2.25, "z": 0.75}},
        },
    }
    return {"data": traces, "layout": layout}


def time_figure(samples: Sequence[Sample], missing_frames: Sequence[int]) -> Figure:
    """Plot x, y, z of each target over time, above bars of its status."""
    times = [round(s.time_s, 4) for s in samples]
    domains = {"y": [0.78, 1.0], "y2": [0.5, 0.72], "y3": [0.22, 0.44], "y4": [0.0, 0.13]}
    traces: list[Figure] = []
    for t, target in enumerate(TARGETS):
        for axis, values in zip(("y", "y2", "y3"), _columns(samples, t), strict=True):
            traces.append(
                {
                    "type": "scatter",
                    "mode": "lines+markers" if len(samples) <= MARKERS_UP_TO else "lines",
                    "name": LABELS[target],
                    "legendgroup": target,
                    "showlegend": axis == "y",
                    "x": times,
                    "y": values,
                    "xaxis": "x",
                    "yaxis": axis,
                    "line": {"color": f"@{target}", "dash": DASHES[target], "width": 1.8},
                    "marker": {
                        "symbol": [
                            SYMBOLS[target]
                            + ("-open" if s.status[t] in ("coasting", "lost") else "")
                            for s in samples
                        ],
                        "size": 5,
                        "color": f"@{target}",
                    },
                    "hovertemplate": f"%{{y:.3f}} m<extra>{LABELS[target]}</extra>",
                }
            )
    traces += _bars(samples)
    titles = {"y": "x, right [m]", "y2": "y, down [m]", "y3": "z, depth [m]"}
    layout: Figure = {
        "height": 660,
        "margin": {"l": 84, "r": 12, "t": 34, "b": 46},
        "hovermode": "closest",
        "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom"},
        "xaxis": {
            "title": {"text": "time [s]"},
            "anchor": "y4",
            "gridcolor": "@grid",
            "zeroline": False,
        },
        "yaxis4": {
            "domain": domains["y4"],
            "type": "category",
            "categoryorder": "array",
            "categoryarray": [LABELS[target] for target in reversed(TARGETS)],
            "range": [-0.6, len(TARGETS) - 0.4],
            "fixedrange": True,
            "gridcolor": "@grid",
        },
        "shapes": _missing_marks(samples, missing_frames),
    }
    for axis, title in titles.items():
        layout[axis.replace("y", "yaxis")] = {
            "title": {"text": title},
            "domain": domains[axis],
            "gridcolor": "@grid",
            "zeroline": False,
        }
    layout["yaxis2"]["autorange"] = "reversed"  # up in the picture is up here
    return {"data": traces, "layout": layout}


def _columns(samples: Sequence[Sample], target: int) -> list[list[float | None]]:
    """x, y and z of a target, None (a gap of the line) without an estimate."""
    points = np.array([s.positions_m[target] for s in samples]).reshape(-1, 3)
    return [[round(v, 4) if np.isfinite(v) else None for v in axis] for axis in points.T.tolist()]


def _bars(samples: Sequence[Sample]) -> list[Figure]:
    """A trace of bars per target and status; each sample's bar lasts to the next."""
    ends = [s.time_s for s in samples[1:]]
    step = samples[1].time_s - samples[0].time_s if len(samples) > 1 else 1.0
    ends.append(samples[-1].time_s + step if samples else 0.0)
    traces: list[Figure] = []
    for t, target in enumerate(TARGETS):
        colours = {"tracked": f"@{target}", "coasting": f"@{target}_thin", "lost": "@ink"}
        for status, colour in colours.items():
            x: list[float | None] = []
            for sample, end in zip(samples, ends, strict=True):
                if sample.status[t] != status:
                    continue
                start = round(sample.time_s, 4)
                if x and x[-2] == start:
                    x[-2] = round(end, 4)
                else:
                    x += [start, round(end, 4), None]
            if x:
                traces.append(
                    {
                        "type": "scatter",
                        "mode": "lines",
                        "x": x,
                        "y": [LABELS[target] if v is not None else None for v in x],
                        "xaxis": "x",
                        "yaxis": "y4",
                        "showlegend": False,
                        "line": {"color": colour, "width": 11},
                        "name": f"{LABELS[target]} {status}",
                        "hovertemplate": f"{LABELS[target]} {status}, %{{x:.2f}} s<extra></extra>",
                    }
                )
    return traces


def _missing_marks(samples: Sequence[Sample], frames: Sequence[int]) -> list[Figure]:
    """Shade the frames with a missing picture."""
    if len(samples) < 2:
        return []
    period_s = (samples[1].time_s - samples[0].time_s) / (samples[1].frame - samples[0].frame)
    return [
        {
            "type": "rect",
            "xref": "x",
            "yref": "paper",
            "x0": round((frame - 0.5) * period_s, 4),
            "x1": round((frame + 0.5) * period_s, 4),
            "y0": 0,
            "y1": 1,
            "fillcolor": "@merged",
            "line": {"width": 0},
            "layer": "below",
        }
        for frame in frames
    ]
