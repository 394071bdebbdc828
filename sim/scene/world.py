"""A compiled scene: model, data, cameras, and which geom shows which target."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import StereoRig
from pjpdaf.targets import TARGETS
from sim.gl import load_mujoco
from sim.lens import SCALE, Lens, lens_of
from sim.person.body import add_person
from sim.person.elbow import hinged
from sim.person.geoms import CLOTHES, HAND_TARGETS, LEGS, SKIN, TARGET_GROUPS
from sim.person.hand import fingers, joint_angles
from sim.pose import SIDES, Pose, Transform
from sim.scene.rig import mujoco_camera, stereo_rig
from sim.scene.room import add_room
from sim.specs import SceneSpec
from sim.surfaces.assets import Assets

CAMERAS = ("left", "right")
EXTENT_M, ZNEAR_M, ZFAR_M = 1.0, 0.05, 12.0
SUPERSAMPLE = SCALE
SHADOW_MAP = 1024
SHADOW_HALF_WIDTH_M = 1.15  # of the square, seen from the light, in which shadows fall


@dataclass(frozen=True, eq=False)
class World:
    """A compiled scene that can be posed.

    model, data: MuJoCo's. rig: the cameras named CAMERAS, lenses: theirs, None where ideal.
    targets (ngeom,) int8: target of a geom, -1 for none. person_groups: geom groups of the person;
    amodal_groups: the group of each target.
    """

    model: Any
    data: Any
    rig: StereoRig
    lenses: tuple[Lens | None, ...]
    targets: NDArray[np.int8]
    person_groups: tuple[int, ...]
    amodal_groups: tuple[int, ...]
    joints: Mapping[str, int]
    bodies: Mapping[str, int]
    scene: SceneSpec | None = None

    def place(self, pose: Pose) -> None:
        """Pose the person and the objects; objects that the pose does not name stay where they are.

        Raises KeyError for an object that the scene does not have.
        """
        assert self.scene is not None, "only a scene with a person has a pose"
        places: dict[str, Transform] = {"torso": pose.torso, "head": pose.head}
        for side, upper, fore, hand in zip(
            SIDES, pose.upper_arms, pose.forearms, pose.hands, strict=True
        ):
            above, below = hinged(upper.rotation, fore.rotation)
            places[f"upper_arm:{side}"] = Transform(upper.position_m, above)
            places[f"forearm:{side}"] = Transform(fore.position_m, below)
            places[f"hand:{side}"] = hand
        places |= {f"object:{name}": at for name, at in pose.objects.items()}
        mujoco = load_mujoco()
        for name, at in places.items():
            if name not in self.bodies:
                known = sorted(n.partition(":")[2] for n in self.bodies if n.startswith("object:"))
                raise KeyError(f"the pose moves {name!r}, the scene has the objects {known}")
            mocap = self.bodies[name]
            self.data.mocap_pos[mocap] = at.position_m
            mujoco.mju_mat2Quat(self.data.mocap_quat[mocap], np.ravel(at.rotation))
        chain = fingers(self.scene.anatomy)
        for side, curls in zip(SIDES, pose.curls, strict=True):
            for finger, curl in zip(chain, curls, strict=True):
                for i, angle in enumerate(joint_angles(finger, float(curl))):
                    self.data.qpos[self.joints[f"{finger.name}{i}:{side}"]] = angle
        self.settle()

    @contextmanager
    def borrowed(self) -> Iterator[None]:
        """Let a block pose the world; afterwards all is back where it was."""
        before = self.joints_and_places()
        try:
            yield
        finally:
            self.restore(before)

    def joints_and_places(self) -> tuple[Floats, ...]:
        """All that `place` sets, copied."""
        return tuple(part.copy() for part in self._parts())

    def restore(self, before: tuple[Floats, ...]) -> None:
        """Set what `joints_and_places` gave."""
        for part, values in zip(self._parts(), before, strict=True):
            part[:] = values
        self.settle()

    def _parts(self) -> tuple[Floats, ...]:
        return self.data.mocap_pos, self.data.mocap_quat, self.data.qpos

    def settle(self) -> None:
        """Bring geoms, cameras and lights to the current pose; no physics."""
        mujoco = load_mujoco()
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)


def build(scene: SceneSpec) -> World:
    """Compile a scene: room, person, cameras.

    Raises ValueError for an unknown kind of object, InfrastructureError without a GL back end.
    """
    mujoco = load_mujoco()
    spec = mujoco.MjSpec()
    assets = Assets(spec, scene.room.texture_seed)
    add_room(assets, scene.room)
    add_person(assets, scene.anatomy, scene.appearance)
    return compiled(spec, stereo_rig(scene.rig), scene)


def compiled(spec: Any, rig: StereoRig, scene: SceneSpec | None = None) -> World:
    """Compile any spec with the rig's cameras and our rendering quality (the tests' way in)."""
    mujoco = load_mujoco()
    lenses = tuple(lens_of(camera) for camera in rig.cameras)
    pinholes = [
        lens.ideal if lens else camera for lens, camera in zip(lenses, rig.cameras, strict=True)
    ]
    for name, pinhole in zip(CAMERAS, pinholes, strict=True):
        spec.worldbody.add_camera(name=name, **mujoco_camera(pinhole))
    visual = spec.visual
    visual.global_.offwidth = SUPERSAMPLE * max(c.width_px for c in pinholes)
    visual.global_.offheight = SUPERSAMPLE * max(c.height_px for c in pinholes)
    visual.quality.offsamples = 0  # we supersample ourselves: textures and shadow edges as well
    visual.quality.shadowsize = SHADOW_MAP
    if scene is not None:  # our bodies are meshes of their own; primitives are small
        visual.quality.numslices, visual.quality.numstacks = 16, 8
    spec.stat.extent = EXTENT_M  # znear, zfar and shadowclip are multiples of it
    visual.map.znear = ZNEAR_M / EXTENT_M
    visual.map.zfar = ZFAR_M / EXTENT_M
    visual.map.shadowclip = SHADOW_HALF_WIDTH_M / EXTENT_M
    model = spec.compile()
    data = mujoco.MjData(model)
    targets = np.full(model.ngeom, -1, dtype=np.int8)
    groups = {group: target for target, group in TARGET_GROUPS.items()}
    for geom in range(model.ngeom):
        if model.geom(geom).name.startswith(SKIN):
            targets[geom] = groups[int(model.geom_group[geom])]
    assert scene is None or set(targets[targets >= 0]) == {0, *HAND_TARGETS}
    bodies = {
        model.body(b).name: int(model.body_mocapid[b])
        for b in range(model.nbody)
        if model.body_mocapid[b] >= 0
    }
    joints = {model.joint(j).name: int(model.jnt_qposadr[j]) for j in range(model.njnt)}
    world = World(
        model=model,
        data=data,
        rig=rig,
        lenses=lenses,
        targets=targets,
        person_groups=(CLOTHES, LEGS, *TARGET_GROUPS.values()),
        amodal_groups=tuple(TARGET_GROUPS[t] for t in range(len(TARGETS))),
        joints=joints,
        bodies=bodies,
        scene=scene,
    )
    world.settle()
    return world
