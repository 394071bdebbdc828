"""Draws the values of a scenario for a seed, and makes a performance of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from pjpdaf.errors import BenchError
from scenarios.spec import cameras, person_and_room
from scenarios.spec.in_view import out_of_view, sees_workspace
from scenarios.spec.names import load_scenario
from scenarios.spec.parameters.file import FileText
from scenarios.spec.parameters.numeric import Numeric
from scenarios.spec.parameters.units import UNITS
from scenarios.spec.scenario import MAX_FRAMES, Scenario, in_varied_surroundings
from scenarios.spec.suggestion import suggestion
from scenarios.spec.surroundings import PARAMETERS, RIG, VARIED, surroundings_of
from scenarios.spec.things import off_the_table, second_person, with_clutter
from sim.contact.contact import Unposable
from sim.motion.measure import MotionFault, fault_of
from sim.motion.motion import Performer, performer_of
from sim.motion.opening import with_opening
from sim.motion.stage import Stage, Value, Values
from sim.randomness import generator
from sim.scene.disturbances import together
from sim.scene.extras import NO_EXTRAS, Extras, WithExtras
from sim.script import Performance
from sim.silhouettes.possible import surely_possible
from sim.specs import SceneSpec

MAX_DRAWS = 20  # of a seed, until a person can perform the motion
MAX_RIGS = 60  # of a draw, until the varied rig sees the person: 2 in 5 do
JUDGED_HZ, MOST_JUDGED = 6.0, 400  # rate and number of the poses by which a draw is judged

_MOMENT_S = 0.2  # what is found at a moment may be the fault of the step before or after

SETTINGS = ("frames", "fps", "background_frames")  # fields that `--set` may change as well


def concrete(
    scenario: Scenario, seed: int, overrides: Mapping[str, Value] | None = None, redraw: int = 0
) -> dict[str, Value]:
    """Draw the values of all parameters for a seed, each in its parameter's unit.

    Each draw is addressed by (seed, stream, parameter): changing one parameter moves no other draw,
    and twins, which share a stream, share the values of the same name. redraw: the number of draws
    that were thrown away before. overrides: parameter -> number, text such as "0.3 m/s", or a
    file's name. Raises BenchError with unit and range for an override that does not fit.
    """
    overrides = dict(overrides or {})
    known = (*scenario.parameters, *SETTINGS)
    for name in overrides:
        if name not in known:
            hint = suggestion(name, known, f"pjpdaf-bench scenarios show {scenario.name}")
            raise BenchError(f"{scenario.name} has no parameter {name[:60]!r}{hint}")
    values: dict[str, Value] = {}
    for name, parameter in scenario.parameters.items():
        if name in overrides:
            values[name] = parameter.check(name, overrides[name])
        else:
            values[name] = parameter.quantile(_share(_stream(scenario, redraw, name), seed))
    if scenario.surroundings == VARIED:
        return _with_person_in_view(scenario, seed, overrides, redraw, values)
    return values


def _with_person_in_view(
    scenario: Scenario,
    seed: int,
    overrides: Mapping[str, Value],
    redraw: int,
    values: Mapping[str, Value],
) -> dict[str, Value]:
    """The values with the first of MAX_RIGS draws of the rig that sees head and hands.

    So the rig has the distribution of its parameters, cut to what films the person. The first draw
    stays where none does, as with a rig that is set by hand.
    """
    for number in range(MAX_RIGS):
        drawn = dict(values)
        if number:
            for name in RIG:
                if name not in overrides:
                    stream = _stream(scenario, redraw, f"{name}/{number}")
                    drawn[name] = scenario.parameters[name].quantile(_share(stream, seed))
        if sees_workspace(in_si(scenario, drawn)):
            return drawn
    return dict(values)


@lru_cache(maxsize=1024)
def _share(stream: str, seed: int) -> float:
    """The first number of a stream: an episode's values are asked for several times."""
    return float(generator(seed, stream).random())


def _generator(scenario: Scenario, seed: int, redraw: int, name: str) -> np.random.Generator:
    return generator(seed, _stream(scenario, redraw, name))


