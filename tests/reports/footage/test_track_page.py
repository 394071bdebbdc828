"""The page of footage: escaped, self-contained, films inside or linked, worked in a browser."""

import re

import cv2
import numpy as np
import pytest
from every_reader import faults

from pjpdaf.camera import StereoRig
from reports.footage.track_page import FILM_BYTES, TrackInfo, track_page
from reports.page.templating import write_text

HOSTILE = "</script><b>x{{ 7*7 }}"
WAITING, TRACKED, LOST = (("waiting",) * 3, ("tracked",) * 3, ("lost", "tracked", "tracked"))


@pytest.fixture
def info(tools):
    rig = StereoRig(*tools.cameras())
    provenance = {"argv": ["track", HOSTILE], "versions": {"numpy": "2"}, "commit": None}
    return lambda **changes: TrackInfo(
        **{
            "title": HOSTILE,
            "complete": False,
            "film": None,
            "rig": rig,
            "sources": [("left", HOSTILE)],
            "parameters": {"gate": 15.0, "note": HOSTILE},
            "changed": {"gate": 12.0},
            "provenance": {**provenance, "cpu": "x", "platform": "y", "dirty": False},
            **changes,
        }
    )


def test_it_is_escaped_and_asks_for_nothing(record_of, info):
    page = track_page(record_of([WAITING, TRACKED, LOST], missing=(1,)), info())
    assert "<b>x" not in page
    assert "&lt;/script&gt;&lt;b&gt;x{{ 7*7 }}" in page
    assert "Incomplete." in page
    assert "Pictures missing in frame 1;" in page
    for attribute in re.findall(r'(?:src|href)="([^"]*)"', page):
        assert attribute.startswith(("#", "data:")), attribute[:60]
    assert len(page) < 100_000


def test_a_short_film_is_inside_and_a_long_one_is_linked(record_of, info, tmp_path):
    record = record_of([TRACKED] * 2)
    for size, inside in ((10, True), (FILM_BYTES + 1, False)):
        film = tmp_path / "overlay film.mp4"
        film.write_bytes(bytes(size))
        page = track_page(record, info(film=film, complete=True))
        assert ('src="data:video/mp4;base64,' in page) == inside
        assert 'href="overlay%20film.mp4"' in page
        assert "Incomplete." not in page


def test_it_is_for_every_reader(record_of, info, opened, tmp_path):
    grey = cv2.imencode(".jpg", np.full((120, 320, 3), 90, np.uint8))[1].tobytes()
    statuses = [WAITING, *[TRACKED] * 6, *[LOST] * 3]
    page = track_page(record_of(statuses, missing=(3,), jpeg=lambda _: grey), info())
    path = write_text(tmp_path / "report.html", page)
    with opened(path, "#tracks .chart") as view:
        assert faults(view) == []
