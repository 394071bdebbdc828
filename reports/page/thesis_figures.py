"""The thesis's Figures 4.1-4.7 from our own runs, beside what the thesis says about each.

The thesis counts frames from 1; so do these figures. Its numbers are those of its text and of the
axes of its plots; where it gives none, that is said.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND, TARGETS
from reports.page.figures import Series, line_chart, path_chart
from reports.page.player import Take
from reports.score.score import quantile
from reports.summary.tables import LABELS

NOT_STATED = "not stated"
HANDS = (RIGHT_HAND, LEFT_HAND)
ERR_ACC_AXIS_PX = 20.0  # where the axis of Fig. 4.3 ends

Facts = Callable[[Take], Mapping[str, str]]
Charts = Callable[[Take], Markup]


@dataclass(frozen=True)
class Comparison:
    """A row of a figure: what the thesis says of it, and each run ("-" without the episode)."""

    what: str
    thesis: str
    ours: tuple[str, ...]


@dataclass(frozen=True)
class ThesisFigure:
    """One figure. source: (run, scenario, seed) that it is drawn from, None where no run has one.

    frames: numbers of the frames that are shown as pictures; chart: the plot, where it is one;
    wanted: the scenarios that it can be made from.
    """

    number: str
    title: str
    source: tuple[int, str, int] | None
    frames: tuple[int, ...]
    chart: Markup | None
    rows: tuple[Comparison, ...]
    wanted: tuple[str, ...]


@dataclass(frozen=True)
class _Plan:
    number: str
    title: str
    scenarios: tuple[str, ...]
    thesis: Mapping[str, str]
    facts: Facts
    frames: Callable[[Take], Sequence[int]] | None = None
    chart: Charts | None = None


def thesis_figures(runs: Sequence[Mapping[tuple[str, int], Take]]) -> tuple[ThesisFigure, ...]:
    """All seven figures. runs: for each run its episodes by scenario and seed."""
    return tuple(_figure(plan, runs) for plan in _PLANS)


def _figure(plan: _Plan, runs: Sequence[Mapping[tuple[str, int], Take]]) -> ThesisFigure:
    found = [_first(run, plan.scenarios) for run in runs]
    facts = [plan.facts(take) if take is not None else {} for take in found]
    source, shown = next(
        (((r, take.scenario, take.seed), take) for r, take in enumerate(found) if take is not None),
        (None, None),
    )
    frames = plan.frames(shown) if plan.frames is not None and shown is not None else ()
    return ThesisFigure(
        number=plan.number,
        title=plan.title,
        source=source,
        frames=tuple(frames),
        chart=plan.chart(shown) if plan.chart is not None and shown is not None else None,
        rows=tuple(
            Comparison(what, said, tuple(f.get(what, "-") for f in facts))
            for what, said in plan.thesis.items()
        ),
        wanted=plan.scenarios,
    )


def _first(run: Mapping[tuple[str, int], Take], scenarios: Sequence[str]) -> Take | None:
    """The first seed of the first of these scenarios that the run has."""
    for name in scenarios:
        seeds = sorted(seed for scenario, seed in run if scenario == name)
        if seeds:
            return run[name, seeds[0]]
    return None


def _same_frames(*numbers: int) -> Callable[[Take], tuple[int, ...]]:
    """The frames that the thesis shows, as far as the episode has them."""

    def chosen(take: Take) -> tuple[int, ...]:
        there = set(take.index.tolist())
        return tuple(n - 1 for n in numbers if n - 1 in there)

    return chosen


def _accuracy(take: Take) -> Mapping[str, str]:
    return {
        "frames": str(len(take.index)),
        "targets lost or swapped": _wrong(take),
        "median 3-D error, head / right / left": _each(take, "error_mm", 0.5, "mm"),
    }


def _extent(take: Take) -> Mapping[str, str]:
    """Extents of the estimates along the left camera's axes, in the words of the plots' ticks."""
    said = take.points_mm("estimate")
    points = said[np.isfinite(said).all(axis=2)]
    if not len(points):
        return {}
    row = take.cameras[take.cameras["view"] == "left"].iloc[0]
    R_cw = np.array(row["R_cw"]).reshape(3, 3)
    seen = points @ R_cw.T + 1e3 * np.array(row["t_cw"])
    low, high = np.quantile(seen, [0.01, 0.99], axis=0)
    spans = [f"{a:.0f} to {b:.0f} mm" for a, b in zip(low, high, strict=True)]
    return {
        "across (x)": f"{spans[0]}, {high[0] - low[0]:.0f} wide",
        "down (y)": f"{spans[1]}, {high[1] - low[1]:.0f} high",
        "depth (z)": f"{spans[2]}, {high[2] - low[2]:.0f} deep",
        "trajectory": _roughness(take),
    }


def _roughness(take: Take) -> str:
    """Mean second difference of the right hand's path against that of its truth."""
    means = []
    for kind in ("estimate", "truth"):
        path = take.points_mm(kind)[:, RIGHT_HAND]
        jumps = np.linalg.norm(np.diff(path, n=2, axis=0), axis=1)
        jumps = jumps[np.isfinite(jumps)]
        means.append(float(jumps.mean()) if len(jumps) else float("nan"))
    return (
        f"right hand bends by {means[0]:.0f} mm a frame (mean second difference), "
        f"its truth by {means[1]:.0f}"
    )


