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

import cv2
import jinja2
import numpy as np
import pandas as pd
from markupsafe import Markup

from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from reports.page.figures import speed_chart, stacked_bars
from reports.page.player import (
    FILM_BYTES,
    STILL_BYTES,
    Film,
    Key,
    Take,
    event_words,
    films,
    pack,
    takes,
    worst_frame,
)
from reports.page.thesis_figures import ThesisFigure, thesis_figures
from reports.run.load import SavedRun
from reports.score.ranking import MAX_WORST, badness, went_wrong, worst_first
from reports.summary.budget import Budget, budget_of
from reports.summary.groups import GroupRow, group_rows, scenario_rows, whole_row
from reports.summary.tables import (
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
from sim.files import disk_faults, written_whole_file

MAX_PICTURES = 8
MAX_EVENTS = 200
PICTURE_BYTES = 750_000  # of all enlarged pictures on a page
PICTURE_WIDTH_PX = 960
PICTURE_QUALITY = 50  # of WebP
BLAME_WORDS = {"swap": "swaps", "capture": "captures", "lost": "losses"}


@dataclass(frozen=True)
class Shot:
    """A picture of the page: caption and data address."""

    caption: str
    address: str


def shot(caption: str, jpeg: bytes) -> Shot:
    """A picture inside the page."""
    return Shot(caption, "data:image/jpeg;base64," + base64.b64encode(jpeg).decode())


@dataclass(frozen=True, eq=False)
class Entry:
    """One episode with a result: what the player shows, and a row of its scenario's table.

    key: of its data in the page; wrong: it belongs among the failures; worst: the frame with the
    largest error.
    """

    key: str
    run: str
    scenario: str
    seed: int
    flags: str
    within_100: float
    mean_mm: float
    wrong: bool
    worst: int
    redraws: int
    data: str
    film: Film | None
    shots: tuple[Shot, ...]

    @property
    def film_words(self) -> str:
        """Which frames have pictures."""
        if self.film is None:
            return "no pictures"
        return "film" if self.film.whole else count(len(self.film.pictures), "picture")


@dataclass(frozen=True)
class EventLine:
    """A row of a scenario's table of events; key: of its episode."""

    key: str
    run: str
    seed: int
    what: str
    first: int
    frames: str
    start: str
    duration: str
    ended: str
    blame: str


@dataclass(frozen=True, eq=False)
class Section:
    """A scenario on the page. blocks: (run, rows, times); speeds: (words, curve)."""

    anchor: str
    name: str
    blocks: tuple[tuple[Summary, tuple[SummaryRow, ...], StageTimes], ...]
    entries: tuple[Entry, ...]
    speeds: tuple[tuple[str, Markup], ...]
    events: tuple[EventLine, ...]
    more_events: int


@dataclass(frozen=True, eq=False)
class Report:
    """A run with what the page says of it.

    groups, scenarios: its rows of the main tables, total: all together; blame: lines such as
    "swaps: 8 association, 1 detections"; budget: where the error comes from, None where unknown.
    """

    run: SavedRun
    summary: Summary
    groups: tuple[GroupRow, ...]
    scenarios: tuple[GroupRow, ...]
    total: GroupRow
    blame: tuple[str, ...]
    budget: Budget | None
    budget_chart: Markup | None


def build_page(runs: Sequence[SavedRun], title: str = "") -> str:
    """The page of one run, or of several side by side.

    Films and pictures go in as far as the byte limits of `player` and this module allow; all
    else is in it whatever the size. Raises BenchError without a run, and where a picture cannot
    be read.
    """
    if not runs:
        raise BenchError("A report needs at least one saved run.")
    runs = _told_apart(runs)
    reports = [_report(run) for run in runs]
    played = [{(take.scenario, take.seed): take for take in takes(run)} for run in runs]
    names = list(dict.fromkeys(name for report in reports for name in report.summary.scenarios))
    entries = _entries(runs, played, names)
    by_key = {entry.key: entry for entry in entries}
    title = title or f"Tracking report: {', '.join(run.name for run in runs)}"
    return (
        _environment()
        .get_template("page.html.j2")
        .render(
            css=asset("page.css") + asset("player.css"),
            scripts=[asset(name) for name in ("report.js", "player.js", "lightbox.js")],
            title=title,
            reports=reports,
            groups=list(dict.fromkeys(row.name for report in reports for row in report.groups)),
            verdicts=[(report.run.name, verdict(report.summary)) for report in reports],
            worst=sorted(
                (entry for entry in entries if entry.wrong),
                key=lambda e: (e.within_100, -e.mean_mm),
            )[:MAX_WORST],
            sections=_sections(runs, reports, entries, names),
            entries=entries,
            left_out=_left_out(runs, by_key),
            figures=_figures(played, names, by_key),
            targets=TARGETS,
            count=count,
        )
    )


def render(template: str, figures: Mapping[str, Any], **values: Any) -> str:
    """A page with plotly from a template of ours, with style, scripts and its figures inside."""
    return (
        _environment()
        .get_template(template)
        .render(
            css=asset("page.css"),
            script=asset("plots.js") + asset("lightbox.js"),
            figures=_packed(json.dumps(figures, separators=(",", ":"), allow_nan=False).encode()),
            plotly=_plotly(),
            **values,
        )
    )


def write_page(runs: Sequence[SavedRun], path: Path, title: str = "") -> Path:
    """Write the page and return its path. Raises BenchError where it cannot be written."""
    return write_text(path, build_page(runs, title))


def write_text(path: Path, text: str) -> Path:
    """Write a page, whole or not at all, and return its path. Raises BenchError."""
    what = "the report"
    with written_whole_file(path, what, replace=True) as part, disk_faults(path, what):
        part.write_text(text, encoding="utf-8")
    return path


def asset(name: str) -> Markup:
    """A file of ours that goes into the page as it is."""
    text = (resources.files("reports") / "page" / "templates" / name).read_text(encoding="utf-8")
    return Markup(text)


def blame_lines(events: pd.DataFrame) -> tuple[str, ...]:
    """What is to blame, a line a kind of event; empty where none is known."""
    lines = []
    for kind, words in BLAME_WORDS.items():
        stages = events.loc[(events["kind"] == kind) & (events["blame"] != ""), "blame"]
        if len(stages):
            counts = [f"{n} {_blamed(stage)}" for stage, n in stages.value_counts().items()]
            lines.append(f"{words}: {', '.join(counts)}")
    return tuple(lines)


def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("reports", "page/templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(
        number=number,
        percent=percent,
        time_text=time_text,
        label=LABELS.__getitem__,
        words=_words,
        share=_share,
    )
    return environment


def _told_apart(runs: Sequence[SavedRun]) -> list[SavedRun]:
    """Runs of one name get their number after it."""
    names = [run.name for run in runs]
    return [
        replace(run, meta={**run.meta, "name": f"{run.name} ({i + 1})"})
        if names.count(run.name) > 1
        else run
        for i, run in enumerate(runs)
    ]


def _report(run: SavedRun) -> Report:
    budget = budget_of(run)
    return Report(
        run=run,
        summary=summarise(run),
        groups=group_rows(run),
        scenarios=scenario_rows(run),
        total=whole_row(run),
        blame=blame_lines(run.events),
        budget=budget,
        budget_chart=stacked_bars(budget.shares_mm) if budget is not None else None,
    )


def _entries(
    runs: Sequence[SavedRun], played: Sequence[Mapping[Key, Take]], names: Sequence[str]
) -> tuple[Entry, ...]:
    """All episodes with a result, scenario by scenario, run by run."""
    place = {name: n for n, name in enumerate(names)}
    shots = _choose_shots(runs)
    found: dict[tuple[int, int, int], Entry] = {}
    budget = (FILM_BYTES // len(runs), STILL_BYTES // len(runs))
    for r, (run, mine) in enumerate(zip(runs, played, strict=True)):
        rows = _rows_of(run)
        worst = worst_first(rows)
        moving = films(run, [*worst, *(key for key in mine if key not in worst)], budget)
        for (scenario, seed), take in mine.items():
            n = place[scenario]
            film = moving.get((scenario, seed))
            outside, mean_mm = badness(rows[scenario, seed])
            found[n, r, seed] = Entry(
                key=f"{r}-{n}-{seed}",
                run=run.name if len(runs) > 1 else "",
                scenario=scenario,
                seed=seed,
                flags=_flags(take.events),
                within_100=1.0 - outside,
                mean_mm=mean_mm,
                wrong=went_wrong(rows[scenario, seed]),
                worst=worst_frame(take, film.pictures if film is not None else ()),
                redraws=int(rows[scenario, seed][0]["redrawn"]),
                data=pack(take),
                film=film,
                shots=shots.get((r, scenario, seed), ()),
            )
    return tuple(found[place_] for place_ in sorted(found))


def _rows_of(run: SavedRun) -> dict[Key, list[Mapping[Any, Any]]]:
    """Rows of the table of episodes by scenario and seed."""
    found: dict[Key, list[Mapping[Any, Any]]] = {}
    for row in run.episodes.to_dict("records"):
        found.setdefault((row["scenario"], int(row["seed"])), []).append(row)
    return found


def _sections(
    runs: Sequence[SavedRun],
    reports: Sequence[Report],
    entries: Sequence[Entry],
    names: Sequence[str],
) -> list[Section]:
    sections = []
    for n, name in enumerate(names):
        speeds: list[tuple[str, Markup]] = []
        events: list[EventLine] = []
        blocks = []
        for r, (run, report) in enumerate(zip(runs, reports, strict=True)):
            summary = report.summary
            rows = tuple(row for row in summary.rows if row.scenario == name)
            if not rows:
                continue
            times = next(t for t in summary.times if t.scenario == name)
            blocks.append((summary, rows, times))
            curve = speed_chart(run.frames[run.frames["scenario"] == name])
            if curve is not None:
                speeds.append((run.name if len(runs) > 1 else "", curve))
            happened = run.events[run.events["scenario"] == name]
            events += [
                _event_line(f"{r}-{n}", run.name, event) for event in happened.to_dict("records")
            ]
        sections.append(
            Section(
                anchor=f"scenario-{n}",
                name=name,
                blocks=tuple(blocks),
                entries=tuple(e for e in entries if e.scenario == name),
                speeds=tuple(speeds),
                events=tuple(events[:MAX_EVENTS]),
                more_events=max(0, len(events) - MAX_EVENTS),
            )
        )
    return sections


def _figures(
    played: Sequence[Mapping[Key, Take]], names: Sequence[str], by_key: Mapping[str, Entry]
) -> list[tuple[ThesisFigure, Entry | None]]:
    """The thesis's figures, each with the episode that it is drawn from."""
    found: list[tuple[ThesisFigure, Entry | None]] = []
    for figure in thesis_figures(played):
        entry = None
        if figure.source is not None:
            r, scenario, seed = figure.source
            entry = by_key[f"{r}-{names.index(scenario)}-{seed}"]
        found.append((figure, entry))
    return found


def _left_out(runs: Sequence[SavedRun], by_key: Mapping[str, Entry]) -> int:
    """Films that are in a run's folder and not in the page."""
    kept = sum(bool(film["whole"]) for run in runs for film in run.meta["films"])
    return kept - sum(e.film is not None and e.film.whole for e in by_key.values())


def _choose_shots(runs: Sequence[SavedRun]) -> dict[tuple[int, str, int], tuple[Shot, ...]]:
    """Enlarged pictures by run, scenario and seed: of each episode as many as all have room for."""
    found: dict[tuple[int, str, int], list[Mapping[str, Any]]] = {}
    for r, run in enumerate(runs):
        for picture in run.meta["pictures"]:
            found.setdefault((r, picture["scenario"], picture["seed"]), []).append(picture)
    chosen: dict[tuple[int, str, int], tuple[Shot, ...]] = {}
    left = PICTURE_BYTES
    for place, (key, pictures) in enumerate(found.items()):
        # An even share of what is left: small pictures leave more to the next.
        mine = left // (len(found) - place)
        middle = _spread(pictures, 1)[0]
        sample = _smaller(runs[key[0]], middle)
        most = min(MAX_PICTURES, mine // max(len(sample), 1))
        shots = []
        for picture in _spread(pictures, most):
            webp = sample if picture is middle else _smaller(runs[key[0]], picture)
            if len(webp) > left:
                break
            left -= len(webp)
            address = "data:image/webp;base64," + base64.b64encode(webp).decode()
            shots.append(Shot(f"frame {picture['frame']}", address))
        if shots:
            chosen[key] = tuple(shots)
    return chosen


def _smaller(run: SavedRun, picture: Mapping[str, Any]) -> bytes:
    """A kept picture as a WebP of the page."""
    path = run.folder / picture["file"]
    try:
        jpeg = path.read_bytes()
    except OSError as error:
        raise BenchError(f"{path}: cannot be read: {error.strerror or error}.") from error
    sheet = cv2.imdecode(np.frombuffer(jpeg, dtype=np.uint8), cv2.IMREAD_COLOR) if jpeg else None
    if sheet is None:
        raise BenchError(f"{path}: is no picture.")
    height, width = sheet.shape[:2]
    if width > PICTURE_WIDTH_PX:
        size = (PICTURE_WIDTH_PX, round(height * PICTURE_WIDTH_PX / width))
        sheet = cv2.resize(sheet, size, interpolation=cv2.INTER_AREA)
    done, webp = cv2.imencode(".webp", sheet, [cv2.IMWRITE_WEBP_QUALITY, PICTURE_QUALITY])
    assert done, "OpenCV always encodes a uint8 BGR picture"
    return bytes(webp)


def _spread(items: Sequence[Mapping[str, Any]], most: int) -> list[Mapping[str, Any]]:
    """At most `most` items, evenly spread, first and last among them; one is the middle one."""
    if len(items) <= most:
        return list(items)
    if most <= 1:
        return [items[len(items) // 2]] if most else []
    return [items[round(i * (len(items) - 1) / (most - 1))] for i in range(most)]


def _flags(events: pd.DataFrame) -> str:
    """What went wrong in an episode."""
    kinds = set(events["kind"])
    words = {"swap": "swapped", "lost": "lost", "capture": "captured"}
    return ", ".join(word for kind, word in words.items() if kind in kinds)


def _event_line(prefix: str, run: str, event: Mapping[Any, Any]) -> EventLine:
    return EventLine(
        key=f"{prefix}-{event['seed']}",
        run=run,
        seed=int(event["seed"]),
        what=event_words(event),
        first=int(event["first_frame"]),
        frames=f"{event['first_frame']}-{event['last_frame']}",
        start=f"{event['start_s']:.1f} s",
        duration=f"{event['duration_s']:.1f} s",
        ended="yes" if event["ended"] else "no",
        blame=_blamed(event["blame"]),
    )


def _blamed(stage: object) -> str:
    """A stage for reading."""
    return {"none": "no single stage", "process": "process model"}.get(str(stage), str(stage))


def _words(value: Any) -> str:
    """A value of run.json for reading."""
    if isinstance(value, str):
        return value
    return json.dumps(value, ensure_ascii=False)


def _share(value: float) -> str:
    """A share of 1 with three digits, "-" for nothing to measure."""
    return "-" if value != value else f"{value:.3f}"


def _packed(content: bytes) -> str:
    """gzip and base64: small, and free of anything that could end a script element."""
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()


@cache
def _plotly() -> str:
    """plotly.js as it ships with the Python package, packed (1.9 instead of 4.8 MB)."""
    # The package itself takes half a second to import and is not needed for this.
    script = resources.files("plotly") / "package_data" / "plotly.min.js"
    return _packed(script.read_bytes())
