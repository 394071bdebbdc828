"""The data set that the tests of the exports read."""

import pytest

import sim.dataset


@pytest.fixture(scope="module")
def dataset(dataset_made):
    return sim.dataset.open(dataset_made)
