"""Histograms as small SVG pictures: plain text that is readable on light and on dark paper."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from html import escape

from sim.dataset.histograms import Histogram, shares

WIDTH, _LINE, _TOP, _BAR = 460, 21, 34, 190
_LEFT = 128
# An SVG in a page follows the reader's theme only so; a viewer that knows none shows the first.
_STYLE = (
    "text{font:12.5px system-ui,-apple-system,'Segoe UI',Roboto,'DejaVu Sans',sans-serif;"
    "fill:#1b2330}.title{font-weight:600}.soft{fill:#5a6575}.bar{fill:#2f6fc4}"
    ".ground{fill:#ffffff}"
    "@media(prefers-color-scheme:dark){text{fill:#e6e9ee}.soft{fill:#9ca7b6}.bar{fill:#74a9ef}"
    ".ground{fill:#12161d}}"
)


def histogram_svg(histogram: Histogram) -> str:
    """A bar a bin of all series together, with its number and share."""
    bins = histogram.bins
    unit = f" [{bins.unit}]" if bins.unit else ""
    return bars_svg(bins.title + unit, bin_names(bins.edges), histogram.total)


def bin_names(edges: Sequence[float]) -> list[str]:
    """A bin's words, such as "0.4 – 0.6"."""
    pairs = itertools.pairwise(edges)
    # A true minus, so that a negative edge is not read as a range.
    return [f"{low:g} – {high:g}".replace("-", "−") for low, high in pairs]


def bars_svg(title: str, names: Sequence[str], counts: Sequence[int]) -> str:
    """Horizontal bars from the top down; the longest fills the room."""
    height = _TOP + _LINE * len(names) + 8
    most = max([*counts, 1])
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" '
        f'width="{WIDTH}" height="{height}" role="img" aria-label="{escape(title, quote=True)}">',
        f"<title>{escape(title)}</title>",
        f"<style>{_STYLE}</style>",
        f'<rect class="ground" width="{WIDTH}" height="{height}" rx="6"/>',
        f'<text class="title" x="12" y="21">{escape(title)}</text>',
    ]
    for i, (name, count, share) in enumerate(zip(names, counts, shares(counts), strict=True)):
        y = _TOP + _LINE * i
        long = _BAR * count / most
        lines += [
            f'<text x="{_LEFT - 8}" y="{y + 14}" text-anchor="end">{escape(name)}</text>',
            f'<rect class="bar" x="{_LEFT}" y="{y + 3}" width="{long:.1f}" height="15" rx="2"/>',
            f'<text class="soft" x="{_LEFT + long + 6:.1f}" y="{y + 14}">'
            f"{count} ({100 * share:.1f} %)</text>",
        ]
    return "\n".join([*lines, "</svg>"]) + "\n"


def words_of(histogram: Histogram) -> str:
    """The same in words, for who does not see the picture."""
    said = zip(bin_names(histogram.bins.edges), shares(histogram.total), strict=True)
    unit = f" {histogram.bins.unit}" if histogram.bins.unit else ""
    return "; ".join(f"{name}{unit}: {100 * share:.1f} %" for name, share in said)
