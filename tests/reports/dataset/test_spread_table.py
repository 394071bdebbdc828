"""The table of the spread, as a reader of the card sees it."""

from __future__ import annotations

import json

from reports.dataset.card import card_text
from reports.dataset.spread_table import spread_table
from sim.dataset.reader import open_dataset
from sim.dataset.spread import BINS, QUANTITIES, Spread, spread_of
from sim.dataset.statistics import statistics_of


def test_a_row_says_values_range_quartiles_tenths_and_distance(dataset_made):
    even = (0, *[1] * BINS, 0)
    one_end = (0, *[7] * 10, *[0] * (BINS - 10), 0)
    none = (0,) * (BINS + 2)
    quantity = QUANTITIES["rig_distance"]
    spreads = {str(i): Spread(quantity, counts) for i, counts in enumerate((even, one_end, none))}
    *_, first, second, third = spread_table(open_dataset(dataset_made), spreads).splitlines()
    title = "Cameras ahead of the shoulders, per sequence"
    tenths = "10 10 10 10 10 10 10 10 10 10"
    assert first == (
        f"| {title} | 1000 | 1.1 to 1.7 m | 1.1 / 1.25 / 1.4 / 1.55 / 1.7 | {tenths} | 0.00 |"
    )
    assert second.endswith("| 100 0 0 0 0 0 0 0 0 0 | 0.99 |")
    assert third == f"| {title} | 0 | | | | |"


def test_the_card_has_the_table_and_who_is_where(dataset_copy):
    dataset = open_dataset(dataset_copy)
    text = card_text(dataset, statistics_of(dataset))
    assert spread_table(dataset, spread_of(dataset)) in text
    assert "not stated by the recipes" in text
    for number, sequence in enumerate(dataset.sequences):
        path = sequence.folder / "recipe.json"
        identity = {"room": f"{number}" * 16, "body": "b" * 16, "rig": f"{number % 2}" * 16}
        path.write_text(json.dumps({**sequence.recipe, "identity": identity}))
    again = open_dataset(dataset_copy)
    number = len(again.sequences)
    text = card_text(again, statistics_of(again))
    assert f"{number} sequences; different rooms: {number}, bodies: 1, rigs: 2 (`identity`" in text
    assert "| 11111111 | bbbbbbbb | 11111111 |" in text
