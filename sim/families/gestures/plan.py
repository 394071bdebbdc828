"""The plan of a script: its steps rehearsed in their order, and what the cameras see of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from pjpdaf.camera import distort_points, project
from sim.contact.contact import Unposable
from sim.families.gestures.free import DEFAULT_TARGETS
from sim.families.gestures.gesture import BOTH, HAND, Gesture, Step
from sim.families.gestures.head import HeadPlanner, Together
from sim.families.gestures.registry import GESTURES
from sim.families.gestures.rehearsal import Rehearsal
from sim.motion.motion import Hold, MotionPlan, object_at_rest
from sim.motion.stage import STILL_S, Family, Stage, Values
from sim.pose import SIDES
from sim.scene.rig import stereo_rig
from sim.scene.world import CAMERAS
from sim.specs import ObjectSpec

_SEEN_HZ = 6.0  # rate at which planned palms are looked for in the pictures


def script_family(
    parameters: tuple[str, ...],
    steps: Callable[[Values], Sequence[Step]],
    objects: Callable[[Values], tuple[ObjectSpec, ...]],
) -> Family:
    """The family of motion of a script: steps and objects, given values in SI units."""
    return Family(parameters, lambda stage: plan_script(stage, steps(stage.values)), objects)


def plan_script(stage: Stage, steps: Sequence[Step]) -> MotionPlan:
    """The motion plan of a script. The steps' names are taken as checked.

    Raises Unposable, with the step's place, where steps overlap in time, a duration is too short,
    or a palm leaves the pictures in a step that is not meant to.
    """
    rehearsal = Rehearsal(
        stage,
        stage.planners(STILL_S),
        HeadPlanner(STILL_S),
        {o.name: object_at_rest(stage.scene.room, o.name) for o in stage.scene.room.objects},
    )
    for step in steps:
        _rehearse(rehearsal, step)
    for side, load in rehearsal.loads.items():  # never put down: held to the end and beyond
        end_s = max(stage.duration_s, rehearsal.hands[side].clock_s) + 1.0
        rehearsal.holds.append(Hold(load.spec.name, side, load.from_s, end_s))
    path = rehearsal.head.path()
    carriage = Together((path, *rehearsal.leans)) if rehearsal.leans else path
    plan = stage.plan(
        rehearsal.hands, tuple(rehearsal.holds), tuple(rehearsal.cues), carriage=carriage
    )
    plan = replace(plan, steps=tuple(rehearsal.planned))
    _refuse_unseen(stage, plan, steps)
    return plan


def _rehearse(rehearsal: Rehearsal, step: Step) -> None:
    """Add a step: by each of its hands, by both together, or by the head."""
    gesture = GESTURES[step.do]
    targets = {field: t for (do, field), t in DEFAULT_TARGETS.items() if do == step.do}
    step = replace(step, targets={**targets, **step.targets})
    if not step.who:
        head = rehearsal.head
        head.clock_s = rehearsal.begin(step, [head.clock_s])
        begun_s = head.clock_s
        gesture.play(rehearsal, step, 0)
        rehearsal.note(step, None, begun_s, head.clock_s)
        return
    hands = [rehearsal.hands[side] for side in step.who]
    begun_s = rehearsal.begin(step, [hand.clock_s for hand in hands])
    for hand in hands:
        hand.until(begun_s)
    if _together(gesture):
        gesture.play(rehearsal, step, 0)
    else:
        for side in step.who:
            gesture.play(rehearsal, step, side)
    for side in step.who:
        rehearsal.note(step, side, begun_s, rehearsal.hands[side].clock_s)


def _together(gesture: Gesture) -> bool:
    """Whether both hands make it as one."""
    return BOTH in gesture.who and HAND not in gesture.who


def _refuse_unseen(stage: Stage, plan: MotionPlan, steps: Sequence[Step]) -> None:
    """Raise Unposable where a planned palm is outside a picture, unless its step goes out."""
    cameras = stereo_rig(stage.scene.rig).cameras
    out = {step.where for step in steps if GESTURES[step.do].leaves_view}
    for planned in plan.steps:
        if planned.side is None or planned.where in out:
            continue
        last_s = min(planned.to_s, stage.duration_s)
        if last_s <= planned.from_s:
            continue
        count = int(_SEEN_HZ * (last_s - planned.from_s)) + 2
        times = np.linspace(planned.from_s, last_s, count)
        hand = plan.hands[planned.side]
        palms = np.array([hand.at(t_s).position_m for t_s in times.tolist()])
        for view, camera in zip(CAMERAS, cameras, strict=True):
            pixels = distort_points(camera, project(camera, palms))
            size = np.array([camera.width_px, camera.height_px])
            seen = ((pixels > -0.5) & (pixels < size - 0.5)).all(axis=1)
            if not seen.all():
                t_s = float(times[seen.argmin()])
                raise Unposable(
                    f"{planned.where}: at {t_s:.2f} s the {SIDES[planned.side]} hand is outside "
                    f"the {view} picture; bring its target nearer, or use leave_view or hide"
                )
