"""Rows of an episode as bytes: a run saved of them has the same bytes, and damage shows."""

import struct
from dataclasses import fields, replace

import numpy as np
import pyarrow as pa
import pytest

from reports.run.rows import rows_of
from reports.run.save import save
from reports.run.schema import TABLES
from reports.run.stored_rows import rows_from_bytes, rows_to_bytes
from reports.score.records import EpisodeFailure, OverlayPicture, Still


@pytest.fixture(scope="module")
def rows(played):
    return [
        *(
            replace(
                rows_of(one),
                pictures=(OverlayPicture(3, b"\xff\xd8jpeg"), OverlayPicture(7, b"")),
                film=(Still(0, b"RIFF"),),
                renderer="egl, ünter",
                replayed=number % 2 == 0,
            )
            for number, one in enumerate(played)
        ),
        rows_of(EpisodeFailure("cross", 77, "no step\ntoday", "g", "digest", "plug-in")),
    ]


def test_a_run_of_stored_rows_has_the_same_bytes(rows, tmp_path, info):
    save(tmp_path / "a", rows, info)
    save(tmp_path / "b", [rows_from_bytes(rows_to_bytes(one)) for one in rows], info)
    for path in sorted((tmp_path / "a").rglob("*")):
        if path.is_file():
            other = tmp_path / "b" / path.relative_to(tmp_path / "a")
            assert path.read_bytes() == other.read_bytes(), path.name
    assert len(list((tmp_path / "b").rglob("*"))) > len(TABLES)


def test_every_field_comes_back(rows):
    for one in rows:
        back = rows_from_bytes(rows_to_bytes(one))
        for field in fields(one):
            if field.name not in ("frames", "episodes", "detections", "cameras", "tracking"):
                assert getattr(back, field.name) == getattr(one, field.name), field.name


def test_numbers_that_json_does_not_have(rows):
    columns = dict(rows[0].frames)
    odd = [np.float64("nan"), float("inf"), -0.0, np.float64(1) / 3, None, np.int64(2)]
    columns["error_mm"] = (odd * len(columns["error_mm"]))[: len(columns["error_mm"])]
    back = rows_from_bytes(rows_to_bytes(replace(rows[0], frames=columns)))
    mine, theirs = (pa.array(one["error_mm"], pa.float64()) for one in (back.frames, columns))
    assert mine.buffers()[1].to_pybytes() == theirs.buffers()[1].to_pybytes()
    assert mine.null_count == theirs.null_count > 0


def test_damaged_bytes_are_refused(rows):
    data = rows_to_bytes(rows[0])
    text = len(data) - sum(len(p.jpeg) for p in rows[0].pictures) - len(b"RIFF")
    for at in (0, 3, 10, 30, text // 2, text - 1, len(data) - 1):
        with pytest.raises(ValueError, match="are"):
            rows_from_bytes(data[:at])
    with pytest.raises(ValueError, match="have bytes behind their end"):
        rows_from_bytes(data + b"x")


def stored(text, size=None):
    packed = pa.Codec("zstd", 3).compress(text, asbytes=True)
    return struct.pack("<4sQQ", b"rows", len(packed), len(text) if size is None else size) + packed


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\x80\x04N.",
        stored(b"[]"),
        stored(b"{}"),
        stored(b"[" * 100_000),
        stored(b"{" * 10),
        stored(b"x", size=2**60),
        stored(b"x", size=2),
    ],
)
def test_strange_bytes_are_refused(data):
    with pytest.raises(ValueError, match=r"are|Expecting|expected"):
        rows_from_bytes(data)


def test_a_value_of_another_type_is_refused(rows):
    wrong = replace(rows[0], episodes=({**rows[0].episodes[0], "seed": "one"},))
    with pytest.raises(ValueError, match="are"):
        rows_from_bytes(rows_to_bytes(wrong))
