"""The parts of the page: failures with their strips, maps, curves, probabilities, comparisons."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from reports.page.episode_tables import EpisodeTables
from reports.page.packing import data_address
from reports.page.run_entries import RunEntry
from reports.pictures.encode import webp_of
from reports.score.robustness import GOALS, Goal
from reports.stress.failure_map import difference_map, failure_map
from reports.stress.interval_chart import occluded_curve, speed_curves
from reports.stress.load import StressFolder
from reports.stress.marginal import Along, marginal
from reports.stress.records import (
    AxisRecord,
    CompareRecord,
    EpisodeKey,
    EstimateRecord,
    FailureRecord,
    MapRecord,
    OccludedRecord,
)
from reports.stress.strips import start_of, strip
from reports.stress.words import GOAL_SHORT, value_text
from reports.words import GOAL_WORDS, MEASURE_WORDS

STRIP_QUALITY = 55  # of WebP; about 9 kB a tile
MOST_STRIPS = 60
EpisodeKeyPair = tuple[str, int]


@dataclass(frozen=True, eq=False)
class PlayedFolder:
    """A folder with its episodes as the player has them, by label and seed."""

    source: StressFolder
    entries: Mapping[EpisodeKeyPair, RunEntry]
    tables: Mapping[EpisodeKeyPair, EpisodeTables]
    films: Mapping[EpisodeKeyPair, Mapping[int, bytes]]

    def address(self, key: EpisodeKey | None, measure: str = "swap") -> str:
        """The address of an episode in the page, at the moment of its failure; "" without it."""
        pair = (key.label, key.seed) if key is not None else None
        if pair is None or pair not in self.entries:
            return ""
        return f"#play={self.entries[pair].key}@{start_of(self.tables[pair], measure)}"

    def links(self, measure: str) -> dict[EpisodeKeyPair, str]:
        """The addresses of all its episodes."""
        return {
            pair: f"#play={entry.key}@{start_of(self.tables[pair], measure)}"
            for pair, entry in self.entries.items()
        }


@dataclass(frozen=True)
class StripTile:
    """A frame of a strip on the page."""

    picture: str
    caption: str
    badge: str
    address: str


@dataclass(frozen=True)
class FailureCard:
    """A distinct failure on the page."""

    record: FailureRecord
    system: str
    title: str
    changed: tuple[str, ...]
    tiles: tuple[StripTile, ...]
    address: str


@dataclass(frozen=True)
class Drawing:
    """A map or curve of a family.

    sparse: no trial failed, so that there is nothing to see; trials: of the cells that it shows.
    """

    family: str
    system: str
    title: str
    record: MapRecord | None
    chart: Markup
    sparse: bool = False
    trials: int = 0


@dataclass(frozen=True)
class Probabilities:
    """The table of probabilities. columns: (system, goal); rows: by family a record of each."""

    columns: tuple[tuple[str, Goal], ...]
    rows: Mapping[str, tuple[EstimateRecord | None, ...]]

    @property
    def about(self) -> str:
        """What the figures are about, in a sentence."""
        kinds = {r.fidelity for row in self.rows.values() for r in row if r is not None}
        if kinds == {"full"}:
            return "All are about rendered pictures."
        if kinds == {"fast"}:
            return "All are about fast runs, without pictures: no full run corrects them."
        return "Some are about rendered pictures, some about fast runs: see below."


def failure_cards(folders: Sequence[PlayedFolder]) -> list[FailureCard]:
    """The distinct failures of all searches, confirmed ones first, then by severity."""
    cards = []
    for folder in folders:
        search = folder.source.search
        if search is None:
            continue
        records = [f for s in search.searches for f in s.failures]
        records.sort(key=lambda f: (f.confirmed is not True, f.confirmed is False, -f.severity))
        for place, record in enumerate(records):
            changed = tuple(
                f"{'drawn ' if c.drawn else ''}{c.name} {value_text(c.value, c.unit)} "
                f"(nominal {value_text(c.nominal, c.unit)})"
                for c in record.changed
            )
            tiles = _tiles(folder, record) if place < MOST_STRIPS else ()
            address = folder.address(record.episode, record.measure)
            title = MEASURE_WORDS.get(record.measure, record.measure)
            cards.append(FailureCard(record, search.system, title, changed, tiles, address))
    return cards


def maps(folders: Sequence[PlayedFolder]) -> list[Drawing]:
    """The maps of two parameters, one for each goal that was failed, that of the plan always."""
    drawings = []
    for folder in folders:
        source = folder.source.map
        for record in (r for r in source.maps if r.y is not None) if source else ():
            for goal in GOALS:
                failed = any(cell.failures.get(goal, 0) for cell in record.cells)
                if failed or goal == record.goal:
                    chart = failure_map(record, goal, folder.links(goal))
                    title = f"{record.family}: {GOAL_WORDS[goal]}"
                    drawings.append(
                        Drawing(record.family, _system(source), title, record, chart, not failed)
                    )
    return drawings


def curves(folders: Sequence[PlayedFolder]) -> list[Drawing]:
    """The maps as curves over each number on their axes, and the losses over the frames hidden."""
    drawings = []
    for folder in folders:
        source = folder.source.map
        if source is None:
            continue
        # Of two parameters last: they say less.
        for record in sorted(source.maps, key=lambda record: record.y is not None):
            for shown, pooled in _along_axes(record):
                name = shown.x.name.replace("_", " ")
                chart = speed_curves(shown, folder.links(record.goal))
                title = f"{record.family}: failures over {name}{pooled}"
                trials = sum(cell.n for cell in record.cells)
                drawings.append(
                    Drawing(record.family, source.system, title, shown, chart, trials=trials)
                )
        hidden = _pooled(source.maps)
        if any(point.lost for point in hidden):
            chart = occluded_curve(hidden)
            title = "A target lost, over the frames for which it was hidden"
            drawings.append(Drawing("", source.system, title, None, chart))
    return drawings


def probabilities(folders: Sequence[PlayedFolder]) -> Probabilities:
    """The estimates of all folders, a column for each system and goal."""
    found: dict[tuple[str, str, Goal], EstimateRecord] = {}
    for folder in folders:
        source = folder.source.estimate
        for record in source.estimates if source else ():
            found[record.family, _system(source), record.goal] = record
    systems = dict.fromkeys(system for _, system, _ in found)
    goals = [goal for goal in GOALS if any(g == goal for *_, g in found)]
    columns = tuple((system, goal) for system in systems for goal in goals)
    families = dict.fromkeys(family for family, *_ in found)
    return Probabilities(
        columns,
        {f: tuple(found.get((f, *column)) for column in columns) for f in families},
    )


def comparisons(folders: Sequence[PlayedFolder]) -> list[tuple[CompareRecord, Markup | None]]:
    """The comparisons, each with its difference map if it has one."""
    listed: list[tuple[CompareRecord, Markup | None]] = []
    for folder in folders:
        source = folder.source.compare
        for record in source.comparisons if source else ():
            a, b = record.map_a, record.map_b
            chart = None
            if a is not None and b is not None and a.y is not None:
                chart = difference_map(a, b, record.goal, (record.a, record.b))
            listed.append((record, chart))
    return listed


def commands(folders: Sequence[PlayedFolder]) -> list[tuple[str, str]]:
    """(what, command) of everything on the page, each command once."""
    listed: dict[str, str] = {}
    for folder in folders:
        source = folder.source
        if source.search is not None:
            listed.setdefault(source.search.command, "search")
        for record in source.map.maps if source.map else ():
            listed.setdefault(record.command, "map")
        for estimate in source.estimate.estimates if source.estimate else ():
            listed.setdefault(estimate.command, "estimate")
        for comparison in source.compare.comparisons if source.compare else ():
            listed.setdefault(comparison.command, "compare")
    return [(what, command) for command, what in listed.items() if command]


def headline(goal: Goal) -> str:
    """A goal as a column's head."""
    return GOAL_SHORT[goal]


