"""The catalogue of scenarios as a page and as Markdown, a picture of each."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

from pjpdaf.arrays import Image
from reports.page.packing import data_address
from reports.page.templating import rendered, shared_scripts, styles
from reports.pictures.encode import jpeg_of

PAGE_QUALITY = 82


@dataclass(frozen=True, eq=False)
class ScenarioCard:
    """A scenario in the catalogue.

    picture: both views of one frame (h, w, 3) BGR; caption: its number and events.
    fps: frame rate; rates: of a ladder, empty for a single rate; thesis: the figures that it
    mirrors, or empty.
    """

    name: str
    group: str
    summary: str
    frames: int
    fps: float
    rates: tuple[float, ...]
    thesis: str
    parameters: int
    picture: Image
    caption: str

    @property
    def length(self) -> str:
        """Frames and rate, such as "150 frames at 3 a second"."""
        text = f"{self.frames} frames at {self.fps:g} a second"
        if self.rates:
            text += f", played at {', '.join(f'{rate:g}' for rate in self.rates)} a second"
        return text

    @property
    def alt(self) -> str:
        """The picture in text, for readers who do not see it."""
        return f"Left and right view of {self.name}, {self.caption}"


@dataclass(frozen=True)
class SuiteCard:
    """A suite in the catalogue; members: (label, scenario) in its order."""

    name: str
    summary: str
    seeds: int
    members: tuple[tuple[str, str], ...]


@dataclass(frozen=True, eq=False)
class Catalogue:
    """Scenarios in order, those of a group together, and suites."""

    cards: tuple[ScenarioCard, ...]
    suites: tuple[SuiteCard, ...]


def catalogue_page(catalogue: Catalogue, mark: str) -> str:
    """The catalogue as one HTML page that opens from disk, without network.

    mark: the command that made it, for the page's `generator`.
    """
    jpegs = {c.name: jpeg_of(c.picture, PAGE_QUALITY, optimised=True) for c in catalogue.cards}
    return rendered(
        "catalogue.html.j2",
        **_values(catalogue, mark),
        pictures={name: data_address("image/jpeg", jpeg) for name, jpeg in jpegs.items()},
        css=styles("catalogue.css"),
        scripts=shared_scripts(),
    )


def catalogue_markdown(catalogue: Catalogue, mark: str, path: str, folder: str) -> str:
    """The catalogue as Markdown for a forge, to lie at `path`; pictures: `folder`/NAME.jpg."""
    return rendered("catalogue.md.j2", **_values(catalogue, mark), path=path, folder=folder)


def _values(catalogue: Catalogue, mark: str) -> dict[str, Any]:
    """Values that both templates show."""
    cards = catalogue.cards
    return {
        "groups": [(name, list(of)) for name, of in itertools.groupby(cards, lambda c: c.group)],
        "cards": cards,
        "suites": catalogue.suites,
        "known": {card.name for card in cards},
        "mark": mark,
    }
