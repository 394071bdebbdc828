"""The report page of real footage: no truth here, so it says what was found and shows it."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from rich import box
from rich.table import Table

from pjpdaf.arrays import Floats
from pjpdaf.camera import StereoRig
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import STATUSES, Detections, Estimates
from pjpdaf.targets import TARGETS
from reports.page.figures import DASHES, SYMBOLS, Figure
from reports.page.page import asset, render, shot
from reports.score.records import Picture
from reports.summary.tables import LABELS, count

MAX_SAMPLES = 2000  # of the curves; longer footage is thinned, so that memory and page stay small
MAX_EVEN_PICTURES = 12
MAX_EVENT_PICTURES = 5
MAX_NAMED = 20  # missing pictures that the page names
FILM_BYTES = 6_000_000  # a longer film is linked, not put inside
MARKERS_UP_TO = 300  # samples; above, lines alone


@dataclass(frozen=True, eq=False)
class Sample:
    """One frame of the curves: positions_m (T, 3)."""

    frame: int
    time_s: float
    positions_m: Floats
    status: tuple[str, ...]


@dataclass(frozen=True)
class TargetLine:
    """One target over the whole footage.

    Shares 0-1 of the frames since tracking began (of all frames while it never did); longest_gap_s:
    longest time without a frame "tracked"; sd_mm: mean standard deviation along x, y, z while
    tracked, NaN where it never was.
    """

    target: str
    frames: Mapping[str, int]
    shares: Mapping[str, float]
    longest_gap_s: float
    sd_mm: tuple[float, float, float]


class TrackRecord:
    """What the page needs of a run over footage, gathered frame by frame; its size is bounded."""

    def __init__(self, period_s: float) -> None:
        self.frames = 0
        self.missing_pictures = 0
        self.missing_frames: list[int] = []
        self.enough_seen = 0  # frames with three or more detections in every view
        self.first_frame: int | None = None
        self.first_s = float("nan")
        self.samples: list[Sample] = []
        self._period_s = period_s
        self._stride = 1
        self._counts = np.zeros((len(TARGETS), len(STATUSES)), dtype=np.int64)
        self._gap = np.zeros(len(TARGETS), dtype=np.int64)
        self._longest = np.zeros(len(TARGETS), dtype=np.int64)
        self._sd_sums_m = np.zeros((len(TARGETS), 3))
        self._gallery = _Gallery()

    def add(
        self,
        frame: StereoFrame,
        seen: Sequence[Detections],
        estimates: Estimates,
        picture: Callable[[], bytes],
    ) -> None:
        """The next frame; `picture` makes its JPEG, called only where the page shows it."""
        self.frames += 1
        missing = sum(p is None for p in frame.pictures)
        if missing and len(self.missing_frames) < MAX_NAMED:
            self.missing_frames.append(frame.index)
        self.missing_pictures += missing
        self.enough_seen += all(len(view) >= len(TARGETS) for view in seen)
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
        self._sample(frame, estimates)
        self._gallery.offer(frame, estimates, picture)

    @property
    def seconds(self) -> float:
        """Length of the footage."""
        return self.frames * self._period_s

    @property
    def pictures(self) -> list[tuple[str, Picture]]:
        """Caption and picture of the frames that the page shows, in order."""
        return self._gallery.chosen(self._period_s)

    def lines(self) -> list[TargetLine]:
        """The summary, one line a target."""
        found = []
        for t, target in enumerate(TARGETS):
            frames = dict(zip(STATUSES, self._counts[t].tolist(), strict=True))
            live = self.frames - frames["waiting"]
            of = {s: max(live, 1) for s in STATUSES} | {"waiting": max(self.frames, 1)}
            n = frames["tracked"]
            sd = self._sd_sums_m[t] * 1000 / n if n else np.full(3, np.nan)
            found.append(
                TargetLine(
                    target,
                    frames,
                    {s: frames[s] / of[s] for s in STATUSES},
                    float(self._longest[t] * self._period_s),
                    (float(sd[0]), float(sd[1]), float(sd[2])),
                )
            )
        return found

    def verdict(self) -> str:
        """The summary in one or two sentences."""
        if self.first_frame is None:
            return (
                "Tracking never began: it waits for a frame in which head and both hands are found "
                f"in both views. {count(self.enough_seen, 'frame')} of {self.frames} had three or "
                "more detections in both. The pictures show what was detected; a sample of the "
                "skin (--skin-sample) or a better background may help."
            )
        shares = ", ".join(
            f"{LABELS[line.target]} {100 * line.shares['tracked']:.0f}\N{NO-BREAK SPACE}%"
            for line in self.lines()
        )
        return (
            f"Tracking began at frame {self.first_frame} ({self.first_s:.1f} s). "
            f"Tracked in the frames from there on: {shares}."
        )

    def _sample(self, frame: StereoFrame, estimates: Estimates) -> None:
        if frame.index % self._stride:
            return
        if len(self.samples) == MAX_SAMPLES:
            self._stride *= 2
            self.samples = [s for s in self.samples if s.frame % self._stride == 0]
            if frame.index % self._stride:
                return
        positions = np.array(estimates.positions_m)
        self.samples.append(Sample(frame.index, frame.time_s, positions, estimates.status))


class _Gallery:
    """Evenly spaced frames of footage of unknown length, and those in which something changes."""

    def __init__(self) -> None:
        self._stride = 1
        self._even: dict[int, Picture] = {}
        self._events: dict[int, tuple[str, Picture]] = {}
        self._told: set[str] = set()

    def offer(self, frame: StereoFrame, estimates: Estimates, picture: Callable[[], bytes]) -> None:
        news = self._news(frame, estimates)
        wanted = frame.index % self._stride == 0
        if wanted and len(self._even) == MAX_EVEN_PICTURES:
            self._stride *= 2
            self._even = {i: p for i, p in self._even.items() if i % self._stride == 0}
            wanted = frame.index % self._stride == 0
        if not (news or wanted):
            return
        shown = Picture(frame.index, picture())
        if wanted:
            self._even[frame.index] = shown
        if news:
            self._events[frame.index] = (", ".join(news), shown)

    def chosen(self, period_s: float) -> list[tuple[str, Picture]]:
        pictures = self._even | {i: p for i, (_, p) in self._events.items()}
        found = []
        for index, shown in sorted(pictures.items()):
            words = self._events[index][0] if index in self._events else ""
            caption = f"frame {index}, {index * period_s:.1f} s"
            found.append((f"{caption}: {words}" if words else caption, shown))
        return found

    def _news(self, frame: StereoFrame, estimates: Estimates) -> list[str]:
        """What happens here for the first time."""
        if len(self._events) >= MAX_EVENT_PICTURES:
            return []
        now = []
        if "waiting" not in estimates.status:
            now.append("tracking begins")
        if any(p is None for p in frame.pictures):
            now.append("picture missing")
        now += [
            f"{LABELS[target]} lost"
            for target, status in zip(TARGETS, estimates.status, strict=True)
            if status == "lost"
        ]
        news = [words for words in now if words not in self._told]
        self._told.update(now)
        return news


@dataclass(frozen=True, eq=False)
class TrackFacts:
    """What the page says of a run besides its record.

    title; complete: the footage was tracked to its end; film: in the page's folder, or None;
    rig; sources: (what, value) of the footage; parameters, changed: of detector and tracker;
    provenance: as `reports.run.provenance`.
    """

    title: str
    complete: bool
    film: Path | None
    rig: StereoRig
    sources: Sequence[tuple[str, str]]
    parameters: Mapping[str, Any]
    changed: Mapping[str, Any]
    provenance: Mapping[str, Any] = field(default_factory=dict)


def track_page(record: TrackRecord, facts: TrackFacts) -> str:
    """The page of footage: one self-contained HTML text."""
    figures = {
        "paths-0": paths_figure(record.samples),
        "time-0": time_figure(record.samples, record.missing_frames),
    }
    film = facts.film
    inside = film is not None and film.stat().st_size <= FILM_BYTES
    return render(
        "track.html.j2",
        figures,
        track_css=asset("track.css"),
        record=record,
        facts=facts,
        lines=record.lines(),
        statuses=STATUSES,
        shots=[shot(caption, picture.jpeg) for caption, picture in record.pictures],
        film=film.name if film is not None else "",
        film_type="video/mp4" if film is not None and film.suffix == ".mp4" else "video/webm",
        film_data=base64.b64encode(film.read_bytes()).decode() if film and inside else "",
        baseline_mm=1000 * float(np.linalg.norm(facts.rig.T)),
        more_missing=max(0, record.missing_pictures - len(record.missing_frames)),
        thinned=record.frames > len(record.samples),
        count=count,
    )


def status_table(record: TrackRecord) -> Table:
    """The summary for the terminal."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("target")
    for status in STATUSES[1:]:
        table.add_column(status, justify="right")
    table.add_column("waiting", justify="right")
    table.add_column("longest gap", justify="right")
    table.add_column("sd x, y, z [mm]", justify="right")
    for line in record.lines():
        sd = ", ".join("-" if np.isnan(v) else f"{v:.0f}" for v in line.sd_mm)
        shares = [f"{100 * line.shares[status]:.1f} %" for status in STATUSES[1:]]
        waiting = count(line.frames["waiting"], "frame")
        table.add_row(LABELS[line.target], *shares, waiting, f"{line.longest_gap_s:.1f} s", sd)
    return table