def _per_frame(take: Take) -> Mapping[str, str]:
    errors = take.column("err_acc_px").astype(np.float64)
    over = np.nan_to_num(errors, nan=np.inf) > ERR_ACC_AXIS_PX
    spread = [quantile(errors[:, t], 0.9) - quantile(errors[:, t], 0.1) for t in range(3)]
    steady = "yes" if all(spread[HEAD] < spread[hand] for hand in HANDS) else "no"
    return {
        "frames": str(len(take.index)),
        "largest Err_acc, head / right / left": _each(take, "err_acc_px", 1.0, "px"),
        "median Err_acc, head / right / left": _each(take, "err_acc_px", 0.5, "px"),
        "above 20 px": f"{int(over.sum())} of {over.size} target-frames",
        "head steadier than the hands": f"{steady}: 10-90 % spread {_slashed(spread, 'px')}",
    }


def _drinking(take: Take) -> Mapping[str, str]:
    merged = take.column("merged").astype(bool)
    touch = merged[:, HEAD] & (merged[:, RIGHT_HAND] | merged[:, LEFT_HAND])
    after = take.index[touch].max() if touch.any() else None
    later = take.index > after if after is not None else np.zeros(len(take.index), dtype=bool)
    within = _within(take)
    return {
        "hand on the head": _spans(take.index[touch]) or "never",
        "within 100 mm meanwhile": _percent(within[touch]),
        "tracks after it": (
            f"{_percent(within[later])} within 100 mm" if later.any() else "no frame left"
        ),
        "targets lost or swapped": _wrong(take),
    }


def _hands_together(take: Take) -> np.ndarray:
    """Frames (F,) in which the hands merge, and the head with neither."""
    merged = take.column("merged").astype(bool)
    both: np.ndarray = merged[:, RIGHT_HAND] & merged[:, LEFT_HAND] & ~merged[:, HEAD]
    return both


def _merged_pair(take: Take) -> tuple[int, ...]:
    frames = take.index[_hands_together(take)]
    return (int(frames[0]),) if len(frames) else ()


def _segmentation(take: Take) -> Mapping[str, str]:
    frames = _merged_pair(take)
    if not frames:
        return {"both hands are one area": "never"}
    seen = take.seen[take.seen["frame"] == frames[0]]
    counts = [int((seen["view"] == view).sum()) for view in ("left", "right")]
    return {
        "both hands are one area": f"frames {_spans(take.index[_hands_together(take)])}",
        "detections in its first frame, left / right view": f"{counts[0]} / {counts[1]}",
    }


def _failing(take: Take) -> Mapping[str, str]:
    together = _hands_together(take)
    within = _within(take)[:, list(HANDS)]
    happened = take.events
    swaps = happened[happened["kind"] == "swap"]
    lost = happened[(happened["kind"] == "lost") & (happened["target"] != TARGETS[HEAD])]
    back = happened[(happened["kind"] == "recovered") & (happened["target"] != TARGETS[HEAD])]
    last = lost[~lost["ended"].to_numpy(dtype=bool)]
    merges = _spans(take.index[together]) or "never"
    return {
        "hands together": f"{merges}; {_percent(within[together])} within 100 mm meanwhile",
        "hands confused": _event_frames(swaps) or "never",
        "a hand lost": _event_frames(lost) or "never",
        "a hand recovered": _event_frames(back) or "never",
        "lost at the end": ", ".join(LABELS[t] for t in last["target"]) or "none",
    }


def _shown_in_failure(take: Take) -> tuple[int, ...]:
    """The thesis's frames, and where ours merge, swap or lose, ten at most."""
    wanted = [n - 1 for n in (1, 21, 23, 62, 63, 64, 82, 84, 99, 121)]
    there = take.index.tolist()
    together = take.index[_hands_together(take)]
    own = [int(f) for f in take.events["first_frame"]] + [int(f) for f in together[:1]]
    if not own:
        return tuple(n for n in wanted if n in there)
    chosen = sorted({there[0], there[-1], *own})
    places = np.unique(np.linspace(0, len(chosen) - 1, min(10, len(chosen))).round().astype(int))
    return tuple(chosen[i] for i in places)


def _paths(take: Take) -> Markup:
    return path_chart(take.points_mm("truth"), take.points_mm("estimate"))


