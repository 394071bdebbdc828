"""The drawn truth lies where the masks and the cameras say."""

import dataclasses

import cv2
import numpy as np
import pytest

from pjpdaf.camera import distort_points, project
from pjpdaf.frames import StereoFrame
from reports.pictures.overlay import STRIP, text_width
from reports.pictures.truth_overlay import (
    _COLOURS,
    STRIP_PX,
    draw_outlines,
    fitting,
    merged_text,
    script_text,
    thumbnail,
    truth_picture,
    visible_text,
)

GREY = np.full((480, 640, 3), 128, np.uint8)


def blobs(seed, size=(480, 640)):
    """Labels (h, w) of three discs that may touch; returns them with their centres' labels."""
    rng = np.random.default_rng(seed)
    labels = np.full(size, -1, np.int8)
    ys, xs = np.indices(size)
    for t in range(3):
        x, y, r = rng.uniform(80, 560), rng.uniform(80, 400), rng.uniform(12, 40)
        labels[(xs - x) ** 2 + (ys - y) ** 2 < r**2] = t
    return labels


def scene(tools, merged=None, labels=("reach",), distortion=(), **of_views):
    cameras = tools.cameras(distortion)
    centres = tools.paths(1, 3.0)[0]
    pairs = np.zeros((3, 3), bool) if merged is None else merged
    truth = tools.truth(7, 2.5, centres, cameras, (pairs, pairs), labels)
    views = tuple(dataclasses.replace(view, **of_views) for view in truth.views)
    return cameras, dataclasses.replace(truth, views=views)


def draw(cameras, truth, pictures=(GREY, GREY), labels=None, trails=None, title=""):
    frame = StereoFrame(truth.index, truth.time_s, tuple(pictures))
    nothing = np.full((480, 640), -1, np.int8)
    trails = trails or (truth.centres_m[None],) * 2
    return truth_picture(frame, cameras, labels or (nothing,) * 2, truth, trails, title).astype(int)


@pytest.mark.parametrize("seed", range(5))
def test_outlines_run_around_every_mask_and_cover_none_of_its_skin(seed):
    labels = blobs(seed)
    canvas = GREY.copy()
    draw_outlines(canvas, labels, thickness_px=2)
    near = np.zeros(labels.shape, bool)
    for t, colour in enumerate(_COLOURS):
        mask = (labels == t).astype(np.uint8)
        around = cv2.dilate(mask, np.ones((3, 3), np.uint8)) > mask
        near |= cv2.dilate(mask, np.ones((7, 7), np.uint8)) > mask
        # A later target's line may run over an earlier one's.
        later = cv2.dilate((labels > t).astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
        line = canvas[around & ~later]
        assert len(line) > 20
        assert (line == colour).all()
    assert (canvas[~near] == 128).all()


@pytest.mark.parametrize("distortion", [(), (-0.3, 0.1, 0.0, 0.0, 0.0)])
def test_crosses_lie_on_the_projected_centres_as_the_lens_bends_them(tools, distortion):
    cameras, truth = scene(tools, distortion=distortion)
    trails = [truth.centres_m[None], truth.centres_m[None] + np.array([0.0, 0.03, 0.0])]
    sheet = draw(cameras, truth, trails=trails, title="cross seed 3")
    assert sheet.shape == (480 + STRIP_PX, 1284, 3)
    for v, camera in enumerate(cameras):
        for t, point in enumerate(distort_points(camera, project(camera, trails[v][-1]))):
            x, y = np.round(point).astype(int) + np.array([v * 644, 0])
            for dx, dy in ((0, 0), (-5, 0), (0, 5)):
                assert np.abs(sheet[y + dy, x + dx] - _COLOURS[t]).max() < 60


def test_a_trail_leads_to_the_centre(tools):
    cameras, truth = scene(tools)
    before = truth.centres_m + np.array([0.0, 0.0, 0.1])
    share = np.linspace(0, 1, 8)[:, None, None]
    trail = before + share * (truth.centres_m - before)
    sheet = draw(cameras, truth, trails=(trail, trail))
    middle = np.round(project(cameras[0], trail[4])).astype(int)
    for t, (x, y) in enumerate(middle):
        assert np.abs(sheet[y, x - 1 : x + 2] - _COLOURS[t]).max(axis=1).min() < 100


def test_a_missing_picture_is_grey_and_carries_no_truth(tools):
    cameras, truth = scene(tools)
    sheet = draw(cameras, truth, pictures=(None, GREY), labels=(blobs(0), blobs(0)))
    left, right = sheet[:480, :640], sheet[:480, 644:]
    assert (np.ptp(left, axis=2) == 0).all()
    assert (left > 200).any()  # it says so
    assert np.ptp(right, axis=2).any()


def test_the_pictures_given_are_not_drawn_into(tools):
    cameras, truth = scene(tools)
    picture = GREY.copy()
    draw(cameras, truth, pictures=(picture, picture), labels=(blobs(1), blobs(1)))
    frame = StereoFrame(0, 0.0, (picture, picture))
    thumbnail(frame, cameras, (blobs(1), blobs(1)), truth, 200)
    assert (picture == 128).all()


def test_words_of_a_view(tools):
    shown = scene(tools)[1].views[0]
    assert [visible_text(shown, t) for t in range(3)] == ["88 %", "100 %", "80 %"]
    hardly = dataclasses.replace(shown, visible_px=np.array([1, 0, 0]), amodal_px=[4500, 10, 0])
    assert [visible_text(hardly, t) for t in range(3)] == ["1 %", "hidden", "out of view"]
    assert merged_text(shown) == ""
    pairs = np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]], bool)
    assert merged_text(dataclasses.replace(shown, merged=pairs)) == "H+R, R+L"


