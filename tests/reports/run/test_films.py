"""Films of a run: kept whole, read back, checked."""

import pytest

from pjpdaf.errors import BenchError
from reports.run.load import load, read_film


def test_films_are_kept_whole_and_checked(run):
    read = load(run)
    # Both first seeds, and the one that swapped.
    kept = [(film["scenario"], film["seed"], film["frames"]) for film in read.meta["films"]]
    assert kept == [("calm_table", 0, 3), ("cross", 0, 3), ("cross", 1, 3)]
    assert not any(film["whole"] for film in read.meta["films"])
    film = read.meta["films"][2]["file"]
    assert read_film(read, film) == {f: f"RIFF 1 {f}".encode() for f in (0, 3, 11)}
    (run / film).write_bytes(b"PK")
    with pytest.raises(BenchError, match=r"0004_cross_1\.zip: is damaged"):
        read_film(read, film)
    with pytest.raises(BenchError, match=r"0004_cross_1\.zip: is damaged"):
        load(run)