def _errors(take: Take) -> Markup:
    errors = take.column("err_acc_px").astype(np.float64)
    errors = np.where(np.isfinite(errors), errors, np.nan)
    x = take.index.astype(np.float64) + 1
    return line_chart(
        [Series(target, x, errors[:, t]) for t, target in enumerate(TARGETS)],
        ("frame", "Err_acc [px]"),
        marks=False,
        limit=(ERR_ACC_AXIS_PX, "the thesis's axis ends here"),
    )


def _within(take: Take) -> np.ndarray:
    errors = take.column("error_mm").astype(np.float64)
    inside: np.ndarray = np.nan_to_num(errors, nan=np.inf) <= 100.0
    return inside


def _percent(flags: np.ndarray) -> str:
    return f"{100 * float(flags.mean()):.0f} %" if flags.size else "-"


def _each(take: Take, column: str, q: float, unit: str) -> str:
    values = take.column(column).astype(np.float64)
    return _slashed([quantile(values[:, t], q) for t in range(len(TARGETS))], unit)


def _slashed(values: Sequence[float], unit: str) -> str:
    words = [f"{v:.1f}" if np.isfinite(v) else "∞" for v in values]
    return f"{' / '.join(words)} {unit}"


def _wrong(take: Take) -> str:
    kinds = [k for k in ("swap", "capture", "lost") if (take.events["kind"] == k).any()]
    words = {"swap": "hands swapped", "capture": "captured", "lost": "lost"}
    return ", ".join(words[k] for k in kinds) or "none"


def _event_frames(events: object) -> str:
    """Frames, counted from 1, in which events begin and end."""
    spans = [f"{e.first_frame + 1}-{e.last_frame + 1}" for e in events.itertuples()]  # type: ignore[attr-defined]
    return ", ".join(spans)


def _spans(frames: np.ndarray) -> str:
    """Numbers in order as "21-22, 30", counted from 1."""
    if not len(frames):
        return ""
    cuts = np.flatnonzero(np.diff(frames) > 1) + 1
    parts = [part + 1 for part in np.split(frames, cuts)]
    return ", ".join(f"{p[0]}-{p[-1]}" if len(p) > 1 else f"{p[0]}" for p in parts)


_TICKS = "axis ticks {}; no unit printed"
_PLANS = (
    _Plan(
        "4.1",
        "Selected frames of a calm sequence",
        ("calm_table",),
        {
            "frames": "150; shown are 1, 15, 50, 75, 115, 150",
            "targets lost or swapped": NOT_STATED,
            "median 3-D error, head / right / left": "not stated: no 3-D truth was available",
        },
        _accuracy,
        frames=_same_frames(1, 15, 50, 75, 115, 150),
    ),
    _Plan(
        "4.2",
        "Its paths in 3-D",
        ("calm_table",),
        {
            "across (x)": _TICKS.format("0 to 600"),
            "down (y)": _TICKS.format("100 to 400"),
            "depth (z)": _TICKS.format("1400 to 1600"),
        },
        _extent,
        chart=_paths,
    ),
    _Plan(
        "4.3",
        "Its error in every frame",
        ("calm_table",),
        {
            "frames": "150",
            "largest Err_acc, head / right / left": "not stated; the axis ends at 20 px",
            "median Err_acc, head / right / left": NOT_STATED,
            "above 20 px": "nothing is drawn above",
            "head steadier than the hands": "yes: “much more stable”",
        },
        _per_frame,
        chart=_errors,
    ),
    _Plan(
        "4.4",
        "Drinking: paths in 3-D",
        ("drink",),
        {
            "across (x)": _TICKS.format("0 to 400"),
            "down (y)": _TICKS.format("100 to 500"),
            "depth (z)": _TICKS.format("1200 to 1400"),
            "trajectory": "“smooth”: picks up, drinks, puts back",
        },
        _extent,
        chart=_paths,
    ),
    _Plan(
        "4.5",
        "Drinking: selected frames",
        ("drink",),
        {
            "hand on the head": "frames 21-28",
            "within 100 mm meanwhile": NOT_STATED,
            "tracks after it": "frames 30-49 “still properly associated with targets”",
            "targets lost or swapped": "none in frames 30-49",
        },
        _drinking,
        frames=_same_frames(1, 21, 23, 27, 30, 31, 32, 36, 40, 49),
    ),
    _Plan(
        "4.6",
        "Both hands in one skin-coloured area",
        ("merge_and_hold", "fast_finish", "cross"),
        {
            "both hands are one area": "frame 21, in both views",
            "detections in its first frame, left / right view": NOT_STATED,
        },
        _segmentation,
        frames=_merged_pair,
    ),
    _Plan(
        "4.7",
        "Where it fails: fast motion at the end",
        ("fast_finish", "merge_and_hold"),
        {
            "hands together": "frames 21-22, both tracks kept",
            "hands confused": "frame 62, by fast motion",
            "a hand lost": "between frames 82 and 99",
            "a hand recovered": "by frame 99",
            "lost at the end": "right hand, left hand",
        },
        _failing,
        frames=_shown_in_failure,
    ),
)
