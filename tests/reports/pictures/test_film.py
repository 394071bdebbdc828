"""Films with and without the extra `video`."""

import sys
from contextlib import closing

import cv2
import numpy as np
import pytest

from reports.pictures.film import FilmWriter


@pytest.mark.parametrize("extra", [True, False])
def test_film_with_and_without_the_extra(tmp_path, monkeypatch, extra):
    if extra:
        pytest.importorskip("av")
    else:
        monkeypatch.setitem(sys.modules, "av", None)
    with closing(FilmWriter(tmp_path, "film", 3.0)) as film:
        for i in range(5):
            film.add(np.full((101, 203, 3), 40 * i, np.uint8))
    assert film.path == tmp_path / ("film.mp4" if extra else "film.webm")
    capture = cv2.VideoCapture(str(film.path))
    frames = []
    while (read := capture.read())[0]:
        frames.append(read[1])
    capture.release()
    assert [frame.shape for frame in frames] == [(102, 204, 3)] * 5
    assert [round(float(f.mean()) / 40) for f in frames] == [0, 1, 2, 3, 4]
