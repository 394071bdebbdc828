"""Charts of the report as SVG: the speed curve, errors per frame, paths in 3-D, stacked bars.

Colours are the page's own (classes `head`, `right_hand`, `left_hand`, ...), so that they follow the
reader's theme and print; a target has its own dash and marker as well: colour is never the only
sign.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup, escape

from pjpdaf.arrays import Floats
from pjpdaf.targets import TARGETS
from reports.summary.tables import LABELS
from sim.event_names import stroke_speed_mps

Figure = dict[str, Any]

# Of plotly, where footage is drawn (`track_page`).
DASHES = {"head": "solid", "right_hand": "dash", "left_hand": "dot"}
SYMBOLS = {"head": "circle", "right_hand": "square", "left_hand": "diamond"}
WIDTH = 480  # of a chart, in its own units; text is 13 of these high
_LEFT, _RIGHT, _TOP, _BOTTOM = 52, 12, 30, 44
# View of the 3-D paths: columns are the world's x, y, z in the picture (right, up).
_VIEW = np.array([[-0.62, 0.78, 0.0], [-0.30, -0.24, 0.92]])


@dataclass(frozen=True, eq=False)
class Series:
    """A line of a chart: x, y (n,), NaN where it has a gap; words (n,) say what a point is."""

    target: str
    x: Floats
    y: Floats
    words: tuple[str, ...] = ()


def line_chart(
    series: Sequence[Series],
    titles: tuple[str, str],
    *,
    log_x: bool = False,
    y_range: tuple[float, float] | None = None,
    x_ticks: Sequence[float] | None = None,
    marks: bool = True,
    limit: tuple[float, str] | None = None,
    height: int = 300,
) -> Markup:
    """Lines over x. titles: of x and y; limit: a level and what it is; marks: a marker a point.

    y_range: of the axis, else from 0 to the largest value.
    """
    xs = np.concatenate([s.x for s in series]) if series else np.zeros(0)
    ys = np.concatenate([s.y for s in series]) if series else np.zeros(0)
    ys = ys[np.isfinite(ys)]
    top = max([float(ys.max())] if len(ys) else [1.0], default=1.0)
    if limit is not None:
        top = max(top, limit[0])
    low, high = y_range or (0.0, top * 1.05 or 1.0)
    x0, x1 = (float(xs.min()), float(xs.max())) if len(xs) else (0.0, 1.0)
    if x0 == x1:
        x0, x1 = x0 / 1.2, x1 * 1.2 or 1.0
    x_axis = _Axis(x0, x1, _LEFT + 6, WIDTH - _RIGHT - 6, log_x)
    y_axis = _Axis(low, high, height - _BOTTOM, _TOP)
    parts = [_frame(x_axis, y_axis, titles, x_ticks, height)]
    if limit is not None:
        y = y_axis.at(limit[0])
        parts.append(
            f'<line class="limit" x1="{_LEFT}" x2="{WIDTH - _RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>'
            f'<text class="soft" x="{WIDTH - _RIGHT}" y="{y - 5:.1f}" text-anchor="end">'
            f"{escape(limit[1])}</text>"
        )
    for line in series:
        places = np.column_stack([x_axis.all(line.x), y_axis.all(np.clip(line.y, low, high))])
        parts.append(f'<path class="line {line.target}" d="{path_data(places)}"/>')
        if marks:
            parts += [
                marker(line.target, x, y, 4.5, line.words[i] if line.words else "")
                for i, (x, y) in enumerate(places.tolist())
                if math.isfinite(y)
            ]
    parts.append(_legend([s.target for s in series]))
    return svg(parts, height, f"{titles[1]} against {titles[0]}")


def speed_chart(frames: pd.DataFrame) -> Markup | None:
    """Share of frames within 100 mm against the speed of the stroke, None without `speed:` labels.

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
    """Per hand: speeds [m/s] and the share of frames within 100 mm [%]; empty without labels."""
    speeds = label_speeds(frames["labels"])
    chosen = frames[np.isfinite(speeds)].assign(speed_mps=speeds[np.isfinite(speeds)])
    found = []
    for target in TARGETS[1:] if len(chosen) else ():
        groups = chosen[chosen["target"] == target].groupby("speed_mps", sort=True)["error_mm"]
        within = groups.apply(lambda e: 100.0 * float((e.to_numpy() <= 100.0).mean()))
        words = tuple(
            f"{LABELS[target]}, {speed:g} m/s: {share:.1f} % of {n} frames"
            for (speed, share), n in zip(within.items(), groups.size(), strict=True)
        )
        x = np.array(within.index, dtype=np.float64)
        found.append(Series(target, x, within.to_numpy(dtype=np.float64), words))
    return found


