"""A can or cup at the mouth."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from sim.motion.posture import posture
from sim.motion.stage import Stage
from sim.motion.strokes import HandState, quaternion_of
from sim.person.kinematics import OUTWARD
from sim.pose import Transform
from sim.specs import ObjectSpec
from sim.vectors import about_y, about_z


def held_at_mouth(
    stage: Stage, side: int, closed: HandState, can: ObjectSpec, place: Transform, tilt_rad: float
) -> HandState:
    """The hand that holds the can, taken at `closed` from `place`, with its rim at the mouth.

    tilt_rad: how far the can's top leans towards the face.
    """
    anatomy, inward = stage.scene.anatomy, -OUTWARD[side]
    nod = -0.25 * tilt_rad
    guess = replace(closed, air=1.0, with_head=1.0, nod_rad=nod)
    other = stage.rest(1 - side)
    _, head = posture(anatomy, (guess, other) if side == 0 else (other, guess), np.zeros(3))
    lips = np.array([0.43 * anatomy.head_depth_m, 0.0, -0.26 * anatomy.head_height_m])
    mouth = head.position_m + head.rotation @ lips
    # The can turns with the hand about its own axis by 0.75 rad: fingers across the face.
    can_turn = about_y(-tilt_rad) @ about_z(inward * 0.75) @ place.rotation
    up, towards = can_turn[:, 2], np.array([-math.cos(tilt_rad), 0.0, -math.sin(tilt_rad)])
    radius, tall = 0.5 * can.size_m[0], can.size_m[2]
    base = mouth - tall * up - (0.85 * radius) * towards
    hand_in_can = place.rotation.T @ (closed.position_m - place.position_m)
    turn = can_turn @ place.rotation.T @ closed.rotation
    return HandState(
        base + can_turn @ hand_in_can,
        quaternion_of(turn),
        closed.curls,
        air=0.5,
        with_head=1.0,
        nod_rad=nod,
        swivel_rad=0.45,
    )
