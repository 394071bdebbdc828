"""Bars as SVG: stacked ones inside the page, and counted ones as pictures of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from markupsafe import Markup, escape

from pjpdaf.targets import TARGETS
from reports.page.charts.svg import RIGHT, WIDTH, Axis, svg
from reports.words import LABELS

_COUNTED_WIDTH, _LINE, _TOP, _LEFT, _LONGEST = 460, 21, 34, 128, 190
# An SVG in a page follows the reader's theme only so; a viewer that knows none shows the first.
_STYLE = (
    "text{font:12.5px system-ui,-apple-system,'Segoe UI',Roboto,'DejaVu Sans',sans-serif;"
    "fill:#1b2330}.title{font-weight:600}.soft{fill:#5a6575}.bar{fill:#2f6fc4}"
    ".ground{fill:#ffffff}"
    "@media(prefers-color-scheme:dark){text{fill:#e6e9ee}.soft{fill:#9ca7b6}.bar{fill:#74a9ef}"
    ".ground{fill:#12161d}}"
)


def stacked_bars(parts_mm: Mapping[str, Mapping[str, float]]) -> Markup:
    """Draw a bar per target, stacked from parts [mm] in their order, a number in each part.

    Negative parts are left out of the bar; a line stands at the sum of all parts.
    """
    lengths = {t: sum(_drawn_mm(values, t) for values in parts_mm.values()) for t in TARGETS}
    axis = Axis(0.0, max(lengths.values(), default=0.0) * 1.1 or 1.0, 96, WIDTH - RIGHT)
    height = 66 + 34 * len(TARGETS)
    elements = []
    for tick in axis.ticks():
        x = axis.at(tick)
        elements.append(f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="8" y2="{height - 42}"/>')
        elements.append(_text("", x, height - 26, f"{tick:g}", "middle"))
    for t, target in enumerate(TARGETS):
        y = 14 + 34 * t
        elements.append(_text("", 90, y + 16, LABELS[target], "end"))
        start = 0.0
        for n, (name, values) in enumerate(parts_mm.items()):
            size = _drawn_mm(values, target)
            x0, x1 = axis.at(start), axis.at(start + size)
            start += size
            title = f"{name}, {LABELS[target]}: {size:.1f} mm"
            elements.append(_bar(f"part part-{n % 6}", x0, y, x1 - x0, 24, title=title))
            if x1 - x0 > 30:
                elements.append(_text(f"inside inside-{n % 6}", x0 + 6, y + 16, f"{size:.0f}"))
        x = axis.at(sum(values.get(target, 0.0) for values in parts_mm.values()))
        elements.append(f'<line class="sum" x1="{x:.1f}" x2="{x:.1f}" y1="{y - 4}" y2="{y + 28}"/>')
    elements.append(_text("", (96 + WIDTH) // 2, height - 6, "mm", "middle"))
    return svg(elements, height, "Error budget of each target in millimetres")


def counted_bars(title: str, names: Sequence[str], counts: Sequence[int]) -> str:
    """Draw horizontal bars from the top down, each with its count and share; a file of its own."""
    height = _TOP + _LINE * len(names) + 8
    most, total = max([*counts, 1]), max(sum(counts), 1)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_COUNTED_WIDTH} {height}" '
        f'width="{_COUNTED_WIDTH}" height="{height}" role="img" aria-label="{escape(title)}">',
        f"<title>{escape(title)}</title>",
        f"<style>{_STYLE}</style>",
        f'<rect class="ground" width="{_COUNTED_WIDTH}" height="{height}" rx="6"/>',
        _text("title", 12, 21, title),
    ]
    for i, (name, count) in enumerate(zip(names, counts, strict=True)):
        y = _TOP + _LINE * i
        length = _LONGEST * count / most
        lines += [
            _text("", _LEFT - 8, y + 14, name, "end"),
            _bar("bar", _LEFT, y + 3, length, 15, radius=2),
            _text("soft", _LEFT + length + 6, y + 14, f"{count} ({100 * count / total:.1f} %)"),
        ]
    return "\n".join([*lines, "</svg>"]) + "\n"


def _bar(
    kind: str, x: float, y: int, width: float, height: int, *, title: str = "", radius: int = 0
) -> str:
    """A rectangle of this class; title: shown beside the pointer."""
    corners = f' rx="{radius}"' if radius else ""
    place = f'x="{_px(x)}" y="{y}" width="{width:.1f}" height="{height}"{corners}'
    inside = f"><title>{escape(title)}</title></rect>" if title else "/>"
    return f'<rect class="{kind}" {place}{inside}'


def _text(kind: str, x: float, y: int, text: str, anchor: str = "") -> str:
    """A text whose anchor ("start", "middle", "end") stands at x, y on its base line."""
    css = f' class="{kind}"' if kind else ""
    at = f' text-anchor="{anchor}"' if anchor else ""
    return f'<text{css} x="{_px(x)}" y="{y}"{at}>{escape(text)}</text>'


def _px(x: float) -> str:
    return str(x) if isinstance(x, int) else f"{x:.1f}"


def _drawn_mm(values: Mapping[str, float], target: str) -> float:
    return max(0.0, float(values.get(target, 0.0)))
