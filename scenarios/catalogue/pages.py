"""The options `--html` and `--markdown` of `scenarios list`: the catalogue with a picture each."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from pjpdaf.arrays import Image
from pjpdaf.errors import BenchError
from reports.page.catalogue import (
    Catalogue,
    ScenarioCard,
    SuiteCard,
    catalogue_markdown,
    catalogue_page,
)
from reports.pictures.contact_sheet import small_jpeg
from reports.run.provenance import versions
from scenarios.catalogue.pictures import draw_scenarios
from scenarios.catalogue.scenario_picture import ScenarioPicture
from scenarios.console.folder import unfinished
from scenarios.console.interrupts import interrupts, unwritten_if_interrupted
from scenarios.execute.code_digest import code_digest
from scenarios.execute.journal import Journal
from scenarios.spec.names import load_scenario, load_suite, scenario_names, suite_names
from scenarios.spec.scenario import Scenario
from sim.files import disk_faults, written_whole_file
from sim.processes import WorkerPool

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


def write_catalogue(html: Path | None, markdown: Path | None, workers: int) -> list[Path]:
    """Draw every shipped scenario and write the pages; returns their paths.

    An older catalogue page is replaced, no other file is. Markdown has its pictures in
    pictures/NAME-OF-THE-PAGE/ beside it. Until then what is drawn is kept in PAGE.part, and the
    same command goes on. Raises BenchError, InfrastructureError, Interrupted.
    """
    paths = [path for path in (html, markdown) if path is not None]
    for path in paths:
        check_replaceable(path)
    scenarios = sorted(map(load_scenario, scenario_names()), key=_order)
    part = unfinished(paths[0])
    pool = WorkerPool(min(workers, len(scenarios)), modules=(draw_scenarios.__module__,))
    # While pages are written, signals are only counted.
    with interrupts(), pool, ExitStack() as opened:
        with unwritten_if_interrupted(paths[0], "; the same command goes on"):
            identity = catalogue_identity(pool.renderer())
            journal = opened.enter_context(Journal.open(part, identity))
            try:
                pictures = draw_scenarios(scenarios, pool, journal)
            finally:
                if not journal.finished:
                    shutil.rmtree(part, ignore_errors=True)
        written = _write_pages(scenarios, pictures, html, markdown)
        shutil.rmtree(part, ignore_errors=True)
        return written


def catalogue_identity(renderer: str) -> str:
    """What decides the pictures beside their scenarios: renderer, our code, libraries."""
    return json.dumps(["catalogue", renderer, code_digest(), versions()])


def _write_pages(
    scenarios: Sequence[Scenario],
    pictures: Sequence[ScenarioPicture],
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


def check_replaceable(path: Path) -> None:
    """Raise BenchError, before minutes of work, for a file that is not a catalogue page."""
    if not path.is_file():
        return
    try:
        head = path.read_bytes()[:2000]
    except OSError as error:
        raise BenchError(f"{path}: cannot be read: {error.strerror or error}.") from error
    if MARK.encode() not in head:
        raise BenchError(f"{path}: exists and is not a catalogue page; give another name.")


def _order(scenario: Scenario) -> tuple[int, str, str]:
    known = scenario.group in GROUPS
    return GROUPS.index(scenario.group) if known else len(GROUPS), scenario.group, scenario.name


def _catalogue(
    scenarios: Sequence[Scenario], images: Sequence[Image], pictures: Sequence[ScenarioPicture]
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
    kind = "the catalogue"
    with written_whole_file(path, kind, replace=True) as part, disk_faults(path, kind):
        part.write_bytes(content)
    return path
