"""`scenarios sheet`, as users start it."""

import cv2
import pytest
from commands import in_this_process

from reports.pictures.contact_sheet import GAP_PX
from scenarios.catalogue.sheet import COLUMNS, WIDTH_PX


def test_a_sheet_has_a_picture_of_each_first_seed(tmp_path):
    out = tmp_path / "rooms.webp"
    words = ("scenarios", "sheet", "calm_table", "--set", "frames=3", "--pictures", 2)
    done = in_this_process(*words, "--out", out)
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"sheet: {out} (2 episodes)\n"
    picture = cv2.imread(str(out))
    assert picture.shape == (
        480 * WIDTH_PX // 640 + 2 * GAP_PX,
        COLUMNS * (WIDTH_PX + GAP_PX) + GAP_PX,
        3,
    )
    first, second = (
        picture[GAP_PX:-GAP_PX, GAP_PX + i * (WIDTH_PX + GAP_PX) :][:, :WIDTH_PX] for i in (0, 1)
    )
    assert first.std() > 20
    assert (first != second).any()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("drink", "--out", "a.gif"), "--out a.gif: must end in .webp, .jpg, .png"),
        (
            ("drink", "--out", "a.png", "--pictures", 0),
            "--pictures must be between 1 and 400, got 0",
        ),
        (("drnk", "--out", "a.png"), "no scenario or suite 'drnk'; did you mean drink?"),
    ],
)
def test_what_cannot_be_drawn_is_one_line(words, message):
    done = in_this_process("scenarios", "sheet", *words)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr
