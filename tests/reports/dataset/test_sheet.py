"""The sheet of a data set."""

from dataclasses import replace

import pytest

from reports.dataset.sheet import GAP_PX, TILE_PX, dataset_sheet


@pytest.fixture(scope="module")
def dataset(labelled):
    return labelled


def test_the_sheet_has_a_row_a_sequence(dataset):
    sheet = dataset_sheet([(one, [0, 3]) for one in dataset.sequences])
    assert sheet.shape[1] == GAP_PX + 2 * 4 * (TILE_PX + GAP_PX)
    lone = dataset_sheet([(dataset.sequences[1], [0])])
    assert lone.shape[1] == GAP_PX + 2 * (TILE_PX + GAP_PX)  # it has colour and depth
    assert sheet[60:200, GAP_PX : GAP_PX + TILE_PX].std() > 20


def test_names_of_a_stranger_do_not_break_the_sheet(dataset):
    entry = {"label": "ü" * 400, "seed": None}
    assert dataset_sheet([(replace(dataset.sequences[0], entry=entry), [0])]).ndim == 3
