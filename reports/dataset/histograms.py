"""Histograms of a data set as bars, and in words."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from reports.page.charts.bars import counted_bars
from sim.dataset.histograms import Histogram, shares


def histogram_svg(histogram: Histogram) -> str:
    """Draw a bar per bin, all series together, with its number and share."""
    bins = histogram.bins
    unit = f" [{bins.unit}]" if bins.unit else ""
    return counted_bars(bins.title + unit, bin_names(bins.edges), histogram.total)


def bin_names(edges: Sequence[float]) -> list[str]:
    """Names of the bins between edges, such as "0.4 – 0.6"."""
    pairs = itertools.pairwise(edges)
    # A true minus, so that a negative edge is not read as a range.
    return [f"{low:g} – {high:g}".replace("-", "−") for low, high in pairs]


def histogram_text(histogram: Histogram) -> str:
    """The shares in words, for readers who do not see the picture."""
    bars = zip(bin_names(histogram.bins.edges), shares(histogram.total), strict=True)
    unit = f" {histogram.bins.unit}" if histogram.bins.unit else ""
    return "; ".join(f"{name}{unit}: {100 * share:.1f} %" for name, share in bars)
