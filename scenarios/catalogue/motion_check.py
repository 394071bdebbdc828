"""Conformance of a user's kind of motion: every fault is one line, the call, then the fault."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np

from pjpdaf.plugins.probe import CheckEnds, Probe
from scenarios.play.recipe import sized
from scenarios.spec.draw import perform, unjudged
from scenarios.spec.motion.plugged import trust
from scenarios.spec.own_motion import scenario_of_motion
from scenarios.spec.parameters.choice import Choice
from scenarios.spec.parameters.numeric import Numeric
from scenarios.spec.scenario import Scenario
from sim.contact.contact import Unposable
from sim.families.plugged import own_motion
from sim.motion.measure import FASTEST_MPS
from sim.motion.motion import MotionPlan, performer_of
from sim.motion.opening import OPENING_S, OPENINGS
from sim.motion.stage import STILL_S, Value
from sim.motion.strokes import HandState
from sim.pose import SIDES
from sim.script import Performance
from sim.sequence import Simulation

SEEDS = range(3)
_STEP_S = 0.005  # paths are looked at so finely
_STILL_M, _APART_M = 1e-3, 0.20
_PICTURE_PX = (160, 120)


def check_motion(name: str, limit_s: float) -> tuple[str, ...]:
    """Check a kind of motion by name; returns all faults, none where it conforms.

    name: as the user gives it, who trusts it so; limit_s: time that a call may take [s]. Raises
    NoSuchPlugIn for a name that is not there.
    """
    trust(name)
    return Probe(limit_s).run(partial(_check, name))


def _check(name: str, probe: Probe) -> None:
    """Check parameters, paths, start, truth. Raises CheckEnds."""
    scenario = probe.call("factory()", scenario_of_motion, name)
    plans = [_planned(probe, scenario, seed) for seed in SEEDS]
    for seed, performance in zip(SEEDS, plans, strict=True):
        _check_paths(probe, performance, f"seed {seed}")
        _check_start(probe, performance, f"seed {seed}")
        _check_cues(probe, _plan(performance), f"seed {seed}")
    own_motion.cache_clear()  # a second factory, as in another process
    again = probe.call("factory()", scenario_of_motion, name)
    rate = 3.0 * again.fps  # the same time at another frame rate
    changes: tuple[Mapping[str, Value], ...] = ({}, {"fps": rate, "frames": 3 * again.frames})
    for change in changes:
        other = probe.call(f"plan({_text(change) or 'again'})", unjudged, again, SEEDS[0], change)
        if not _same(_plan(plans[0]), _plan(other), _end_s(plans[0])):
            what = "at another frame rate" if change else "when planned again"
            probe.add("plan", f"differs {what} with the same seed; draw from stage.streams only")
    _check_ends(probe, again)
    for opening in OPENINGS[1:]:
        opened = probe.call(f"plan(start={opening})", unjudged, again, 0, {"start": opening})
        _check_paths(probe, opened, f"start={opening}")
        first, last = (_positions(_plan(opened), [t])[:, 0] for t in (0.0, 0.9 * OPENING_S))
        if np.abs(first - last).max() > _STILL_M:
            probe.add(f"start={opening}", f"hands move in the first {OPENING_S:g} s")
    _check_posed(probe, again)


def _planned(probe: Probe, scenario: Scenario, seed: int) -> Performance:
    performance: Performance = probe.call(f"plan(seed {seed})", unjudged, scenario, seed)
    return performance


def _plan(performance: Performance) -> MotionPlan:
    return performer_of(performance.script).plan


def _end_s(performance: Performance) -> float:
    return performance.frames / performance.fps


def _states(plan: MotionPlan, side: int, times_s: list[float]) -> list[HandState]:
    return [plan.hands[side].at(t_s) for t_s in times_s]


def _positions(plan: MotionPlan, times_s: list[float]) -> np.ndarray:
    """Planned palms (2, n, 3) [m]."""
    return np.array([[s.position_m for s in _states(plan, side, times_s)] for side in (0, 1)])


def _check_paths(probe: Probe, performance: Performance, label: str) -> None:
    """Finite states, curls from 0 to 1, turns that are turns, no jumps. Raises CheckEnds."""
    plan, end_s = _plan(performance), _end_s(performance)
    times = np.arange(0.0, end_s, _STEP_S).tolist()
    for side in (0, 1):
        hand = f"{label}: the {SIDES[side]} hand"
        states = probe.call(f"{hand}: at", _states, plan, side, times)
        if not all(isinstance(state, HandState) for state in states):
            raise CheckEnds(f"{hand}: at(t_s) must return a HandState")
        numbers = np.array(
            [[*s.position_m, *s.quaternion, *s.curls, s.air, s.with_head] for s in states]
        )
        wrong = ~np.isfinite(numbers).all(axis=1)
        if wrong.any():
            raise CheckEnds(f"{hand}: has NaN or infinite values at {times[wrong.argmax()]:.2f} s")
        curls = numbers[:, 7:12]
        if curls.min() < -1e-9 or curls.max() > 1 + 1e-9:
            probe.add(
                hand, f"curls must be from 0 to 1, are {curls.min():.2g} to {curls.max():.2g}"
            )
        if np.linalg.norm(numbers[:, 3:7], axis=1).min() < 0.1:
            probe.add(hand, "quaternion is no turn: its length is near 0")
        steps = np.linalg.norm(np.diff(numbers[:, :3], axis=0), axis=1)
        worst = int(steps.argmax())
        if steps[worst] > FASTEST_MPS * _STEP_S:
            probe.add(
                hand, f"jumps by {1000 * steps[worst]:.0f} mm at {times[worst]:.2f} s; join moves"
            )
        later = probe.call(f"{hand}: at", _states, plan, side, times[::-97])
        if not np.array_equal([s.position_m for s in later], numbers[::-97, :3]):
            probe.add(hand, "at(t_s) depends on what was asked before; it must be pure")


def _check_start(probe: Probe, performance: Performance, label: str) -> None:
    """Both hands still and apart for the first frames, each on its own side."""
    first = _positions(_plan(performance), np.linspace(0.0, STILL_S - 0.05, 8).tolist())
    if np.ptp(first, axis=1).max() > _STILL_M:
        probe.add(label, f"hands must be still for the first {STILL_S:g} s (stage.start_s)")
    if np.linalg.norm(first[0] - first[1], axis=1).min() < _APART_M:
        probe.add(label, f"hands must begin {_APART_M:g} m apart or more (stage.rest)")
    if first[0, :, 1].max() > 0 or first[1, :, 1].min() < 0:
        probe.add(label, "the right hand must begin at y < 0, the left at y > 0")


def _check_cues(probe: Probe, plan: MotionPlan, label: str) -> None:
    """Names and times of events, of which the truth's tables are made."""
    for cue in plan.cues:
        if not isinstance(cue.name, str) or not cue.name or not cue.name.isprintable():
            probe.add(label, f"a cue has no plain name: {cue.name!r}"[:80])
        elif not (math.isfinite(cue.from_s) and cue.from_s <= cue.to_s):
            probe.add(
                label, f"cue {cue.name}: must end after it begins, {cue.from_s} to {cue.to_s}"
            )


