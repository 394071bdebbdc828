"""Measures of an episode for the thesis's figures: texts by row, pictured frames, plots.

Frames are counted from 1 in all texts, as in the thesis.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pandas as pd
from markupsafe import Markup

from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND, TARGETS
from reports.page.charts.line_chart import Series, line_chart
from reports.page.charts.path_chart import path_chart
from reports.page.episode_tables import EpisodeTables
from reports.score.score import quantile
from reports.words import FLAGS, LABELS

NOT_STATED = "not stated"
HANDS = (RIGHT_HAND, LEFT_HAND)
ERR_ACC_AXIS_PX = 20.0  # where the axis of Fig. 4.3 ends


def same_frames(*numbers: int) -> Callable[[EpisodeTables], tuple[int, ...]]:
    """Make the choice of the thesis's own frames, as far as an episode has them."""

    def chosen(episode: EpisodeTables) -> tuple[int, ...]:
        recorded = set(episode.index.tolist())
        return tuple(n - 1 for n in numbers if n - 1 in recorded)

    return chosen


def accuracy(episode: EpisodeTables) -> Mapping[str, str]:
    """Rows of Fig. 4.1."""
    return {
        "frames": str(len(episode.index)),
        "targets lost or swapped": _failures(episode),
        "median 3-D error, head / right / left": _each(episode, "error_mm", 0.5, "mm"),
    }


def extent(episode: EpisodeTables) -> Mapping[str, str]:
    """Rows of Fig. 4.2 and 4.4: extents of the estimates along the left camera's axes."""
    estimates = episode.points_mm("estimate")
    points = estimates[np.isfinite(estimates).all(axis=2)]
    if not len(points):
        return {}
    row = episode.cameras[episode.cameras["view"] == "left"].iloc[0]
    R_cw = np.array(row["R_cw"]).reshape(3, 3)
    points_c = points @ R_cw.T + 1e3 * np.array(row["t_cw"])
    low, high = np.quantile(points_c, [0.01, 0.99], axis=0)
    spans = [f"{a:.0f} to {b:.0f} mm" for a, b in zip(low, high, strict=True)]
    return {
        "across (x)": f"{spans[0]}, {high[0] - low[0]:.0f} wide",
        "down (y)": f"{spans[1]}, {high[1] - low[1]:.0f} high",
        "depth (z)": f"{spans[2]}, {high[2] - low[2]:.0f} deep",
        "trajectory": _roughness(episode),
    }


def _roughness(episode: EpisodeTables) -> str:
    """Mean second difference of the right hand's path against that of its truth."""
    means = []
    for kind in ("estimate", "truth"):
        path = episode.points_mm(kind)[:, RIGHT_HAND]
        jumps = np.linalg.norm(np.diff(path, n=2, axis=0), axis=1)
        jumps = jumps[np.isfinite(jumps)]
        means.append(float(jumps.mean()) if len(jumps) else float("nan"))
    return (
        f"right hand bends by {means[0]:.0f} mm a frame (mean second difference), "
        f"its truth by {means[1]:.0f}"
    )


def per_frame(episode: EpisodeTables) -> Mapping[str, str]:
    """Rows of Fig. 4.3."""
    errors = episode.column("err_acc_px").astype(np.float64)
    over = np.nan_to_num(errors, nan=np.inf) > ERR_ACC_AXIS_PX
    spread = [quantile(errors[:, t], 0.9) - quantile(errors[:, t], 0.1) for t in range(3)]
    steady = "yes" if all(spread[HEAD] < spread[hand] for hand in HANDS) else "no"
    return {
        "frames": str(len(episode.index)),
        "largest Err_acc, head / right / left": _each(episode, "err_acc_px", 1.0, "px"),
        "median Err_acc, head / right / left": _each(episode, "err_acc_px", 0.5, "px"),
        "above 20 px": f"{int(over.sum())} of {over.size} target-frames",
        "head steadier than the hands": f"{steady}: 10-90 % spread {_slashed(spread, 'px')}",
    }


def drinking(episode: EpisodeTables) -> Mapping[str, str]:
    """Rows of Fig. 4.5."""
    merged = episode.column("merged").astype(bool)
    touch = merged[:, HEAD] & (merged[:, RIGHT_HAND] | merged[:, LEFT_HAND])
    after = episode.index[touch].max() if touch.any() else None
    later = episode.index > after if after is not None else np.zeros(len(episode.index), dtype=bool)
    within = _within(episode)
    return {
        "hand on the head": _spans(episode.index[touch]) or "never",
        "within 100 mm meanwhile": _percent(within[touch]),
        "tracks after it": (
            f"{_percent(within[later])} within 100 mm" if later.any() else "no frame left"
        ),
        "targets lost or swapped": _failures(episode),
    }


def _hands_together(episode: EpisodeTables) -> np.ndarray:
    """Frames (F,) in which the hands merge, and the head with neither."""
    merged = episode.column("merged").astype(bool)
    both: np.ndarray = merged[:, RIGHT_HAND] & merged[:, LEFT_HAND] & ~merged[:, HEAD]
    return both


