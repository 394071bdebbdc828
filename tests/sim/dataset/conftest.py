"""Small real data sets for the tests of this folder."""

from damaged_dataset import copies, copy, plain, plain_copy, single, trio
from small_dataset import dataset_copy, dataset_made

__all__ = [
    "copies",
    "copy",
    "dataset_copy",
    "dataset_made",
    "plain",
    "plain_copy",
    "single",
    "trio",
]