def _check_ends(probe: Probe, scenario: Scenario) -> None:
    """A plan at both ends of every range, and of every choice; it may be unposable there."""
    for change in _extremes(scenario):
        try:
            probe.call(f"plan({_text(change)})", unjudged, scenario, 0, change)
        except CheckEnds as end:
            probe.faults.append(str(end))


def _extremes(scenario: Scenario) -> Iterator[Mapping[str, Value]]:
    for name in scenario.motion_family.parameters:
        parameter = scenario.parameters[name]
        if isinstance(parameter, Numeric):
            yield from ({name: end} for end in parameter.range)
        elif isinstance(parameter, Choice):
            yield from ({name: option} for option in parameter.choices)


def _check_posed(probe: Probe, scenario: Scenario) -> None:
    """A person can make it, and the truth of rendered frames is whole."""
    performance = probe.call("pose", _performed, scenario)
    if isinstance(performance, str):
        raise CheckEnds(f"pose: {performance}")
    small = sized(performance, _PICTURE_PX)
    faults = probe.call("truth", _truth_faults, small)
    for fault in faults:
        probe.add("truth", fault)


def _performed(scenario: Scenario) -> Performance | str:
    """The performance of the first seed that can be posed, or why none can."""
    fault = ""
    for seed in SEEDS:
        try:
            return perform(scenario, seed)
        except Unposable as reason:
            fault = fault or str(reason)
    return fault


def _truth_faults(performance: Performance) -> list[str]:
    faults = []
    with Simulation(performance) as simulation:
        for index in (0, performance.frames // 2):
            truth = simulation.render(index).truth
            if not np.isfinite([truth.centres_m, truth.velocities_mps]).all():
                faults.append(f"frame {index}: centres or velocities are not finite")
            if not all(isinstance(event, str) for event in truth.events):
                faults.append(f"frame {index}: events must be names")
    return faults


def _same(a: MotionPlan, b: MotionPlan, end_s: float) -> bool:
    times = np.linspace(0.0, end_s, 200).tolist()
    return np.array_equal(_positions(a, times), _positions(b, times)) and a.cues == b.cues


def _text(change: Mapping[str, Value]) -> str:
    return ", ".join(f"{name}={value}" for name, value in change.items())