def merged_pair(episode: EpisodeTables) -> tuple[int, ...]:
    """The first frame in which the hands merge; empty where they never do."""
    frames = episode.index[_hands_together(episode)]
    return (int(frames[0]),) if len(frames) else ()


def segmentation(episode: EpisodeTables) -> Mapping[str, str]:
    """Rows of Fig. 4.6."""
    frames = merged_pair(episode)
    if not frames:
        return {"both hands are one area": "never"}
    detections = episode.detections[episode.detections["frame"] == frames[0]]
    counts = [int((detections["view"] == view).sum()) for view in ("left", "right")]
    return {
        "both hands are one area": f"frames {_spans(episode.index[_hands_together(episode)])}",
        "detections in its first frame, left / right view": f"{counts[0]} / {counts[1]}",
    }


def failing(episode: EpisodeTables) -> Mapping[str, str]:
    """Rows of Fig. 4.7."""
    together = _hands_together(episode)
    within = _within(episode)[:, list(HANDS)]
    events = episode.events
    swaps = events[events["kind"] == "swap"]
    lost = events[(events["kind"] == "lost") & (events["target"] != TARGETS[HEAD])]
    back = events[(events["kind"] == "recovered") & (events["target"] != TARGETS[HEAD])]
    last = lost[~lost["ended"].to_numpy(dtype=bool)]
    merges = _spans(episode.index[together]) or "never"
    return {
        "hands together": f"{merges}; {_percent(within[together])} within 100 mm meanwhile",
        "hands confused": _event_frames(swaps) or "never",
        "a hand lost": _event_frames(lost) or "never",
        "a hand recovered": _event_frames(back) or "never",
        "lost at the end": ", ".join(LABELS[t] for t in last["target"]) or "none",
    }


def shown_in_failure(episode: EpisodeTables) -> tuple[int, ...]:
    """At most ten frames in which ours merge, swap or lose; without any the thesis's frames."""
    frames = [n - 1 for n in (1, 21, 23, 62, 63, 64, 82, 84, 99, 121)]
    recorded = episode.index.tolist()
    together = episode.index[_hands_together(episode)]
    own = [int(f) for f in episode.events["first_frame"]] + [int(f) for f in together[:1]]
    if not own:
        return tuple(n for n in frames if n in recorded)
    chosen = sorted({recorded[0], recorded[-1], *own})
    places = np.unique(np.linspace(0, len(chosen) - 1, min(10, len(chosen))).round().astype(int))
    return tuple(chosen[i] for i in places)


def paths(episode: EpisodeTables) -> Markup:
    """The plot of Fig. 4.2 and 4.4."""
    return path_chart(episode.points_mm("truth"), episode.points_mm("estimate"))


def errors(episode: EpisodeTables) -> Markup:
    """The plot of Fig. 4.3."""
    errors = episode.column("err_acc_px").astype(np.float64)
    errors = np.where(np.isfinite(errors), errors, np.nan)
    x = episode.index.astype(np.float64) + 1
    return line_chart(
        [Series(target, x, errors[:, t]) for t, target in enumerate(TARGETS)],
        ("frame", "Err_acc [px]"),
        marks=False,
        limit=(ERR_ACC_AXIS_PX, "the thesis's axis ends here"),
    )


def _within(episode: EpisodeTables) -> np.ndarray:
    errors = episode.column("error_mm").astype(np.float64)
    inside: np.ndarray = np.nan_to_num(errors, nan=np.inf) <= 100.0
    return inside


def _percent(flags: np.ndarray) -> str:
    return f"{100 * float(flags.mean()):.0f} %" if flags.size else "-"


def _each(episode: EpisodeTables, column: str, q: float, unit: str) -> str:
    values = episode.column(column).astype(np.float64)
    return _slashed([quantile(values[:, t], q) for t in range(len(TARGETS))], unit)


def _slashed(values: Sequence[float], unit: str) -> str:
    numbers = [f"{v:.1f}" if np.isfinite(v) else "∞" for v in values]
    return f"{' / '.join(numbers)} {unit}"


def _failures(episode: EpisodeTables) -> str:
    kinds = set(episode.events["kind"])
    return ", ".join(text for kind, text in FLAGS.items() if kind in kinds) or "none"


def _event_frames(events: pd.DataFrame) -> str:
    """First and last frame of each event."""
    ends = zip(events["first_frame"], events["last_frame"], strict=True)
    return ", ".join(f"{first + 1}-{last + 1}" for first, last in ends)


def _spans(frames: np.ndarray) -> str:
    """Frame numbers in order as "21-22, 30"."""
    if not len(frames):
        return ""
    cuts = np.flatnonzero(np.diff(frames) > 1) + 1
    parts = [part + 1 for part in np.split(frames, cuts)]
    return ", ".join(f"{p[0]}-{p[-1]}" if len(p) > 1 else f"{p[0]}" for p in parts)
