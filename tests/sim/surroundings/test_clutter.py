"""Clutter: where the table is, and where nothing may stand."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from plain_surroundings import PLAIN

from sim.specs import ObjectSpec, RoomSpec
from sim.surroundings.clutter import bystander_of, clutter_of, outside_corner
from sim.surroundings.seat_and_table import _outline
from sim.surroundings.words import TABLE_SHAPES

PALMS_M = np.array([[[0.34, -0.20, 0.76], [0.34, 0.20, 0.76]]] * 3)
SHOULDERS_M = np.array([[[0.0, -0.19, 0.99], [0.0, 0.19, 0.99]]] * 3)
HEADS_M = np.array([[0.02, 0.0, 1.23]] * 3)
CAMERAS_M = np.array([[1.4, -0.05, 1.4], [1.4, 0.05, 1.4]])
CAN = ObjectSpec("can", "can", (0.066, 0.066, 0.115), (0.7, 0.1, 0.1), (0.45, -0.3))


def placed(**changes):
    around = replace(PLAIN, **{"clutter": 10, **changes})
    room = RoomSpec(surroundings=around, objects=(CAN,))
    return room, clutter_of(room, PALMS_M, SHOULDERS_M, HEADS_M, CAMERAS_M)


@pytest.mark.parametrize("shape", TABLE_SHAPES)
@pytest.mark.parametrize("size", [(0.62, 1.9), (0.95, 1.2), (0.75, 1.5)])
def test_the_outline_is_that_of_the_drawn_table(shape, size):
    room = RoomSpec(
        table_depth_m=size[0],
        table_width_m=size[1],
        surroundings=replace(PLAIN, table_shape=shape),
    )
    half = np.array(size) / 2
    near = 0.0 if shape == "straight" else 0.05
    far = {"straight": 0.0, "rounded": 0.16, "half_round": 0.92}[shape] * min(size[0], half[1])
    drawn = _outline(half, near, far).astype(np.float32)
    rng = np.random.default_rng(1)
    for x, y in rng.uniform(-1.1, 1.1, (400, 2)) * half:
        inside = cv2.pointPolygonTest(drawn, (float(x), float(y)), True)
        outside = outside_corner(room, room.table_near_x_m + half[0] + float(x), float(y))
        if abs(inside) > 0.03:  # the rounding of the near corners is small
            assert (outside < 0) == (inside > 0), (x, y)


def test_nothing_stands_where_the_motion_is_or_is_seen():
    room, things = placed()
    assert len(things) >= 3
    for spec in things:
        x, y = spec.position_xy_m
        radius = 0.5 * np.hypot(*spec.size_m[:2])
        top = room.table_height_m + spec.size_m[2]
        assert np.hypot(x - 0.45, y + 0.3) > radius  # not in the can
        for palm in PALMS_M[0]:
            assert np.hypot(x - palm[0], y - palm[1]) > radius + 0.1
            for camera in CAMERAS_M:
                # The height of the line of sight where it passes the thing, if it does.
                along = palm[:2] - camera[:2]
                share = np.dot([x, y] - camera[:2], along) / np.dot(along, along)
                passed = np.hypot(*(camera[:2] + share * along - [x, y]))
                if 0 < share < 1 and passed < radius:
                    assert camera[2] + share * (palm[2] - camera[2]) > top


def test_the_arrangement_decides_and_nothing_else_does():
    assert placed() == placed()
    assert placed(arrangement=2)[1] != placed()[1]
    assert placed(wall="brick")[1] == placed()[1]
    assert placed(clutter=0)[1] == ()
    assert [spec.kind for spec in placed(clutter=0, screen="table")[1]] in ([], ["monitor"])
    assert clutter_of(RoomSpec(), PALMS_M, SHOULDERS_M, HEADS_M, CAMERAS_M) == ()


@pytest.mark.parametrize("depth", [1.3, 1.9, 2.6])
def test_a_second_person_stands_inside_the_room_behind_the_first(depth):
    for arrangement in range(20):
        around = replace(PLAIN, arrangement=arrangement, depth_m=depth, bystander="still")
        x, y = bystander_of(around).position_xy_m
        assert -depth + 0.3 < x < -0.5
        assert 0.4 < abs(y) < around.half_width_m - 0.3
    assert bystander_of(PLAIN) is None
