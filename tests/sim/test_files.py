"""A refusing disk is one clear line; a file is whole or is not there."""

import errno
import importlib.util
import os
import re
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.interfaces import Estimates
from reports.footage.tracks import TrackWriter
from reports.pictures.film import FilmWriter
from scenarios.console.folder import written_whole
from sim.files import disk_faults, near_paths, write_fault, written_whole_file

FULL = Path("/dev/full")
needs_full = pytest.mark.skipif(not FULL.exists(), reason="no /dev/full")
as_root = pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")


def names(folder):
    return sorted(file.name for file in folder.iterdir())


@pytest.mark.parametrize(
    ("number", "code", "remedy"),
    [
        (errno.ENOSPC, 5, "free some space"),
        (errno.EDQUOT, 5, "remove files"),
        (errno.EACCES, 2, "may write to"),
        (errno.EROFS, 2, "may write to"),
        (errno.ENOENT, 2, "make its folder"),
        (errno.EIO, 2, ""),
    ],
)
def test_a_fault_says_what_where_why_and_how_to_put_it_right(number, code, remedy):
    fault = write_fault(Path("a/run"), "the run", OSError(number, "said\nin two lines"))
    assert fault.exit_code == code
    assert str(fault).startswith(f"a/run: cannot write the run: {os.strerror(number)}.")
    assert remedy in str(fault).lower()
    assert "\n" not in str(fault)


def test_a_link_to_nowhere_is_not_what_is_meant_instead_of_it(tmp_path):
    (tmp_path / "case.yaml").symlink_to("nowhere")
    assert near_paths(tmp_path / "case.yaml") == ""
    (tmp_path / "cases.yaml").touch()
    assert near_paths(tmp_path / "case.yaml") == f"; did you mean {tmp_path / 'cases.yaml'}?"


def test_an_error_without_a_number_is_told_in_its_own_words():
    fault = write_fault(Path("a"), "the film", OSError("odd\n thing."))
    assert str(fault) == "a: cannot write the film: odd thing."
    assert fault.exit_code == 2


@pytest.mark.parametrize(
    ("made_in", "said"),
    [
        ("/d/.out.part-x7_/tracks.csv", "/d/out/tracks.csv"),
        ("/d/.film.mp4.part-ab12/film.mp4", "/d/film.mp4"),
        ("/d/.run.part-ab12/run.json", "/d/run/run.json"),
        ("/d/plain.part-1/file", "/d/plain.part-1/file"),
    ],
)
def test_a_fault_names_the_file_that_was_asked_for(made_in, said):
    fault = write_fault(Path(made_in), "it", OSError(errno.EIO, ""))
    assert str(fault).startswith(f"{said}: ")


@needs_full
def test_tracks_on_a_full_disk(tmp_path):
    (tmp_path / "tracks.csv").symlink_to(FULL)
    with (
        pytest.raises(InfrastructureError, match="cannot write the tracks: No space left"),
        closing(TrackWriter(tmp_path, ())) as tracks,
    ):
        tracks.add(0, 0.0, Estimates.waiting())


@needs_full
def test_a_library_that_counts_in_its_own_errors(tmp_path):
    (tmp_path / "tracks.parquet").symlink_to(FULL)
    with (
        pytest.raises(InfrastructureError, match=r"the tracks: No space left on device\."),
        closing(TrackWriter(tmp_path, ())),
    ):
        pass


@needs_full
@pytest.mark.skipif(importlib.util.find_spec("av") is None, reason="without the extra video")
def test_a_film_on_a_full_disk_is_removed(tmp_path):
    (tmp_path / "film.mp4").symlink_to(FULL)
    noise = np.random.default_rng(0).integers(0, 255, (30, 240, 320, 3)).astype(np.uint8)

    def write(film):
        with closing(film):
            for picture in noise:
                film.add(picture)

    film = FilmWriter(tmp_path, "film", 3.0)
    with pytest.raises(InfrastructureError, match=r"/film\.mp4: cannot write the film: No space"):
        write(film)
    assert film.path is None
    assert names(tmp_path) == []


def test_a_name_with_dots_keeps_them(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with closing(FilmWriter(tmp_path, "my.film", 3.0)) as film:
        film.add(np.zeros((64, 64, 3), np.uint8))
    assert film.path == tmp_path / "my.film.webm"
    assert names(tmp_path) == ["my.film.webm"]


def test_a_file_appears_whole_or_not_at_all(tmp_path):
    path = tmp_path / "film.mp4"

    def fail(part):
        part.write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), written_whole_file(path, "it") as part:
        fail(part)
    assert names(tmp_path) == []
    with written_whole_file(path, "it") as part:
        assert part.name == path.name
        part.write_text("whole")
        assert not path.exists()
    assert names(tmp_path) == ["film.mp4"]
    assert path.read_text() == "whole"


def test_what_is_there_stays_unless_it_may_be_replaced(tmp_path):
    path = tmp_path / "page.html"
    path.write_text("mine")
    with pytest.raises(BenchError, match="exists; give another name"), written_whole_file(path, ""):
        pass
    assert path.read_text() == "mine"
    with written_whole_file(path, "it", replace=True) as part:
        part.write_text("new")
    assert path.read_text() == "new"
    with pytest.raises(BenchError, match="is a folder"), written_whole_file(tmp_path, "it"):
        pass


def test_a_folder_that_is_missing_a_file_or_gone_at_the_end(tmp_path):
    (tmp_path / "file").write_text("")
    for path, said in (("no/film.mp4", "make its folder"), ("file/film.mp4", "part of the path")):
        with (
            pytest.raises(BenchError, match=rf"(?i){said}"),
            written_whole_file(tmp_path / path, "the film"),
        ):
            pass
    nothing_written = written_whole_file(tmp_path / "film.mp4", "the film")
    with pytest.raises(BenchError, match="the film: No such file"), nothing_written:
        pass
    assert names(tmp_path) == ["file"]


@as_root
def test_a_folder_that_may_not_be_written_to(tmp_path):
    tmp_path.chmod(0o555)
    refused = written_whole_file(tmp_path / "film.mp4", "the film")
    with pytest.raises(BenchError, match=r"Permission denied\..*may write to"), refused:
        pass


def test_results_below_a_file_are_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(BenchError) as caught, written_whole(tmp_path / "file/out"):
        pass
    assert caught.value.exit_code == 2
    assert re.fullmatch(r".*/file/out: cannot write the results: .*\.", str(caught.value))


def test_other_errors_pass_as_they_are(tmp_path):
    with pytest.raises(ZeroDivisionError), disk_faults(tmp_path, "it"):
        1 / 0  # noqa: B018
    with pytest.raises(BenchError, match="already said"), disk_faults(tmp_path, "it"):
        raise BenchError("already said")