def path_chart(truth_mm: Floats, said_mm: Floats, height: int = 340) -> Markup:
    """3-D paths (F, T, 3) [mm] in an oblique view: estimates in colour, truth thin (Fig. 4.2, 4.4).

    World axes: x towards the cameras, y to the person's left, z up. What strays farther than
    300 mm from the box of the truth is cut off.
    """
    flat = truth_mm.reshape(-1, 3)
    low = np.floor(flat.min(axis=0) / 100 - 0.5) * 100
    high = np.ceil(flat.max(axis=0) / 100 + 0.5) * 100
    near = (said_mm > low - 300) & (said_mm < high + 300)
    said_mm = np.where(near.all(axis=-1, keepdims=True), said_mm, np.nan)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    box = (low + corners * (high - low)) @ _VIEW.T
    scale = min((WIDTH - 2 * 46) / np.ptp(box[:, 0]), (height - _TOP - 40) / np.ptp(box[:, 1]))
    middle = (box.max(axis=0) + box.min(axis=0)) / 2
    centre = np.array([WIDTH / 2, (_TOP + height - 14) / 2])

    def place(points_mm: Floats) -> Floats:
        return np.asarray(centre + (points_mm @ _VIEW.T - middle) * [scale, -scale])

    parts = [_box(low, high, place)]
    for kind, paths in (("said", said_mm), ("truth", truth_mm)):
        for t, target in enumerate(TARGETS):
            line = path_data(place(paths[:, t]))
            parts.append(f'<path class="line {kind} {target}" d="{line}"/>')
    for t, target in enumerate(TARGETS):
        there = said_mm[np.isfinite(said_mm[:, t]).all(axis=1), t]
        if len(there):
            x, y = place(there[-1])
            parts.append(marker(target, float(x), float(y), 5.0, f"{LABELS[target]}, last frame"))
    parts.append(_legend(TARGETS))
    return svg(parts, height, "Paths of head and hands in 3-D: estimates in colour, truth thin")


def stacked_bars(parts_mm: Mapping[str, Mapping[str, float]]) -> Markup:
    """A bar a target, stacked from parts [mm] in their order, with the number in each part.

    Negative parts are left out of the bar; a line stands where the sum of all parts is.
    """
    drawn = {t: sum(_part(values, t) for values in parts_mm.values()) for t in TARGETS}
    axis = _Axis(0.0, max(drawn.values(), default=0.0) * 1.1 or 1.0, 96, WIDTH - _RIGHT)
    height = 66 + 34 * len(TARGETS)
    parts = []
    for tick in axis.ticks():
        x = axis.at(tick)
        parts.append(
            f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="8" y2="{height - 42}"/>'
            f'<text x="{x:.1f}" y="{height - 26}" text-anchor="middle">{tick:g}</text>'
        )
    for t, target in enumerate(TARGETS):
        y = 14 + 34 * t
        parts.append(f'<text x="90" y="{y + 16}" text-anchor="end">{LABELS[target]}</text>')
        start = 0.0
        for n, (name, values) in enumerate(parts_mm.items()):
            size = _part(values, target)
            x0, x1 = axis.at(start), axis.at(start + size)
            start += size
            parts.append(
                f'<rect class="part part-{n % 6}" x="{x0:.1f}" y="{y}" width="{x1 - x0:.1f}" '
                f'height="24"><title>{escape(name)}, {LABELS[target]}: {size:.1f} mm</title></rect>'
            )
            if x1 - x0 > 30:
                parts.append(
                    f'<text class="inside inside-{n % 6}" x="{x0 + 6:.1f}" y="{y + 16}">'
                    f"{size:.0f}</text>"
                )
        total = axis.at(sum(values.get(target, 0.0) for values in parts_mm.values()))
        parts.append(
            f'<line class="sum" x1="{total:.1f}" x2="{total:.1f}" y1="{y - 4}" y2="{y + 28}"/>'
        )
    middle = (96 + WIDTH) / 2
    parts.append(f'<text x="{middle:.0f}" y="{height - 6}" text-anchor="middle">mm</text>')
    return svg(parts, height, "Error budget of each target in millimetres")


