"""Kinds of motion with a fault each, as a plug-in's factories."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np

from sim.families.plugged import OwnMotion
from sim.motion.motion import Cue
from sim.motion.strokes import HandPath

SPEED = {
    "unit": "m/s",
    "range": [0.2, 1.0],
    "nominal": {"kind": "uniform"},
    "meaning": "peak speed",
}


def _plan(stage, change=lambda hand: hand, start_s=1.1, cues=()):
    hands = stage.planners(start_s)
    rest = stage.rest(0)
    hands[0].move(rest.moved([0.03, 0.0, 0.1]), stage.number("speed"))
    hands[0].move(rest, stage.number("speed"))
    return stage.plan((change(hands[0].path()), hands[1]), cues=cues)


class _Changed:
    def __init__(self, path, change):
        self.path, self.change = path, change

    def at(self, t_s):
        return self.change(self.path.at(t_s), t_s)


def _with(change):
    return lambda: OwnMotion({"speed": SPEED}, lambda s: _plan(s, lambda p: _Changed(p, change)))


def good():
    return OwnMotion({"speed": SPEED}, _plan, frames=9)


def no_motion():
    return 3


def raises():
    raise KeyError("nothing")


def ends():
    sys.exit(3)


def without_unit():
    return OwnMotion({"speed": {"range": [0, 1], "nominal": {"kind": "uniform"}}}, _plan)


def without_meaning():
    return OwnMotion({"speed": SPEED | {"meaning": ""}}, _plan)


def reversed_range():
    return OwnMotion({"speed": SPEED | {"range": [1.0, 0.2]}}, _plan)


def standard_name():
    return OwnMotion({"stature": SPEED}, _plan)


def plan_raises():
    def plan(stage):
        raise ZeroDivisionError("speed")

    return OwnMotion({"speed": SPEED}, plan)


def at_an_end():
    def plan(stage):
        if stage.number("speed") == 1.0:
            raise ValueError("too fast")
        return _plan(stage)

    return OwnMotion({"speed": SPEED}, plan)


def no_plan():
    return OwnMotion({"speed": SPEED}, lambda stage: None)


def moves_at_once():
    return OwnMotion({"speed": SPEED}, lambda stage: _plan(stage, start_s=0.2))


def random():
    def plan(stage):
        far = 0.05 * np.random.default_rng().random()
        return _plan(
            stage,
            lambda p: HandPath(
                p.first, (*p.moves[:1], replace(p.moves[1], to=p.first.moved([far, 0, 0])))
            ),
        )

    return OwnMotion({"speed": SPEED}, plan)


def backwards():
    return OwnMotion({"speed": SPEED}, lambda s: _plan(s, cues=(Cue("x", 3.0, 2.0),)))


jumps = _with(lambda state, t: state.moved([0.2 * (t > 2.0), 0, 0]))
not_finite = _with(lambda state, t: state.moved([np.nan if t > 2.0 else 0.0, 0, 0]))
curled_twice = _with(lambda state, t: replace(state, curls=state.curls + 1.5 * (t > 2.0)))
too_far = _with(lambda state, t: state.moved([0.8 * min(max(t - 1.2, 0.0), 1.0) ** 3, 0, 0]))