def _stream(scenario: Scenario, redraw: int, name: str) -> str:
    again = f"redraw{redraw}/" if redraw else ""
    if scenario.surroundings == VARIED and name.partition("/")[0] in PARAMETERS:
        return f"{scenario.rooms or scenario.name}/surroundings/{again}{name}"
    return f"{scenario.stream}/{again}{name}"


def setting_of(scenario: Scenario, overrides: Mapping[str, Value], name: str) -> float:
    """The value of a field of `SETTINGS`: its override, else the scenario's. Raises BenchError."""
    if name not in overrides:
        return float(getattr(scenario, name))
    least, most = {"fps": (1, 30), "frames": (1, MAX_FRAMES), "background_frames": (0, 500)}[name]
    try:
        number = float(overrides[name])
        if not math.isfinite(number):
            raise ValueError
    except ValueError:
        raise BenchError(
            f"{name}: must be a number from {least} to {most}, got {str(overrides[name])[:60]!r}"
        ) from None
    if name != "fps" and not number.is_integer():
        raise BenchError(f"{name}: must be a whole number from {least} to {most}, got {number:g}")
    if not least <= number <= most:
        raise BenchError(f"{name}: {number:g} is outside its range {least} to {most}")
    return number


def scene_of(scenario: Scenario, values: Values, extras: Extras = NO_EXTRAS) -> SceneSpec:
    """Build the scene of concrete values in SI units."""
    objects = scenario.motion_family.objects(values)
    return SceneSpec(
        anatomy=person_and_room.anatomy_of(values),
        appearance=person_and_room.appearance_of(values),
        room=person_and_room.room_of(values, (*objects, *extras.objects), surroundings_of(values)),
        rig=cameras.rig_of(values),
        sensor=cameras.sensor_of(values),
        clock=cameras.clock_of(values),
        calibration_error=cameras.calibration_error_of(values),
    )


def in_si(scenario: Scenario, values: Mapping[str, Value]) -> dict[str, Value]:
    """Convert every number to the base unit of its kind (m, m/s, s, rad, ...).

    A file becomes its absolute path. Raises BenchError where its content has changed since.
    """
    converted: dict[str, Value] = {}
    for name, value in values.items():
        parameter = scenario.parameters[name]
        if isinstance(parameter, Numeric):
            converted[name] = float(value) * UNITS[parameter.unit][1]
        elif isinstance(value, FileText):
            converted[name] = str(value.unchanged())
        else:
            converted[name] = value
    return converted


def perform(
    scenario: Scenario, seed: int, overrides: Mapping[str, Value] | None = None
) -> Performance:
    """Make the concrete sequence of a seed.

    A draw that a person could not perform (`sim.motion.measure.fault_of`), or whose twin's draw
    could not be performed, is thrown away and drawn again: `Performance.redrawn` counts these.
    Raises BenchError for values that cannot be played, Unposable after MAX_DRAWS.
    """
    if seed < 0:
        raise BenchError(f"seed must be 0 or more, got {seed}")
    overrides = dict(overrides or {})
    fault: str | None = None
    for redraw in range(MAX_DRAWS):
        try:
            return _accepted(scenario, seed, overrides, redraw)
        except Unposable as reason:
            fault = fault or str(reason)
    raise Unposable(
        f"{scenario.name} seed {seed}: none of {MAX_DRAWS} draws can be posed; the first: {fault}"
    )


def _perform_draw(
    scenario: Scenario, seed: int, overrides: Mapping[str, Value], redraw: int
) -> Performance:
    """Make the performance of a draw. Raises Unposable where a person could not perform it."""
    performance = unjudged(scenario, seed, overrides, redraw)
    fault = judged(performance)
    if fault is not None:
        raise Unposable(fault)
    return performance


