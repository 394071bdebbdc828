"""A data set as one page that opens from disk: both views, all layers, boxes, keypoints, values."""

from __future__ import annotations

from collections.abc import Sequence

from pjpdaf.targets import TARGETS
from reports.dataset.histograms import histogram_svg, histogram_text
from reports.dataset.sequence_data import sequence_data
from reports.dataset.sequence_view import LAYERS, SequenceView
from reports.page.packing import data_address, json_text
from reports.page.templating import rendered, script, shared_scripts, styles
from reports.words import LABELS
from sim.dataset.reader import Dataset
from sim.dataset.statistics import Statistics

MARK = "pjpdaf-bench dataset show"


def dataset_page(
    dataset: Dataset, statistics: Statistics, views: Sequence[SequenceView], title: str
) -> str:
    """Build the page. views: the sequences with pictures, the first of the data set."""
    layers = [name for name in LAYERS if any(name in view.layers for view in views)]
    return rendered(
        "dataset.html.j2",
        title=title,
        mark=MARK,
        statistics=statistics,
        sequences=dataset.sequences,
        views=views,
        data=[json_text(sequence_data(view)) for view in views],
        layers=layers,
        rectified=[name for name in layers if LAYERS[name][2]],
        charts=[
            (
                data_address("image/svg+xml", histogram_svg(histogram).encode()),
                f"{histogram.bins.title}. {histogram_text(histogram)}",
            )
            for histogram in statistics.histograms.values()
        ],
        targets=[(target, LABELS[target]) for target in TARGETS],
        licence=dataset.manifest.get("licence", ""),
        css=styles("player.css", "dataset.css"),
        scripts=[*shared_scripts(), script("unpack.js", "shared.js", "dataset.js")],
    )
