"""Many small pictures on one sheet: of a scenario's frames, and of the whole catalogue."""

from __future__ import annotations

import base64
import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from typing import Any

import cv2
import jinja2
import numpy as np
from markupsafe import Markup

from reports.pictures.overlay import STRIP, Image

GAP_PX = 8
PAGE_QUALITY = 82
PICTURE_BYTES = 12_000  # of a picture in a repository
_QUALITIES = range(85, 19, -5)


@dataclass(frozen=True, eq=False)
class Card:
    """A scenario on the catalogue's sheet.

    picture: both views of one frame (h, w, 3) BGR; caption: which frame, and what happens in it.
    fps: its frame rate, and rates: those that it is played at, where there are several; thesis:
    the figures that it mirrors, or empty.
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
        words = f"{self.frames} frames at {self.fps:g} a second"
        if self.rates:
            words += f", played at {', '.join(f'{rate:g}' for rate in self.rates)} a second"
        return words

    @property
    def alt(self) -> str:
        """What the picture shows, for who does not see it."""
        return f"Left and right view of {self.name}, {self.caption}"


@dataclass(frozen=True)
class SuiteCard:
    """A suite: members are (words, scenario) in the suite's order."""

    name: str
    summary: str
    seeds: int
    members: tuple[tuple[str, str], ...]


@dataclass(frozen=True, eq=False)
class Catalogue:
    """Everything on the sheet: cards in order, those of a group together."""

    cards: tuple[Card, ...]
    suites: tuple[SuiteCard, ...]


def contact_sheet(pictures: Sequence[Image], columns: int) -> Image:
    """Pictures (h, w, 3) of one size in rows (H, W, 3), row by row, on the strip's colour."""
    height, width = pictures[0].shape[:2]
    rows = -(-len(pictures) // columns)
    across, down = columns * (width + GAP_PX) + GAP_PX, rows * (height + GAP_PX) + GAP_PX
    sheet = np.full((down, across, 3), STRIP, dtype=np.uint8)
    for i, picture in enumerate(pictures):
        row, column = divmod(i, columns)
        y, x = GAP_PX + row * (height + GAP_PX), GAP_PX + column * (width + GAP_PX)
        sheet[y : y + height, x : x + width] = picture
    return sheet


def small_jpeg(picture: Image, most_bytes: int = PICTURE_BYTES) -> bytes:
    """The best JPEG of a picture (h, w, 3) BGR that is no larger; the smallest where none is."""
    jpeg = b""
    for quality in _QUALITIES:
        jpeg = jpeg_of(picture, quality)
        if len(jpeg) <= most_bytes:
            break
    return jpeg


def jpeg_of(picture: Image, quality: int) -> bytes:
    """A picture (h, w, 3) BGR as JPEG; optimised, so that a small one stays small."""
    settings = [cv2.IMWRITE_JPEG_QUALITY, quality, cv2.IMWRITE_JPEG_OPTIMIZE, 1]
    done, jpeg = cv2.imencode(".jpg", picture, settings)
    assert done, "OpenCV always encodes a uint8 BGR picture"
    return bytes(jpeg)


def catalogue_page(catalogue: Catalogue, mark: str) -> str:
    """One HTML page that opens from disk and needs no network and no script.

    mark: what made it, in the page's `generator`.
    """
    pictures = {c.name: _address(jpeg_of(c.picture, PAGE_QUALITY)) for c in catalogue.cards}
    return _render("catalogue.html.j2", catalogue, mark, pictures=pictures, css=_css())


def catalogue_markdown(catalogue: Catalogue, mark: str, path: str, folder: str) -> str:
    """The same for reading on a forge, to lie at `path`; its pictures are `folder`/NAME.jpg."""
    return _render("catalogue.md.j2", catalogue, mark, path=path, folder=folder)


def group_words(group: str) -> str:
    """A group's name for reading, such as "Hand and head"."""
    return group.replace("_", " ").capitalize()


def _plain(words: str) -> str:
    """Words as one line of Markdown that means nothing but itself."""
    return re.sub(r"([\\`*\[\]|<>])", r"\\\1", " ".join(words.split()))


def _render(template: str, catalogue: Catalogue, mark: str, **values: Any) -> str:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("reports", "page/templates"),
        autoescape=template.endswith(".html.j2"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters.update(group_words=group_words, plain=_plain)
    cards = catalogue.cards
    return environment.get_template(template).render(
        groups=[(name, list(of)) for name, of in itertools.groupby(cards, lambda c: c.group)],
        cards=cards,
        suites=catalogue.suites,
        known={card.name for card in cards},
        mark=mark,
        **values,
    )


def _address(jpeg: bytes) -> str:
    return "data:image/jpeg;base64," + base64.b64encode(jpeg).decode()


def _css() -> Markup:
    folder = resources.files("reports") / "page" / "templates"
    texts = [(folder / name).read_text(encoding="utf-8") for name in ("page.css", "catalogue.css")]
    return Markup("\n".join(texts))
