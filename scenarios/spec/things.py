"""Clutter and a second person about a planned motion, in varied surroundings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from sim.motion.motion import MotionPlan
from sim.motion.posture import posture
from sim.person.kinematics import shoulders
from sim.scene.disturbances import Swing
from sim.scene.extras import NO_EXTRAS, Extras
from sim.scene.rig import stereo_rig
from sim.specs import SceneSpec, Surroundings
from sim.surroundings.clutter import BYSTANDER, bystander_of, clutter_of, outside_corner
from sim.vectors import about_z

_SWAY_M, _SWAY_S = (0.03, 0.12), (2.5, 6.0)


def with_clutter(scene: SceneSpec, plan: MotionPlan, times_s: Sequence[float]) -> SceneSpec:
    """The scene with clutter on its table that keeps clear of a plan, as it is at these times."""
    anatomy = scene.anatomy
    palms, joints, heads = [], [], []
    for t_s in times_s:
        states = (plan.hands[0].at(t_s), plan.hands[1].at(t_s))
        torso, head = posture(anatomy, states, np.zeros(3), plan.carriage.at(t_s))
        palms.append([state.position_m for state in states])
        joints.append(shoulders(anatomy, torso.position_m, torso.rotation))
        heads.append(head.position_m)
    cameras = np.array([camera.centre_w for camera in stereo_rig(scene.rig).cameras])
    clutter = clutter_of(scene.room, np.array(palms), np.array(joints), np.array(heads), cameras)
    return replace(scene, room=replace(scene.room, objects=(*scene.room.objects, *clutter)))


def second_person(surroundings: Surroundings | None, rng: np.random.Generator) -> Extras:
    """The second person of varied surroundings, who is there when the background is learnt."""
    spec = None if surroundings is None else bystander_of(surroundings)
    if surroundings is None or spec is None:
        return NO_EXTRAS
    if surroundings.bystander == "still":
        return Extras((spec,))
    x, y = spec.position_xy_m
    reach = float(rng.uniform(*_SWAY_M))
    sway = Swing(
        middle_m=np.array([x, y, 0.0]),
        reach_m=np.array([0.0, reach, 0.0]),
        period_s=float(rng.uniform(*_SWAY_S)),
        rotation=about_z(spec.yaw_rad),
        bob_m=np.array([0.3 * reach, 0.0, 0.0]),
    )
    return Extras((spec,), MappingProxyType({BYSTANDER: sway}))


def off_the_table(scene: SceneSpec) -> str | None:
    """The reason why an object of the motion would not stand on the drawn table, or None."""
    for spec in scene.room.objects:
        if spec.base_m is None and outside_corner(scene.room, *spec.position_xy_m) > 0.0:
            return f"the object {spec.name} is not on the table: use another seed or a larger table"
    return None
