"""`scenarios clip`: a BVH file in a unit that the command line gives, cut and written in metres."""

import numpy as np
import pytest

from pjpdaf.errors import BenchError
from scenarios.catalogue.clip import ClipRequest, describe_clip
from sim.clips.clip_files import load_clip
from tests.sim.clips.test_bvh import bvh


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "walk.bvh"
    path.write_text(bvh(n=120, unit_m=0.01))
    return path


def test_it_says_what_the_clip_is(file):
    lines = describe_clip(ClipRequest(file))
    assert "120 frames, 3.97 s of 3.97 s; joints: head, left_shoulder" in lines[0]
    assert any("unit taken to be cm" in line for line in lines)
    assert lines[1].startswith("left_hand: fastest ") or lines[1].startswith("right_hand: fastest ")


def test_a_part_in_metres_by_a_unit_that_is_given(file, tmp_path):
    out = tmp_path / "part.npz"
    describe_clip(ClipRequest(file, unit="0.011", begin_s=0.99, end_s=2.01, out=out))
    part, whole = load_clip(out), load_clip(file, unit_m=0.011)
    assert part.duration_s == pytest.approx(1.0, abs=0.05)
    np.testing.assert_allclose(part.path("left_hand"), whole.path("left_hand")[30:61], atol=1e-9)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"unit": "miles"}, "--unit must be one of mm, cm, m, inch"),
        ({"begin_s": 9.0}, "has 3.97 s; --begin leaves no motion"),
        ({"begin_s": 2.0, "end_s": 1.0}, "before --end"),
    ],
)
def test_a_fault_is_one_line(file, changes, words):
    with pytest.raises(BenchError, match=words):
        describe_clip(ClipRequest(file, **changes))
