"""Contact sheets, and pictures of a limited size."""

import cv2
import numpy as np
import pytest

from reports.pictures.contact_sheet import GAP_PX, contact_sheet, small_jpeg


def test_a_small_picture_is_small_whatever_it_shows():
    noise = np.random.default_rng(0).integers(0, 255, (240, 484, 3)).astype(np.uint8)
    smooth = cv2.GaussianBlur(noise, (0, 0), 6)
    assert len(small_jpeg(smooth)) <= 12_000
    rough = small_jpeg(cv2.GaussianBlur(noise, (0, 0), 1.2), 20_000)
    assert len(rough) <= 20_000
    assert cv2.imdecode(np.frombuffer(rough, np.uint8), cv2.IMREAD_COLOR).shape == noise.shape


@pytest.mark.parametrize(("count", "columns", "rows"), [(1, 1, 1), (12, 2, 6), (7, 3, 3)])
def test_a_contact_sheet_holds_every_picture_in_order(count, columns, rows):
    pictures = [np.full((20, 30, 3), 100 + i, np.uint8) for i in range(count)]
    sheet = contact_sheet(pictures, columns)
    assert sheet.shape == (rows * (20 + GAP_PX) + GAP_PX, columns * (30 + GAP_PX) + GAP_PX, 3)
    found = [int(v) for v in dict.fromkeys(sheet[..., 0].ravel().tolist()) if v >= 100]
    assert found == [100 + i for i in range(count)]
