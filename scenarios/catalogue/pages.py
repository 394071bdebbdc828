"""The options `--html` and `--markdown` of `scenarios list`: a telling picture of each scenario."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from pjpdaf.arrays import Image
from pjpdaf.errors import BenchError, InfrastructureError
from reports.page.catalogue import (
    Catalogue,
    ScenarioCard,
    SuiteCard,
    catalogue_markdown,
    catalogue_page,
)
from reports.pictures.contact_sheet import small_jpeg
from reports.pictures.overlay import LETTERS
from reports.pictures.truth_overlay import merged_words, thumbnail
from scenarios.catalogue.film import difficulty, labels_of, truths
from scenarios.console.interrupts import interrupts, unwritten_if_interrupted
from scenarios.console.progress import progress_bar
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario, load_suite, scenario_names, suite_names
from scenarios.spec.scenario import Scenario
from sim.contact.contact import Unposable
from sim.files import disk_faults, written_whole_file
from sim.processes import Answer, Lost, Workers
from sim.script import Performance
from sim.sequence import Simulation
from sim.truth import Truth, ViewTruth

SEEDS = 10  # of these the first that can be posed is drawn
MOST_LOOKED_AT = 60  # frames of a scenario
PAGE_PX, MARKDOWN_PX = 320, 240  # side of one view
STILL_FRAMES = 3  # at the start
TIME_LIMIT_S = 300.0  # of one picture
MARK = "pjpdaf-bench scenarios list"
# As the catalogue is read, from easy to hard; other groups come after these.
GROUPS = (
    "baseline",
    "hand_and_head",
    "hand_and_hand",
    "view",
    "all_and_objects",
    "fast",
    "identity_traps",
)


@dataclass(frozen=True, eq=False)
class Picture:
    """A telling frame: both views (h, w, 3) BGR for the page and for Markdown, and its words."""

    large: Image
    small: Image
    caption: str


def write_catalogue(html: Path | None, markdown: Path | None, workers: int) -> list[Path]:
    """Draw every shipped scenario and write the pages asked for; what was written.

    A page of ours is replaced, no other file is. Markdown has its pictures in
    pictures/NAME-OF-THE-PAGE/ beside it. Raises BenchError, InfrastructureError, Interrupted.
    """
    paths = [path for path in (html, markdown) if path is not None]
    for path in paths:
        check_ours(path)
    scenarios = sorted(map(load_scenario, scenario_names()), key=_order)
    with interrupts():  # while pages are written, signals are only counted
        with unwritten_if_interrupted(paths[0]):
            pictures = draw_all(scenarios, workers)
        return _write_pages(scenarios, pictures, html, markdown)


def _write_pages(
    scenarios: Sequence[Scenario],
    pictures: Sequence[Picture],
    html: Path | None,
    markdown: Path | None,
) -> list[Path]:
    written = []
    if html is not None:
        page = catalogue_page(_catalogue(scenarios, [p.large for p in pictures], pictures), MARK)
        written.append(_write(html, page.encode()))
    if markdown is not None:
        catalogue = _catalogue(scenarios, [p.small for p in pictures], pictures)
        folder = markdown.absolute().parent / "pictures" / markdown.stem
        with disk_faults(folder, "the pictures"):
            folder.mkdir(parents=True, exist_ok=True)
        for card in catalogue.cards:
            _write(folder / f"{card.name}.jpg", small_jpeg(card.picture))
        here = os.path.relpath(markdown) if markdown.is_absolute() else str(markdown)
        text = catalogue_markdown(catalogue, MARK, here, f"pictures/{markdown.stem}")
        written.append(_write(markdown, text.encode()))
    return written


def check_ours(path: Path) -> None:
    """Raise BenchError where `path` is a file that is no page of ours; before minutes of work."""
    if not path.is_file():
        return
    try:
        head = path.read_bytes()[:2000]
    except OSError as error:
        raise BenchError(f"{path}: cannot be read: {error.strerror or error}.") from error
    if MARK.encode() not in head:
        raise BenchError(f"{path}: exists and is no catalogue page; give another name.")


def draw_all(scenarios: Sequence[Scenario], workers: int) -> list[Picture]:
    """A picture of each, drawn by worker processes. Raises BenchError for the first that fails."""
    console = Console(stderr=True)
    pictures: dict[int, Picture] = {}
    with progress_bar(console) as progress, Workers(min(workers, len(scenarios))) as pool:
        task = progress.add_task("starting", total=len(scenarios))
        pool.renderer()
        for found in pool.outcomes(_draw_safely, dict(enumerate(scenarios)), TIME_LIMIT_S):
            if found is not None:
                index, outcome = found
                pictures[index] = _picture(scenarios[index], outcome)
                progress.update(task, advance=1, description=scenarios[index].name)
    return [pictures[index] for index in range(len(scenarios))]


def _picture(scenario: Scenario, outcome: Answer[Picture | BenchError] | Lost) -> Picture:
    if isinstance(outcome, Lost):
        what = "takes too long" if outcome.late else "is killed"
        raise InfrastructureError(
            f"{scenario.name}: the process that draws it {what}; try fewer --jobs"
        )
    if isinstance(outcome.value, BenchError):
        raise outcome.value
    return outcome.value


def _draw_safely(scenario: Scenario) -> Picture | BenchError:
    try:
        return draw(scenario)
    except BenchError as fault:
        return fault.reworded(f"{scenario.name}: {fault}")


def draw(scenario: Scenario) -> Picture:
    """The scenario's telling frame, of the first seed that can be posed. Raises BenchError."""
    performance = _first_performance(scenario)
    step = -(-performance.frames // MOST_LOOKED_AT)
    seen = list(truths(performance, range(0, performance.frames, step)))
    with Simulation(performance) as simulation:
        shot = simulation.render(telling(seen).index)
        large, small = (
            thumbnail(shot.frame, simulation.rig.cameras, labels_of(shot), shot.truth, side)
            for side in (PAGE_PX, MARKDOWN_PX)
        )
    seed = f"seed {performance.seed}, " if performance.seed else ""
    return Picture(large, small, seed + caption(shot.truth))


def _first_performance(scenario: Scenario) -> Performance:
    for seed in range(SEEDS):
        try:
            return perform(scenario, seed)
        except Unposable as fault:
            reason = str(fault)
    raise BenchError(f"none of the seeds 0 to {SEEDS - 1} can be posed; the last: {reason}")


def telling(seen: Sequence[Truth]) -> Truth:
    """The middle of the longest stretch with the most merged or hidden targets.

    Where nothing is ever merged or hidden: of the longest event.
    """
    most = max(map(difficulty, seen))
    if most:
        stretches = _stretches(seen, lambda truth: difficulty(truth) == most)
    else:
        stretches = _stretches(seen[STILL_FRAMES:], lambda truth: truth.script_events)
    longest = max(stretches, key=len, default=list(seen))
    return longest[len(longest) // 2]


def _stretches(seen: Sequence[Truth], key: Callable[[Truth], object]) -> list[list[Truth]]:
    """Frames in a row whose key is the same, where it is true."""
    return [list(truths) for mark, truths in itertools.groupby(seen, key) if mark]


def caption(truth: Truth) -> str:
    """Frame and time, what happens, what is merged and what does not show."""
    said = [f"frame {truth.index} ({truth.time_s:.1f} s)", *truth.script_events]
    for verb, words in (("merged", merged_words), ("unseen", _unseen_words)):
        left, right = map(words, truth.views)
        if left == right:
            said += [f"{left} {verb} in both views"] if left else []
        else:
            views = ((left, "left"), (right, "right"))
            said += [f"{who} {verb} in the {side} view" for who, side in views if who]
    return ", ".join(said)


def _unseen_words(view: ViewTruth) -> str:
    return " and ".join(letter for t, letter in enumerate(LETTERS) if not view.visible_px[t])


def _order(scenario: Scenario) -> tuple[int, str, str]:
    known = scenario.group in GROUPS
    return GROUPS.index(scenario.group) if known else len(GROUPS), scenario.group, scenario.name


def _catalogue(
    scenarios: Sequence[Scenario], images: Sequence[Image], pictures: Sequence[Picture]
) -> Catalogue:
    cards = [
        ScenarioCard(
            name=scenario.name,
            group=scenario.group,
            summary=scenario.summary,
            frames=scenario.frames,
            fps=scenario.fps,
            rates=scenario.rates,
            thesis=scenario.thesis or "",
            parameters=len(scenario.parameters),
            picture=image,
            caption=picture.caption,
        )
        for scenario, image, picture in zip(scenarios, images, pictures, strict=True)
    ]
    suites = []
    for name in suite_names():
        suite = load_suite(name)
        members = tuple(
            (entry.label or entry.scenario, entry.scenario) for entry in suite.scenarios
        )
        suites.append(SuiteCard(suite.name, suite.summary, suite.seeds, members))
    return Catalogue(tuple(cards), tuple(suites))


def _write(path: Path, content: bytes) -> Path:
    what = "the catalogue"
    with written_whole_file(path, what, replace=True) as part, disk_faults(path, what):
        part.write_bytes(content)
    return path