def test_hidden_and_merged_targets_and_those_behind_are_drawn(tools):
    pairs = ~np.eye(3, dtype=bool)
    cameras, truth = scene(tools, merged=pairs)
    plain = draw(cameras, dataclasses.replace(truth, views=scene(tools)[1].views))
    assert (draw(cameras, truth) != plain).any()
    none = np.full((3, 2), np.nan)
    hidden = tuple(
        dataclasses.replace(
            view, centroids_px=none, visible_px=np.zeros(3, int), boxes_px=np.full((3, 4), np.nan)
        )
        for view in truth.views
    )
    apart = [dataclasses.replace(view, merged=np.zeros((3, 3), bool)) for view in hidden]
    sheet = draw(cameras, dataclasses.replace(truth, views=tuple(apart)))
    x, y = np.round(project(cameras[0], truth.centres_m))[1].astype(int)
    assert (sheet[y, x] == 128).all()  # a ring, no cross
    behind = dataclasses.replace(truth, centres_m=truth.centres_m + np.array([50.0, 0, 0]))
    draw(cameras, dataclasses.replace(behind, views=tuple(apart)))


def test_events_are_named_and_merges_are_not_named_twice(tools):
    truth = scene(tools, labels=("reach", "merge:head+left_hand:left_view", "hold:can"))[1]
    assert script_text(truth) == "reach, hold:can"
    assert fitting("short", 400) == "short"
    cut = fitting("word " * 60, 400)
    assert cut.endswith("...")
    assert text_width(cut) <= 400


@pytest.mark.parametrize("seed", range(4))
def test_a_thumbnail_shows_every_target_in_both_views(tools, seed):
    cameras, truth = scene(tools)
    shift = np.random.default_rng(seed).uniform(-0.25, 0.25)
    truth = tools.truth(0, 0.0, truth.centres_m + np.array([0, shift, 0]), cameras)
    labels = []
    for view in truth.views:
        mask = np.full((480, 640), -1, np.int8)
        for t, (x, y, w, h) in enumerate(view.boxes_px.astype(int)):
            mask[max(y, 0) : y + h, max(x, 0) : x + w] = t
        labels.append(mask)
    small = thumbnail(StereoFrame(0, 0.0, (GREY, GREY)), cameras, labels, truth, 240)
    assert small.shape == (240, 484, 3)
    for part in (small[:, :240], small[:, 244:]):
        for colour in _COLOURS:
            assert (np.abs(part.astype(int) - colour).max(axis=2) < 40).sum() > 20


def test_targets_far_apart_take_the_whole_width(tools):
    cameras, truth = scene(tools)
    wide = truth.centres_m + np.array([[0, 0, 0], [0, -0.28, 0], [0, 0.28, 0]])
    truth = tools.truth(0, 0.0, wide, cameras)
    nothing = (np.full((480, 640), -1, np.int8),) * 2
    small = thumbnail(StereoFrame(0, 0.0, (GREY, None)), cameras, nothing, truth, 240)
    assert small.shape == (240, 484, 3)
    assert (small[0, :240] == STRIP).all()  # the picture is lower than the square
    assert (small[120, :240] == 128).all()
