"""The record of a scenario's picture."""

from __future__ import annotations

from dataclasses import dataclass

from pjpdaf.arrays import Image


@dataclass(frozen=True, eq=False)
class ScenarioPicture:
    """A frame of a scenario: both views (h, w, 3) BGR for page and Markdown, and a caption."""

    large: Image
    small: Image
    caption: str
