"""One self-contained HTML page from saved runs: opens from disk, needs no network."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from reports.figures import error_figure, path_figure, speed_figure
from reports.results import SavedRun
from reports.tables import (
    LABELS,
    StageTimes,
    Summary,
    SummaryRow,
    count,
    number,
    percent,
    summarise,
    time_text,
    verdict,
)

MAX_PICTURES = 8
MAX_EVENTS = 200
PICTURE_BYTES = 12_000_000


@dataclass(frozen=True)
class Shot:
    """A picture of the page: caption and data address."""

    caption: str
    address: str


def shot(caption: str, jpeg: bytes) -> Shot:
    """A picture inside the page."""
    return Shot(caption, "data:image/jpeg;base64," + base64.b64encode(jpeg).decode())


@dataclass(frozen=True)
class Entry:
    """One episode that can be chosen: key of its figures, words in the select box, its pictures."""

    key: str
    words: str
    shots: tuple[Shot, ...]


@dataclass(frozen=True)
class EventLine:
    """A row of a scenario's table of events."""

    run: str
    seed: int
    what: str
    frames: str
    start: str
    duration: str
    ended: str


@dataclass(frozen=True)
class Section:
    """A scenario on the page. blocks: (run, rows, times); speeds: (key, words) of speed curves."""

    anchor: str
    name: str
    blocks: tuple[tuple[Summary, tuple[SummaryRow, ...], StageTimes], ...]
    entries: tuple[Entry, ...]
    speeds: tuple[tuple[str, str], ...]
    events: tuple[EventLine, ...]
    more_events: int


def build_page(runs: Sequence[SavedRun], title: str = "") -> str:
    """The page of one run, or of several side by side.

    For each scenario the first seed with pictures is shown first, the others can be chosen; at most
    `MAX_PICTURES` pictures an episode and `PICTURE_BYTES` in all, first seeds first.
    Raises BenchError without a run, and where a picture cannot be read.
    """
    if not runs:
        raise BenchError("A report needs at least one saved run.")
    runs = _told_apart(runs)
    figures: dict[str, Any] = {}
    summaries = [summarise(run) for run in runs]
    sections = _sections(runs, summaries, figures)
    names = ", ".join(summary.name for summary in summaries)
    return render(
        "page.html.j2",
        figures,
        title=title or f"Tracking report: {names}",
        runs=list(zip(runs, summaries, strict=True)),
        verdicts=[(s.name, verdict(s)) for s in summaries],
        sections=sections,
        targets=TARGETS,
        count=count,
    )