def paths_figure(samples: Sequence[Sample]) -> Figure:
    """3-D paths in the left camera's frame, seen from behind the camera."""
    traces: list[Figure] = []
    for t, target in enumerate(TARGETS):
        places = _columns(samples, t)
        traces.append(
            {
                "type": "scatter3d",
                "mode": "lines+markers" if len(samples) <= MARKERS_UP_TO else "lines",
                "name": LABELS[target],
                "x": places[0],
                "y": places[2],  # depth runs away from the viewer
                "z": places[1],
                "text": [f"frame {s.frame}, {s.time_s:.2f} s, {s.status[t]}" for s in samples],
                "line": {"color": f"@{target}", "width": 4},
                "marker": {"symbol": SYMBOLS[target], "size": 2.5, "color": f"@{target}"},
                "hovertemplate": "%{text}<br>x %{x:.3f}, y %{z:.3f}, z %{y:.3f} m",
            }
        )
    names = {"x": "x, right [m]", "y": "z, depth [m]", "z": "y, down [m]"}
    axes: dict[str, Figure] = {
        f"{axis}axis": {
            "title": {"text": words},
            "gridcolor": "@grid",
            "color": "@ink",
            "showbackground": False,
            "nticks": 6,
        }
        for axis, words in names.items()
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
    """x, y, z of each target over time, and a bar of what it was: tracked, coasting, lost."""
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
    words = {"y": "x, right [m]", "y2": "y, down [m]", "y3": "z, depth [m]"}
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
    for axis, title in words.items():
        layout[axis.replace("y", "yaxis")] = {
            "title": {"text": title},
            "domain": domains[axis],
            "gridcolor": "@grid",
            "zeroline": False,
        }
    layout["yaxis2"]["autorange"] = "reversed"  # up in the picture is up here
    return {"data": traces, "layout": layout}


def _columns(samples: Sequence[Sample], target: int) -> list[list[float | None]]:
    """x, y and z of a target; None where there is none, so that the line has a gap."""
    points = np.array([s.positions_m[target] for s in samples]).reshape(-1, 3)
    return [[round(v, 4) if np.isfinite(v) else None for v in axis] for axis in points.T.tolist()]


def _bars(samples: Sequence[Sample]) -> list[Figure]:
    """Per target and status one trace of bars; each sample's bar lasts to the next."""
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
    """Shading where a picture is missing."""
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