def _tiles(folder: PlayedFolder, record: FailureRecord) -> tuple[StripTile, ...]:
    pair = (record.episode.label, record.episode.seed) if record.episode is not None else None
    if pair is None or pair not in folder.tables:
        return ()
    tiles = strip(folder.tables[pair], folder.films.get(pair, {}), record.measure)
    return tuple(
        StripTile(
            data_address("image/webp", webp_of(tile.picture, STRIP_QUALITY)),
            f"{tile.time_s:.1f} s",
            tile.badge,
            f"#play={folder.entries[pair].key}@{tile.frame}",
        )
        for tile in tiles
    )


def _pooled(records: Sequence[MapRecord]) -> list[OccludedRecord]:
    """The hidden targets of several maps together."""
    found: dict[int, tuple[int, int]] = {}
    for record in records:
        for point in record.occluded:
            n, lost = found.get(point.frames, (0, 0))
            found[point.frames] = n + point.n, lost + point.lost
    return [OccludedRecord(frames=f, n=n, lost=k) for f, (n, k) in sorted(found.items())]


def _along_axes(record: MapRecord) -> list[tuple[MapRecord, str]]:
    """The curves of a map: of two parameters, each number with the other pooled, where any failed.

    With each what was pooled, in words.
    """
    if record.y is None:
        return [(record, "")]
    if not any(any(cell.failures.values()) for cell in record.cells):
        return []
    x, y = (axis.name.replace("_", " ") for axis in (record.x, record.y))
    sides: tuple[tuple[Along, AxisRecord, str], ...] = (("x", record.x, y), ("y", record.y, x))
    return [
        (marginal(record, along), f", {other} pooled")
        for along, axis, other in sides
        if not axis.choices
    ]


def _system(source: object) -> str:
    return str(getattr(source, "system", ""))
