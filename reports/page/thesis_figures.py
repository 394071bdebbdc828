"""The thesis's Figures 4.1-4.7 from our own runs, beside the thesis's numbers.

The thesis counts frames from 1; so do these figures. Its numbers are from its text and from the
axes of its plots.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from reports.page.episode_tables import EpisodeTables
from reports.page.thesis_measures import (
    NOT_STATED,
    accuracy,
    drinking,
    errors,
    extent,
    failing,
    merged_pair,
    paths,
    per_frame,
    same_frames,
    segmentation,
    shown_in_failure,
)

Measure = Callable[[EpisodeTables], Mapping[str, str]]
Chart = Callable[[EpisodeTables], Markup]


@dataclass(frozen=True)
class Comparison:
    """A row of a figure: the thesis's value and each run's ("-" without the episode)."""

    label: str
    thesis: str
    ours: tuple[str, ...]


@dataclass(frozen=True)
class ThesisFigure:
    """A figure of the thesis, made from a run.

    source: (run, scenario, seed) of its episode, None where no run has the scenario; frames:
    numbers of its pictured frames; chart: its plot, None for a figure of pictures; scenarios: it
    can be made from any of these.
    """

    number: str
    title: str
    source: tuple[int, str, int] | None
    frames: tuple[int, ...]
    chart: Markup | None
    rows: tuple[Comparison, ...]
    scenarios: tuple[str, ...]


@dataclass(frozen=True)
class _Recipe:
    """How a figure is made: thesis: its rows with the thesis's values, measure: ours by row."""

    number: str
    title: str
    scenarios: tuple[str, ...]
    thesis: Mapping[str, str]
    measure: Measure
    frames: Callable[[EpisodeTables], Sequence[int]] | None = None
    chart: Chart | None = None


def thesis_figures(
    runs: Sequence[Mapping[tuple[str, int], EpisodeTables]],
) -> tuple[ThesisFigure, ...]:
    """Make all seven figures. runs: for each run its episodes by scenario and seed."""
    return tuple(_figure(recipe, runs) for recipe in _RECIPES)


def _figure(
    recipe: _Recipe, runs: Sequence[Mapping[tuple[str, int], EpisodeTables]]
) -> ThesisFigure:
    episodes = [_first(run, recipe.scenarios) for run in runs]
    measures = [recipe.measure(e) if e is not None else {} for e in episodes]
    source, shown = next(
        (((r, e.scenario, e.seed), e) for r, e in enumerate(episodes) if e is not None),
        (None, None),
    )
    frames = recipe.frames(shown) if recipe.frames is not None and shown is not None else ()
    return ThesisFigure(
        number=recipe.number,
        title=recipe.title,
        source=source,
        frames=tuple(frames),
        chart=recipe.chart(shown) if recipe.chart is not None and shown is not None else None,
        rows=tuple(
            Comparison(label, value, tuple(m.get(label, "-") for m in measures))
            for label, value in recipe.thesis.items()
        ),
        scenarios=recipe.scenarios,
    )


def _first(
    run: Mapping[tuple[str, int], EpisodeTables], scenarios: Sequence[str]
) -> EpisodeTables | None:
    """The lowest seed of the first of these scenarios in the run, None without any."""
    for name in scenarios:
        seeds = sorted(seed for scenario, seed in run if scenario == name)
        if seeds:
            return run[name, seeds[0]]
    return None


_TICKS = "axis ticks {}; no unit printed"
_RECIPES = (
    _Recipe(
        "4.1",
        "Selected frames of a calm sequence",
        ("calm_table",),
        {
            "frames": "150; shown are 1, 15, 50, 75, 115, 150",
            "targets lost or swapped": NOT_STATED,
            "median 3-D error, head / right / left": "not stated: no 3-D truth was available",
        },
        accuracy,
        frames=same_frames(1, 15, 50, 75, 115, 150),
    ),
    _Recipe(
        "4.2",
        "Its paths in 3-D",
        ("calm_table",),
        {
            "across (x)": _TICKS.format("0 to 600"),
            "down (y)": _TICKS.format("100 to 400"),
            "depth (z)": _TICKS.format("1400 to 1600"),
        },
        extent,
        chart=paths,
    ),
    _Recipe(
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
        per_frame,
        chart=errors,
    ),
    _Recipe(
        "4.4",
        "Drinking: paths in 3-D",
        ("drink",),
        {
            "across (x)": _TICKS.format("0 to 400"),
            "down (y)": _TICKS.format("100 to 500"),
            "depth (z)": _TICKS.format("1200 to 1400"),
            "trajectory": "“smooth”: picks up, drinks, puts back",
        },
        extent,
        chart=paths,
    ),
    _Recipe(
        "4.5",
        "Drinking: selected frames",
        ("drink",),
        {
            "hand on the head": "frames 21-28",
            "within 100 mm meanwhile": NOT_STATED,
            "tracks after it": "frames 30-49 “still properly associated with targets”",
            "targets lost or swapped": "none in frames 30-49",
        },
        drinking,
        frames=same_frames(1, 21, 23, 27, 30, 31, 32, 36, 40, 49),
    ),
    _Recipe(
        "4.6",
        "Both hands in one skin-coloured area",
        ("merge_and_hold", "fast_finish", "cross"),
        {
            "both hands are one area": "frame 21, in both views",
            "detections in its first frame, left / right view": NOT_STATED,
        },
        segmentation,
        frames=merged_pair,
    ),
    _Recipe(
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
        failing,
        frames=shown_in_failure,
    ),
)
