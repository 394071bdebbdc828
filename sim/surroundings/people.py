"""A second person: someone who stands in the background and is no target."""

from __future__ import annotations

from typing import Any

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.person.face import face_texture
from sim.person.hair import hair_surface, hair_texture
from sim.person.hand import fingers, palm_surface, placed_segments
from sim.person.head import head_surface
from sim.person.torso import torso_surface
from sim.specs import Appearance, ObjectSpec
from sim.surfaces.assets import Assets
from sim.surfaces.shapes import limb
from sim.surfaces.textures import PATTERNS
from sim.surroundings.on_walls import colour_of
from sim.vectors import about_z, bone_frame


def add_bystander(assets: Assets, body: Any, name: str, spec: ObjectSpec) -> None:
    """A clothed person standing upright, facing +x, arms hanging or folded; size z: the stature.

    rgb: the skin.
    """
    rng = assets.rng(name)
    anatomy = Anatomy.of(spec.size_m[2], shoulder_scale=float(rng.uniform(0.94, 1.06)))
    H, k = anatomy.stature_m, anatomy.stature_m / 1.72
    looks = Appearance(skin_rgb=spec.rgb, hair_rgb=colour_of(rng, 0.03, 0.35, 0.75))
    shirt = colour_of(rng, 0.08, 0.75, 0.3)
    assets.cloth(f"{name}:shirt", shirt, str(rng.choice(list(PATTERNS))))
    assets.plain(f"{name}:trousers", colour_of(rng, 0.05, 0.35, 0.7))
    assets.plain(f"{name}:skin", spec.rgb, specular=0.05, shininess=0.2)
    assets.painted(
        f"{name}:face", assets.texture(f"{name}:face", face_texture, looks), specular=0.05
    )
    assets.painted(
        f"{name}:hair", assets.texture(f"{name}:hair", hair_texture, looks), specular=0.1
    )
    neck = 0.818 * H
    head = (0.015, 0.0, neck + anatomy.neck_to_head_centre_m)
    turn = assets.quaternion(about_z(float(rng.uniform(-0.5, 0.5))))
    assets.add(
        body, f"{name}:torso", torso_surface(anatomy), f"{name}:shirt", 0, pos=(0.0, 0.0, neck)
    )
    assets.add(
        body,
        f"{name}:head",
        head_surface(anatomy),
        f"{name}:face",
        0,
        pos=head,
        quat=turn,
        castshadow=False,
    )
    hair = hair_surface(anatomy, looks.hair)
    assets.add(body, f"{name}:hair", hair, f"{name}:hair", 0, pos=head, quat=turn)
    ends = ((0.0, 0.0, neck), (0.008, 0.0, neck + 0.10 * k))
    assets.capsule(body, f"{name}:neck", ends, 0.046 * k, f"{name}:skin")
    hip = neck - 0.50 * k
    for side in (-1, 1):
        y = 0.085 * k * side
        for part, (high, low), radius in (
            ("thigh", (hip, 0.285 * H), 0.078 * k),
            ("shin", (0.285 * H, 0.06), 0.056 * k),
        ):
            ends = ((0.0, y, high), (0.0, y, low))
            assets.capsule(body, f"{name}:{part}:{side}", ends, radius, f"{name}:trousers")
        ends = ((-0.04, y, 0.04), (0.15, 1.25 * y, 0.04))
        assets.capsule(body, f"{name}:foot:{side}", ends, 0.042, f"{name}:trousers")
        folded = (
            float(rng.uniform(0.1, 0.35)) if rng.random() < 0.6 else float(rng.uniform(1.2, 1.7))
        )
        _arm(assets, body, name, anatomy, side, neck, folded)


def _arm(
    assets: Assets, body: Any, name: str, anatomy: Anatomy, side: int, neck_m: float, bend: float
) -> None:
    """An arm with this bend of its elbow [rad]."""
    k = anatomy.stature_m / 1.72
    shoulder = np.array(
        [-0.01, side * anatomy.shoulder_half_breadth_m, neck_m - anatomy.shoulder_drop_m]
    )
    out = side * np.array([0.0, 0.14, 0.0])
    down = np.array([-0.08, 0.0, -1.0]) + out
    elbow = shoulder + anatomy.upper_arm_m * down / np.linalg.norm(down)
    fore = about_z(-side * 0.5 * bend) @ np.array([np.sin(bend), 0.0, -np.cos(bend)])
    wrist = elbow + anatomy.forearm_m * fore
    for part, start, end, radii in (
        ("upper_arm", shoulder, elbow, [0.052, 0.050, 0.045]),
        ("forearm", elbow, wrist, [0.045, 0.041, 0.033]),
    ):
        surface = limb(float(np.linalg.norm(end - start)), np.array(radii) * k, sides=18, rings=6)
        x, y, z = start.tolist()
        quat = assets.quaternion(bone_frame(start, end))
        assets.add(
            body, f"{name}:{part}:{side}", surface, f"{name}:shirt", 0, pos=(x, y, z), quat=quat
        )
    _hand(
        assets,
        body,
        f"{name}:hand:{side}",
        anatomy,
        wrist,
        bone_frame(elbow, wrist),
        f"{name}:skin",
    )


def _hand(
    assets: Assets, body: Any, name: str, anatomy: Anatomy, wrist_m: Floats, turn: Floats, skin: str
) -> None:
    """A relaxed hand at the end of a forearm whose frame (3, 3) has x along it."""
    palm_m = wrist_m + anatomy.wrist_to_palm_m * turn[:, 0]
    x, y, z = palm_m.tolist()
    quat = assets.quaternion(turn)
    assets.add(
        body, name, palm_surface(anatomy), skin, 0, pos=(x, y, z), quat=quat, castshadow=False
    )
    for finger in fingers(anatomy):
        base, straight = palm_m + turn @ finger.base_m, turn @ finger.rotation
        segments = placed_segments(finger, 0.25, base, straight)
        for i, (surface, joint, way, _) in enumerate(segments):
            x, y, z = joint.tolist()
            assets.add(
                body, f"{name}:{finger.name}{i}", surface, skin, 0, pos=(x, y, z),
                quat=assets.quaternion(way), castshadow=False,
            )  # fmt: skip
