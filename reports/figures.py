"""Plotly figures as plain JSON values: the thesis's Fig. 4.2-4.4 and the speed curve.

Colours are names ("@head", "@ink", ...) that the page turns into those of the reader's theme.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd

from pjpdaf.targets import TARGETS
from reports.tables import LABELS

Figure = dict[str, Any]

# Colour is never the only sign: each target has its own dash and marker as well.
DASHES = {"head": "solid", "right_hand": "dash", "left_hand": "dot"}
SYMBOLS = {"head": "circle", "right_hand": "square", "left_hand": "diamond"}
SPEED_LABEL = "speed:"


def error_figure(frames: pd.DataFrame, events: pd.DataFrame) -> Figure:
    """Error per frame of one episode (Fig. 4.3): Err_acc [px], 3-D error [mm], events below.

    frames, events: the episode's rows of a run's tables. Frames in which the hands or the head
    merge are shaded.
    """
    traces: list[Figure] = []
    panels = (("err_acc_px", "y", "Err_acc [px]"), ("error_mm", "y2", "3-D error [mm]"))
    for column, axis, title in panels:
        for target in TARGETS:
            mine = frames[frames["target"] == target]
            traces.append(
                {
                    "type": "scatter",
                    "mode": "lines+markers",
                    "name": LABELS[target],
                    "legendgroup": target,
                    "showlegend": axis == "y",
                    "x": [int(f) for f in mine["frame"]],
                    "y": numbers(mine[column], 2),
                    "xaxis": "x",
                    "yaxis": axis,
                    "line": {"color": f"@{target}", "dash": DASHES[target], "width": 1.8},
                    "marker": {"symbol": SYMBOLS[target], "size": 5, "color": f"@{target}"},
                    "hovertemplate": f"%{{y}} {title[-3:-1]}<extra>{LABELS[target]}</extra>",
                }
            )
    lanes = _event_traces(events)
    merged = merged_spans(frames)
    if merged:
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": "merged in a view",
                "x": [None],
                "y": [None],
                "marker": {"symbol": "square", "size": 12, "color": "@merged"},
                "hoverinfo": "skip",
            }
        )
    # From below: captures, losses, the swap on top; a lane for each that happens.
    names = sorted({lane["y"][0] for lane in lanes}, key=lambda n: (n.split()[-1], n))
    height = 460 + (60 + 22 * len(names) if lanes else 0)
    bottom = 1 - 400 / (height - 80) if lanes else 0.0
    half = (1.0 - bottom - 0.08) / 2
    layout: Figure = {
        "height": height,
        "margin": {"l": 104 if lanes else 62, "r": 12, "t": 34, "b": 46},
        "hovermode": "x unified",
        "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom"},
        "xaxis": {
            "title": {"text": "frame"},
            "anchor": "y3" if lanes else "y2",
            "gridcolor": "@grid",
            "zeroline": False,
        },
        "yaxis": _axis("Err_acc [px]", [1.0 - half, 1.0]),
        "yaxis2": _axis("3-D error [mm]", [bottom, bottom + half]),
        "shapes": [
            {
                "type": "rect",
                "xref": "x",
                "yref": "paper",
                "x0": first - 0.5,
                "x1": last + 0.5,
                "y0": bottom,
                "y1": 1,
                "fillcolor": "@merged",
                "line": {"width": 0},
                "layer": "below",
            }
            for first, last in merged
        ],
    }
    if lanes:
        layout["yaxis3"] = {
            "domain": [0.0, bottom - 40 / height],
            "type": "category",
            "categoryorder": "array",
            "categoryarray": names,
            "range": [-0.6, len(names) - 0.4],
            "fixedrange": True,
            "gridcolor": "@grid",
        }
    return {"data": [*traces, *lanes], "layout": layout}


def path_figure(frames: pd.DataFrame) -> Figure:
    """3-D paths of one episode (Fig. 4.2, 4.4): truth thin, estimates thick."""
    traces: list[Figure] = []
    for target in TARGETS:
        mine = frames[frames["target"] == target]
        for kind in ("truth", "estimate"):
            thick = kind == "estimate"
            traces.append(
                {
                    "type": "scatter3d",
                    "mode": "lines+markers" if thick else "lines",
                    "name": f"{LABELS[target]}, {kind}",
                    **{axis: numbers(mine[f"{kind}_{axis}_m"], 4) for axis in "xyz"},
                    "text": [f"frame {int(f)}" for f in mine["frame"]],
                    "line": {
                        "color": f"@{target}" if thick else f"@{target}_thin",
                        "width": 5 if thick else 2,
                    },
                    "marker": {
                        "symbol": SYMBOLS[target],
                        "size": 2.5 if thick else 1,
                        "color": f"@{target}",
                    },
                    "hovertemplate": "%{text}<br>%{x:.3f}, %{y:.3f}, %{z:.3f} m",
                }
            )
    axes = {
        axis: {
            "title": {"text": f"{axis} [m]"},
            "gridcolor": "@grid",
            "color": "@ink",
            "showbackground": False,
            "nticks": 6,
        }
        for axis in "xyz"
    }
    layout: Figure = {
        "height": 460,
        "margin": {"l": 0, "r": 0, "t": 8, "b": 0},
        "legend": {"orientation": "h", "x": 0, "y": 0, "yanchor": "top"},
        "scene": {
            **{f"{axis}axis": value for axis, value in axes.items()},
            "aspectmode": "data",
            "camera": {"eye": {"x": 1.7, "y": -1.25, "z": 0.75}},
        },
    }
    return {"data": traces, "layout": layout}


def speed_figure(frames: pd.DataFrame) -> Figure | None:
    """Share of frames within 100 mm against the speed of the stroke, None without `speed:` labels.

    frames: rows of all seeds of a scenario. Frames without an estimate are not within.
    """
    speeds = label_speeds(frames["labels"])
    chosen = frames[np.isfinite(speeds)].assign(speed_mps=speeds[np.isfinite(speeds)])
    if chosen.empty:
        return None
    traces = []
    for target in TARGETS[1:]:
        mine = chosen[chosen["target"] == target]
        groups = mine.groupby("speed_mps", sort=True)["error_mm"]
        within = groups.apply(lambda e: float((e.to_numpy() <= 100.0).mean()))
        traces.append(
            {
                "type": "scatter",
                "mode": "lines+markers",
                "name": LABELS[target],
                "x": [float(s) for s in within.index],
                "y": numbers(within * 100, 2),
                "text": [f"{n} frames" for n in groups.size()],
                "line": {"color": f"@{target}", "dash": DASHES[target], "width": 2.2},
                "marker": {"symbol": SYMBOLS[target], "size": 8, "color": f"@{target}"},
                "hovertemplate": "%{x} m/s: %{y} % of %{text}",
            }
        )
    layout: Figure = {
        "height": 340,
        "margin": {"l": 62, "r": 12, "t": 34, "b": 46},
        "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom"},
        "xaxis": {
            "title": {"text": "speed of the stroke [m/s]"},
            "type": "log",
            "gridcolor": "@grid",
            "tickvals": sorted({float(s) for s in chosen["speed_mps"]}),
        },
        "yaxis": {**_axis("within 100 mm [%]", [0, 1]), "range": [-3, 103]},
    }
    return {"data": traces, "layout": layout}


def label_speeds(labels: pd.Series) -> np.ndarray:
    """Speed [m/s] of each row (n,) from a label such as "speed:0.5", NaN without one."""
    found = np.full(len(labels), np.nan)
    for i, text in enumerate(labels):
        for label in str(text).split(";"):
            if label.startswith(SPEED_LABEL):
                try:
                    found[i] = float(label.removeprefix(SPEED_LABEL))
                except ValueError:
                    continue
    found[~(found > 0)] = np.nan
    return found


def merged_spans(frames: pd.DataFrame) -> list[tuple[int, int]]:
    """First and last frame of every stretch in which any target is merged."""
    flags = frames.groupby("frame", sort=True)["merged"].any()
    spans: list[tuple[int, int]] = []
    for frame, merged in zip(flags.index, flags, strict=True):
        if not merged:
            continue
        if spans and spans[-1][1] == frame - 1:
            spans[-1] = (spans[-1][0], int(frame))
        else:
            spans.append((int(frame), int(frame)))
    return spans


def numbers(values: pd.Series, digits: int) -> list[float | None]:
    """JSON numbers; None where there is none, so that the line has a gap."""
    return [round(float(v), digits) if math.isfinite(v) else None for v in values]


def _axis(title: str, domain: list[float]) -> Figure:
    return {
        "title": {"text": title},
        "domain": domain,
        "rangemode": "tozero",
        "gridcolor": "@grid",
        "zerolinecolor": "@grid",
    }


def _event_traces(events: pd.DataFrame) -> list[Figure]:
    """A bar per event in the lane of its kind; empty without events."""
    verbs = {"swap": "swapped", "lost": "lost", "capture": "captured"}
    traces = []
    for event in events.itertuples():
        if event.kind not in verbs:
            continue
        who = LABELS[event.target]
        short = "hands" if event.kind == "swap" else who.removesuffix(" hand")
        words = {
            "swap": "right and left hand swapped",
            "lost": f"{who} lost",
            "capture": f"{who} captured by {LABELS.get(event.other, '?')}",
        }[event.kind]
        colour = "@ink" if event.kind == "swap" else f"@{event.target}"
        # Half a frame on either side, so that an event of one frame shows.
        x = [event.first_frame - 0.4, event.last_frame + 0.4]
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "x": x,
                "y": [f"{short} {verbs[event.kind]}"] * 2,
                "xaxis": "x",
                "yaxis": "y3",
                "showlegend": False,
                "line": {"color": colour, "width": 10},
                "opacity": 0.75,
                "name": words,
                "hovertemplate": f"{words}, frames {event.first_frame}-{event.last_frame}"
                "<extra></extra>",
            }
        )
    return traces
