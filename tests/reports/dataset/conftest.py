"""A small real data set for the tests of this folder."""

from small_dataset import dataset_copy, dataset_made

__all__ = ["dataset_copy", "dataset_made"]