def unjudged(
    scenario: Scenario,
    seed: int,
    overrides: Mapping[str, Value] | None = None,
    redraw: int = 0,
) -> Performance:
    """Make the performance of a draw, whether or not a person could perform it (`judged`).

    A hundred times as fast as `perform`: for those who play many draws and judge few.
    redraw: as in `concrete`. Raises BenchError for values that cannot be played, and Unposable for
    a plan that has no motion at all.
    """
    overrides = dict(overrides or {})
    values = in_si(scenario, concrete(scenario, seed, overrides, redraw))
    fps = setting_of(scenario, overrides, "fps")
    frames = int(setting_of(scenario, overrides, "frames"))

    def streams(name: str) -> np.random.Generator:
        return _generator(scenario, seed, redraw, f"motion/{name}")

    duration_s = _duration_s(frames, fps)
    extras = together(
        (
            person_and_room.extras_of(values, streams, duration_s),
            second_person(surroundings_of(values), streams("second_person")),
        )
    )
    scene = scene_of(scenario, values, extras)
    stage = Stage(scene=scene, values=values, streams=streams, duration_s=duration_s)
    plan = scenario.motion_family.plan(stage)
    opened = with_opening(stage, plan, str(values["start"]))
    if scene.room.surroundings is not None:
        scene = with_clutter(scene, opened, _judged_times(duration_s))
    performer = Performer(scene, opened)
    return Performance(
        scene=scene,
        script=WithExtras(performer, extras) if extras.tracks else performer,
        frames=frames,
        fps=fps,
        background_frames=int(setting_of(scenario, overrides, "background_frames")),
        seed=seed,
        learnt=extras.learnt,
        redrawn=redraw,
    )


def judged(performance: Performance) -> str | None:
    """The reason why a person could not make a performance of `unjudged`, or None.

    Twins are not looked at (`fault_of_draw`). The poses are judged, not the frames: alike at any
    frame rate.
    """
    performer = performer_of(performance.script)
    duration_s = _duration_s(performance.frames, performance.fps)
    times_s = _judged_times(duration_s)
    if performer.scene.room.surroundings is not None:
        cannot = off_the_table(performer.scene) or out_of_view(performer, times_s)
        if cannot is not None:
            return cannot
    fault = fault_of(performer, times_s, surely_possible(performer, times_s).tolist())
    return None if fault is None else _with_steps(performer, fault)


def _with_steps(performer: Performer, fault: MotionFault) -> str:
    """A fault behind the steps of a script that go on then, or that came last."""
    begun = [step for step in performer.plan.steps if step.from_s <= fault.time_s + _MOMENT_S]
    last = {step.side: step for step in begun}  # of each hand and the head
    going = [step for step in last.values() if step.to_s >= fault.time_s - _MOMENT_S]
    named = going or sorted(last.values(), key=lambda step: step.to_s)[-1:]
    if not named:
        return str(fault)
    others = [step.title for step in named[1:] if step.title != named[0].title]
    also = f" (with {', '.join(others)})" if others else ""
    return f"{named[0].where}{also}: {fault}"


def _judged_times(duration_s: float) -> list[float]:
    moments = min(MOST_JUDGED, math.ceil(JUDGED_HZ * duration_s) + 1)
    times_s: list[float] = np.linspace(0.0, duration_s, moments).tolist()
    return times_s


def fault_of_draw(
    scenario: Scenario,
    seed: int,
    overrides: Mapping[str, Value] | None = None,
    redraw: int = 0,
) -> str | None:
    """The reason why `perform` would reject this draw, by itself or by a twin's, or None."""
    try:
        _accepted(scenario, seed, dict(overrides or {}), redraw)
    except Unposable as reason:
        return str(reason)
    return None


def _accepted(
    scenario: Scenario, seed: int, overrides: Mapping[str, Value], redraw: int
) -> Performance:
    """The performance of a draw. Raises Unposable where it, or a twin's, cannot be performed."""
    performance = _perform_draw(scenario, seed, overrides, redraw)
    for name in scenario.twins:
        twin = load_scenario(name)
        if scenario.surroundings == VARIED:
            twin = in_varied_surroundings(twin, scenario.rooms or scenario.name)
        shared = {k: v for k, v in overrides.items() if k in (*twin.parameters, *SETTINGS)}
        _perform_draw(twin, seed, shared, redraw)
    return performance


def _duration_s(frames: int, fps: float) -> float:
    return max(frames / fps, 1.0)
