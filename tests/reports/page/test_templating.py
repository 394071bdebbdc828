"""The writing of a page: its place is tried first."""

import pytest

from pjpdaf.errors import BenchError
from reports.page.templating import write_made


def test_a_place_that_cannot_be_written_is_told_before_the_page_is_made(tmp_path):
    def make():
        raise AssertionError("made in vain")

    with pytest.raises(BenchError, match="Make its folder first"):
        write_made(tmp_path / "nowhere" / "page.html", make)
    with pytest.raises(BenchError, match="is a folder; add a file name"):
        write_made(tmp_path, make)