def render(template: str, figures: Mapping[str, Any], **values: Any) -> str:
    """A page from a template of ours, with style, script, plotly and its figures inside."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("reports", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(
        number=number, percent=percent, time_text=time_text, label=LABELS.__getitem__, words=_words
    )
    return environment.get_template(template).render(
        css=asset("page.css"),
        script=asset("page.js"),
        figures=_packed(json.dumps(figures, separators=(",", ":"), allow_nan=False).encode()),
        plotly=_plotly(),
        **values,
    )


def write_page(runs: Sequence[SavedRun], path: Path, title: str = "") -> Path:
    """Write the page and return its path. Raises BenchError where it cannot be written."""
    return write_text(path, build_page(runs, title))


def write_text(path: Path, text: str) -> Path:
    """Write a page, whole or not at all, and return its path. Raises BenchError."""
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise BenchError(f"{path}: cannot write the report: {error.strerror or error}.") from error
    return path


def _told_apart(runs: Sequence[SavedRun]) -> list[SavedRun]:
    """Runs of one name get their number after it."""
    names = [run.name for run in runs]
    return [
        replace(run, meta={**run.meta, "name": f"{run.name} ({i + 1})"})
        if names.count(run.name) > 1
        else run
        for i, run in enumerate(runs)
    ]


def _sections(
    runs: Sequence[SavedRun], summaries: Sequence[Summary], figures: dict[str, Any]
) -> list[Section]:
    names = list(dict.fromkeys(name for summary in summaries for name in summary.scenarios))
    shots = _choose_shots(runs, names)
    sections = []
    for n, name in enumerate(names):
        entries: list[Entry] = []
        speeds: list[tuple[str, str]] = []
        events: list[EventLine] = []
        blocks = []
        for r, (run, summary) in enumerate(zip(runs, summaries, strict=True)):
            rows = tuple(row for row in summary.rows if row.scenario == name)
            if not rows:
                continue
            times = next(t for t in summary.times if t.scenario == name)
            blocks.append((summary, rows, times))
            frames = run.frames[run.frames["scenario"] == name]
            happened = run.events[run.events["scenario"] == name]
            prefix = f"{run.name}, " if len(runs) > 1 else ""
            for seed, mine in frames.groupby("seed", sort=True):
                key = f"{r}-{n}-{seed}"
                one = happened[happened["seed"] == seed]
                figures[f"errors-{key}"] = error_figure(mine, one)
                figures[f"paths-{key}"] = path_figure(mine)
                words = f"{prefix}seed {seed}{_flags(one)}"
                entries.append(Entry(key, words, shots.get((r, name, int(str(seed))), ())))
            curve = speed_figure(frames)
            if curve is not None:
                figures[f"speed-{r}-{n}"] = curve
                speeds.append((f"speed-{r}-{n}", run.name if len(runs) > 1 else ""))
            events += [_event_line(run.name, event) for event in happened.itertuples()]
        entries.sort(key=lambda e: not e.shots)  # stable: pictures first, else in order
        sections.append(
            Section(
                anchor=f"scenario-{n}",
                name=name,
                blocks=tuple(blocks),
                entries=tuple(entries),
                speeds=tuple(speeds),
                events=tuple(events[:MAX_EVENTS]),
                more_events=max(0, len(events) - MAX_EVENTS),
            )
        )
    return sections


def _choose_shots(
    runs: Sequence[SavedRun], names: Sequence[str]
) -> dict[tuple[int, str, int], tuple[Shot, ...]]:
    """Pictures by run, scenario and seed, within the budget: each scenario's first seed first."""
    found: dict[tuple[int, str, int], list[Mapping[str, Any]]] = {}
    for r, run in enumerate(runs):
        for picture in run.meta["pictures"]:
            found.setdefault((r, picture["scenario"], picture["seed"]), []).append(picture)
    ranks: dict[tuple[int, str], int] = {}
    order = []
    for key in sorted(found, key=lambda k: (k[0], names.index(k[1]), k[2])):
        rank = ranks[key[:2]] = ranks.get(key[:2], -1) + 1
        order.append((rank, key))
    chosen: dict[tuple[int, str, int], tuple[Shot, ...]] = {}
    left = PICTURE_BYTES
    for _, key in sorted(order, key=lambda item: item[0]):
        shots = []
        for picture in _spread(found[key], MAX_PICTURES):
            path = runs[key[0]].folder / picture["file"]
            try:
                jpeg = path.read_bytes()
            except OSError as error:
                raise BenchError(f"{path}: cannot be read: {error.strerror or error}.") from error
            if len(jpeg) > left:
                return chosen
            left -= len(jpeg)
            shots.append(shot(f"frame {picture['frame']}", jpeg))
        chosen[key] = tuple(shots)
    return chosen


def _spread(items: Sequence[Mapping[str, Any]], most: int) -> list[Mapping[str, Any]]:
    """At most `most` items, evenly spread, first and last among them."""
    if len(items) <= most:
        return list(items)
    return [items[round(i * (len(items) - 1) / (most - 1))] for i in range(most)]


def _flags(events: Any) -> str:
    """What the select box says about an episode."""
    kinds = set(events["kind"])
    words = [
        word
        for kind, word in {"swap": "swapped", "lost": "lost", "capture": "captured"}.items()
        if kind in kinds
    ]
    return f" ({', '.join(words)})" if words else ""


def _event_line(run: str, event: Any) -> EventLine:
    who = LABELS[event.target]
    what = {
        "swap": "hands swapped",
        "capture": f"{who} captured by {LABELS.get(event.other, '?')}",
        "lost": f"{who} lost",
        "recovered": f"{who} recovered",
    }[event.kind]
    return EventLine(
        run=run,
        seed=int(event.seed),
        what=what,
        frames=f"{event.first_frame}-{event.last_frame}",
        start=f"{event.start_s:.1f} s",
        duration=f"{event.duration_s:.1f} s",
        ended="yes" if event.ended else "no",
    )


def _words(value: Any) -> str:
    """A value of run.json for reading."""
    if isinstance(value, str):
        return value
    return json.dumps(value, ensure_ascii=False)


def asset(name: str) -> Markup:
    """A file of ours that goes into the page as it is."""
    text = (resources.files("reports") / "templates" / name).read_text(encoding="utf-8")
    return Markup(text)


def _packed(content: bytes) -> str:
    """gzip and base64: small, and free of anything that could end a script element."""
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()


@cache
def _plotly() -> str:
    """plotly.js as it ships with the Python package, packed (1.9 instead of 4.8 MB)."""
    # The package itself takes half a second to import and is not needed for this.
    script = resources.files("plotly") / "package_data" / "plotly.min.js"
    return _packed(script.read_bytes())