def label_speeds(labels: pd.Series) -> np.ndarray:
    """Speed of the stroke [m/s] in each row (n,) of the column `labels`, NaN without a stroke."""
    speeds = [[stroke_speed_mps(name) for name in str(text).split(";")] for text in labels]
    # Of several the last counts.
    return np.array([([np.nan] + [s for s in row if s == s])[-1] for row in speeds])


def path_data(places: Floats) -> str:
    """SVG path through points (n, 2), lifted where one is NaN."""
    words, down = [], False
    for x, y in places.tolist():
        if math.isfinite(x) and math.isfinite(y):
            words.append(f"{'L' if down else 'M'}{x:.1f} {y:.1f}")
            down = True
        else:
            down = False
    return "".join(words)


def marker(target: str, x: float, y: float, size: float, words: str = "") -> str:
    """A target's marker: circle, square or diamond."""
    title = f"<title>{escape(words)}</title>" if words else ""
    if target == TARGETS[0]:
        return (
            f'<circle class="mark {target}" cx="{x:.1f}" cy="{y:.1f}" r="{size}">{title}</circle>'
        )
    turn = f' transform="rotate(45 {x:.1f} {y:.1f})"' if target == TARGETS[2] else ""
    return (
        f'<rect class="mark {target}" x="{x - size:.1f}" y="{y - size:.1f}" '
        f'width="{2 * size}" height="{2 * size}"{turn}>{title}</rect>'
    )


def svg(parts: Sequence[str], height: int, label: str) -> Markup:
    """A chart of `WIDTH` x height from its elements; label: in words what it shows."""
    # Names from outside went through `escape` where they were put in.
    return Markup(
        f'<svg class="chart" viewBox="0 0 {WIDTH} {height}" role="img" '
        f'aria-label="{escape(label)}">{"".join(parts)}</svg>'
    )


@dataclass(frozen=True)
class _Axis:
    """Values low..high on places start..end."""

    low: float
    high: float
    start: float
    end: float
    log: bool = False

    def all(self, values: Floats) -> Floats:
        low, high = self.low, self.high
        if self.log:
            values, low, high = np.log(values), math.log(low), math.log(high)
        return np.asarray(self.start + (values - low) / (high - low) * (self.end - self.start))

    def at(self, value: float) -> float:
        return float(self.all(np.array(value)))

    def ticks(self) -> list[float]:
        """Round values, about five."""
        step = round_step((self.high - self.low) / 5)
        first = math.ceil(self.low / step - 1e-9)
        last = math.floor(self.high / step + 1e-9)
        return [round(i * step, 10) for i in range(first, last + 1)]


