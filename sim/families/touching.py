"""Hands brought to where they touch, and fingers closed on an object."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.contact.arm_shape import hand_capsules, hand_capsules_over
from sim.contact.capsules import Capsules, capsule_gap, overlaps
from sim.motion.bisection import bisect
from sim.motion.strokes import HandState
from sim.pose import Transform
from sim.specs import ObjectSpec


def hand_bars(anatomy: Anatomy, side: int, state: HandState) -> Capsules:
    """The capsules of a hand (0 right, 1 left) in this state, world frame."""
    return hand_capsules(anatomy, side, state.curls).placed(state.position_m, state.rotation)


def brought(
    anatomy: Anatomy, side: int, state: HandState, way: Floats, obstacle: Capsules
) -> HandState:
    """Move a hand along a unit vector (3,) until it touches the obstacle.

    It comes from 0.25 m back along the way, so from outside, even if it overlaps now.
    """

    def touches(way_m: float) -> bool:
        return capsule_gap(hand_bars(anatomy, side, state.moved(way_m * way)), obstacle)[0] > 0.0

    clear, _ = bisect(-0.25, 0.05, 20, touches)
    return state.moved(clear * way)


def closed(
    anatomy: Anatomy, side: int, state: HandState, most: Floats, obstacle: Capsules
) -> HandState:
    """Curl each finger, up to `most` (5,), until it touches the obstacle."""
    curls = state.curls.copy()
    for finger in range(5):
        first = 4 + 3 * finger  # after the palm's bars, three of each finger
        tried = np.linspace(curls[finger], most[finger], 40)
        trials = np.tile(curls, (len(tried), 1))
        trials[:, finger] = tried
        bars = hand_capsules_over(anatomy, side, trials).placed(state.position_m, state.rotation)
        of_finger = slice(first, first + 3)
        chain = Capsules(
            bars.starts_m[:, of_finger], bars.ends_m[:, of_finger], bars.radii_m[of_finger]
        )
        touches = np.flatnonzero(overlaps(chain, obstacle)[0].max(axis=(1, 2)) > 0.0)
        free = touches[0] if len(touches) else len(tried)
        if free:
            curls[finger] = tried[free - 1]
    return replace(state, curls=curls)


def object_bars(held: ObjectSpec, place: Transform) -> Capsules:
    """An upright object as bars, for fingers to close on."""
    half = 0.5 * np.array(held.size_m)
    if held.kind == "ball":
        starts, radii = np.array([[0.0, 0.0, half[2]]]), half[:1]
        ends = starts + np.array([0.0, 0.0, 1e-4])
    else:
        thin = 0.012 if held.kind == "box" else 0.82 * half[0]
        x, y = np.meshgrid(*(np.linspace(thin - h, h - thin, 4) for h in half[:2]))
        if held.kind != "box":
            x = y = np.zeros(1)
        starts = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, min(thin, half[2]))])
        ends = starts + np.array([0.0, 0.0, max(held.size_m[2] - 2.0 * thin, 1e-4)])
        radii = np.full(x.size, thin)
    return Capsules(starts, ends, radii).placed(place.position_m, place.rotation)
