"""Cyclic motion of both hands: claps, and forearms that roll round each other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.families.touching import brought, hand_bars
from sim.motion.motion import Cue, HandMotion, MotionPlan
from sim.motion.planner import RISING_M, curled, meet, raised
from sim.motion.stage import Family, Stage
from sim.motion.strokes import HandPath, HandState, between, quaternion_of
from sim.person.kinematics import OUTWARD
from sim.vectors import about_z


@dataclass(frozen=True)
class Tempo:
    """A count of whole cycles at a frequency, begun and ended over a period each.

    The frequency rises and falls along a minimum-jerk profile, so that whatever follows the phase
    begins and ends with neither speed nor acceleration.
    """

    start_s: float
    frequency_hz: float
    cycles: int

    @property
    def end_s(self) -> float:
        """When the last cycle is over [s]."""
        return self.start_s + (self.cycles + 1) / self.frequency_hz

    def phase(self, t_s: float) -> float:
        """Cycles done at t_s, 0 to `cycles`."""
        done = (t_s - self.start_s) * self.frequency_hz
        left = self.cycles + 1 - done
        if done <= 0.0:
            return 0.0
        if left <= 0.0:
            return float(self.cycles)
        if done < 1.0:
            return _run_up(done)
        return self.cycles - _run_up(left) if left < 1.0 else done - 0.5


def _run_up(s: float) -> float:
    """Integral of the minimum-jerk profile from 0 to s, 1/2 at s = 1."""
    return s * s * s * s * (2.5 + s * (s - 3.0))


@dataclass(frozen=True, eq=False)
class Clapping:
    """A hand that goes from open to closed and back once a cycle, within a path that waits."""

    path: HandPath
    tempo: Tempo
    open: HandState
    closed: HandState

    def at(self, t_s: float) -> HandState:
        """The state at t_s [s], any t."""
        if not self.tempo.start_s < t_s < self.tempo.end_s:
            return self.path.at(t_s)
        share = 0.5 - 0.5 * math.cos(2.0 * math.pi * self.tempo.phase(t_s))
        return between(self.open, self.closed, share)


@dataclass(frozen=True, eq=False)
class Rolling:
    """A hand on an upright circle of radius_m (3,), from its centre to where the path waits.

    towards: 1 rolls its top towards the cameras, -1 towards the person.
    """

    path: HandPath
    tempo: Tempo
    radius_m: Floats
    towards: float

    def at(self, t_s: float) -> HandState:
        """The state at t_s [s], any t."""
        state = self.path.at(t_s)
        if not self.tempo.start_s < t_s < self.tempo.end_s:
            return state
        angle = 2.0 * math.pi * self.towards * self.tempo.phase(t_s)
        x, _, z = self.radius_m.tolist()
        c, s = math.cos(angle), math.sin(angle)
        turned = np.array([c * x + s * z, 0.0, c * z - s * x])
        return replace(state, position_m=state.position_m - self.radius_m + turned)


def _clap(stage: Stage) -> MotionPlan:
    """Palms meet at a steady tempo a number of times, wider the slower, and rest."""
    f, lift = stage.number("frequency"), stage.number("finger_lift")
    turn = 0.5 * stage.number("palm_turn")
    hands, centre, anatomy = stage.planners(stage.start_s), stage.centre_m, stage.scene.anatomy
    # Speed pi f D / 2 of each hand at its fastest: a wide clap has to be slow.
    wide = min(stage.number("opening"), 2.0 * stage.number("top_speed") / (math.pi * f))
    flat = []
    for side in (0, 1):
        state = raised(side, centre, 0.0, -(lift - OUTWARD[side] * turn), 0.5 * math.pi, curl=0.08)
        flat.append(replace(state, air=0.0))
    to_right = np.array([0.0, OUTWARD[0], 0.0])
    met = brought(anatomy, 1, flat[1], to_right, hand_bars(anatomy, 0, flat[0]))
    half = 0.5 * (met.position_m - flat[0].position_m)
    closed = (flat[0].moved(-half), met.moved(-half))
    opened = []
    for side in (0, 1):
        turned = about_z(-OUTWARD[side] * 0.12) @ closed[side].rotation
        aside = np.array([0.0, 0.5 * wide * OUTWARD[side], 0.0])
        opened.append(replace(closed[side].moved(aside), quaternion=quaternion_of(turned)))
        hands[side].move(opened[side], stage.number("raise_speed"), RISING_M)
    begun = meet(hands, 0.3)
    tempo = Tempo(begun, f, round(stage.number("claps")))
    for side in (0, 1):
        hands[side].until(tempo.end_s + 0.3)
        hands[side].move(stage.rest(side), stage.number("raise_speed"), RISING_M)
    paths: tuple[HandMotion, HandMotion] = (
        Clapping(hands[0].path(), tempo, opened[0], closed[0]),
        Clapping(hands[1].path(), tempo, opened[1], closed[1]),
    )
    # The k-th meeting is half a cycle into it; the tenth of a second about it counts.
    meetings = [begun + (k + 1) / f for k in range(tempo.cycles)]
    claps = tuple(Cue("clap", m - 0.05, m + 0.05) for m in meetings)
    return stage.plan(paths, cues=(Cue("clapping", begun, tempo.end_s), *claps))


def _roll_forearms(stage: Stage) -> MotionPlan:
    """The forearms roll round each other before the chest, fists closed."""
    radius = stage.number("radius")
    hands, centre = stage.planners(stage.start_s), stage.centre_m
    towards = {"towards_cameras": 1.0, "towards_person": -1.0}[str(stage.values["direction"])]
    upper = stage.side("upper")
    spokes = []
    for side in (0, 1):
        spoke = np.array([0.0, 0.0, radius if side == upper else -radius])
        beside = np.array([0.0, OUTWARD[side] * stage.number("beside"), 0.0])
        state = raised(
            side, centre + spoke + beside, 1.15, 0.0, stage.number("thumb_up"), swivel_rad=0.55
        )
        fist = replace(state, curls=curled(0.7, thumb=0.5), air=1.0)
        hands[side].move(fist, stage.number("raise_speed"), RISING_M)
        spokes.append(spoke)
    begun = meet(hands, 0.3)
    tempo = Tempo(begun, stage.number("frequency"), round(stage.number("turns")))
    for side in (0, 1):
        hands[side].until(tempo.end_s + 0.3)
        hands[side].move(stage.rest(side), stage.number("raise_speed"), RISING_M)
    paths: tuple[HandMotion, HandMotion] = (
        Rolling(hands[0].path(), tempo, spokes[0], towards),
        Rolling(hands[1].path(), tempo, spokes[1], towards),
    )
    return stage.plan(paths, cues=(Cue("roll", begun, tempo.end_s),))


FAMILIES: Mapping[str, Family] = {
    "clap": Family(
        (
            "frequency",
            "claps",
            "opening",
            "top_speed",
            "finger_lift",
            "palm_turn",
            "raise_speed",
            "height",
            "centre_x",
            "wait",
        ),
        _clap,
    ),
    "roll_forearms": Family(
        (
            "frequency",
            "turns",
            "radius",
            "beside",
            "direction",
            "upper",
            "thumb_up",
            "raise_speed",
            "height",
            "centre_x",
            "wait",
        ),
        _roll_forearms,
    ),
}