def round_step(least: float) -> float:
    """1, 2 or 5 times a power of ten, at least `least`."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(f * power for f in (1.0, 2.0, 5.0, 10.0) if f * power >= least * (1 - 1e-9))


def _frame(
    x_axis: _Axis,
    y_axis: _Axis,
    titles: tuple[str, str],
    x_ticks: Sequence[float] | None,
    height: int,
) -> str:
    """Grid, ticks and titles."""
    parts = []
    bottom = height - _BOTTOM
    for tick in y_axis.ticks():
        y = y_axis.at(tick)
        parts.append(
            f'<line class="grid" x1="{_LEFT}" x2="{WIDTH - _RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>'
            f'<text x="{_LEFT - 7}" y="{y + 4:.1f}" text-anchor="end">{tick:g}</text>'
        )
    for tick in x_axis.ticks() if x_ticks is None else x_ticks:
        x = x_axis.at(tick)
        parts.append(
            f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="{_TOP}" y2="{bottom}"/>'
            f'<text x="{x:.1f}" y="{bottom + 17}" text-anchor="middle">{tick:g}</text>'
        )
    middle = (_TOP + bottom) / 2
    parts.append(
        f'<text x="{(_LEFT + WIDTH - _RIGHT) / 2}" y="{height - 8}" text-anchor="middle">'
        f"{escape(titles[0])}</text>"
        f'<text transform="translate(14 {middle}) rotate(-90)" text-anchor="middle">'
        f"{escape(titles[1])}</text>"
    )
    return "".join(parts)


def _legend(targets: Sequence[str]) -> str:
    parts, x = [], float(_LEFT)
    for target in dict.fromkeys(targets):
        parts.append(
            f'<path class="line {target}" d="M{x:.0f} 14H{x + 26:.0f}"/>'
            + marker(target, x + 13, 14, 4)
            + f'<text x="{x + 32:.0f}" y="18">{LABELS[target]}</text>'
        )
        x += 48 + 7.2 * len(LABELS[target])
    return "".join(parts)


def _box(low: Floats, high: Floats, place: Any) -> str:
    """Floor grid of a 3-D box with its axes and their ticks [mm]."""
    parts = []
    step = round_step(float((high - low).max()) / 5)
    edges: list[tuple[int, int, Floats]] = [
        # axis along which the ticks run, axis of the grid lines, where the third one stands
        (0, 1, low),
        (1, 0, low),
    ]
    for along, across, fixed in edges:
        for value in np.arange(np.ceil(low[along] / step) * step, high[along] + 1, step):
            ends = np.array([fixed, fixed], dtype=np.float64)
            ends[:, along] = value
            ends[:, across] = low[across], high[across]
            parts.append(f'<path class="grid" d="{path_data(place(ends))}"/>')
            x, y = place(ends[1])
            anchor = "start" if along == 0 else "end"
            shift = 6 if along == 0 else -6
            parts.append(
                f'<text class="soft" x="{x + shift:.1f}" y="{y + 10:.1f}" text-anchor="{anchor}">'
                f"{value + 0.0:g}</text>"
            )
    for value in np.arange(np.ceil(low[2] / step) * step, high[2] + 1, step):
        at = place(np.array([low[0], high[1], value]))
        parts.append(
            f'<text class="soft" x="{at[0] + 6:.1f}" y="{at[1] + 4:.1f}">{value + 0.0:g}</text>'
        )
    upright = np.array([[low[0], high[1], low[2]], [low[0], high[1], high[2]]])
    parts.append(f'<path class="grid" d="{path_data(place(upright))}"/>')
    names = {
        "x [mm]": (np.array([(low[0] + high[0]) / 2, high[1], low[2]]), 44, 24),
        "y [mm]": (np.array([high[0], (low[1] + high[1]) / 2, low[2]]), -40, 24),
        "z [mm]": (np.array([low[0], high[1], high[2]]), -8, -8),
    }
    for words, (point, dx, dy) in names.items():
        x, y = place(point)
        parts.append(f'<text x="{x + dx:.1f}" y="{y + dy:.1f}" text-anchor="middle">{words}</text>')
    return "".join(parts)


def _part(values: Mapping[str, float], target: str) -> float:
    return max(0.0, float(values.get(target, 0.0)))
