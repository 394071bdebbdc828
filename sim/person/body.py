"""The seated person: clothed but for head and hands, every part posed from a `sim.pose.Pose`.

Skin that belongs to a target: face, ears and the short stretch of neck above the high collar are
the head's; palm, fingers and the wrist outside the sleeve are the hand's. Painted eyes, brows, lips
and beard are part of the face; hair, glasses, and bare arms (sleeves not long) are no target's.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pjpdaf.targets import HEAD
from sim.anatomy import Anatomy
from sim.person.face import EXPRESSIONS, face_texture
from sim.person.geoms import HAND_TARGETS, LEGS, SKIN, TARGET_GROUPS
from sim.person.hair import HAIR, bun_surface, curtain_surface, hair_surface, hair_texture
from sim.person.hand import Finger, fingers, mirrored, palm_surface
from sim.person.head import ear_surface, head_surface
from sim.person.skin import hand_texture, skin_texture
from sim.person.sleeves import SLEEVES, add_arm
from sim.person.torso import add_torso
from sim.pose import SIDES
from sim.specs import Appearance
from sim.surfaces.assets import Assets, check_word, turned
from sim.surfaces.shapes import Surface, limb
from sim.surfaces.textures import PATTERNS


def mocap_parts() -> tuple[str, ...]:
    """Names of the person's posed bodies."""
    arms = [f"{part}:{side}" for side in SIDES for part in ("upper_arm", "forearm", "hand")]
    return ("torso", "head", *arms)


def add_person(assets: Assets, anatomy: Anatomy, appearance: Appearance) -> None:
    """Add the person's bodies, meshes and materials to the spec; all bodies at the origin.

    Raises ValueError for a word of the appearance that is not known.
    """
    check_word("Appearance.sleeves", appearance.sleeves, SLEEVES)
    check_word("Appearance.hair", appearance.hair, HAIR)
    check_word("Appearance.expression", appearance.expression, EXPRESSIONS)
    check_word("Appearance.shirt_pattern", appearance.shirt_pattern, PATTERNS)
    world = assets.spec.worldbody
    bodies = {name: world.add_body(name=name, mocap=True) for name in mocap_parts()}
    shirt = assets.cloth("shirt", appearance.shirt_rgb, appearance.shirt_pattern)
    for name, paint in (("skin", skin_texture), ("hand", hand_texture)):
        picture = assets.texture(name, paint, appearance.skin_rgb)
        assets.painted(name, picture, specular=0.05, shininess=0.2)
    add_torso(assets, bodies["torso"], anatomy, shirt)
    _legs(assets, anatomy)
    _head(assets, bodies["head"], anatomy, appearance)
    chain = tuple((finger, finger.segments()) for finger in fingers(anatomy))
    palm = palm_surface(anatomy)
    for side, target in zip(SIDES, HAND_TARGETS, strict=True):
        add_arm(
            assets,
            bodies[f"upper_arm:{side}"],
            bodies[f"forearm:{side}"],
            anatomy,
            side,
            appearance,
        )
        _hand(assets, bodies[f"hand:{side}"], side, target, palm, chain)


def _legs(assets: Assets, anatomy: Anatomy) -> None:
    """Trousers under the table; they stand still."""
    H = anatomy.stature_m
    assets.plain("trousers", (0.10, 0.10, 0.12))
    body = assets.spec.worldbody
    seat, knee = 0.245 * H + 0.075, 0.285 * H
    for side, y in (("right", -1.0), ("left", 1.0)):
        for part, ends in (
            ("thigh", ((-0.05, 0.09 * y, seat), (0.36, 0.13 * y, knee))),
            ("shin", ((0.36, 0.13 * y, knee), (0.30, 0.14 * y, 0.10))),
            ("foot", ((0.27, 0.14 * y, 0.045), (0.45, 0.15 * y, 0.04))),
        ):
            assets.capsule(
                body,
                f"{part}:{side}",
                ends,
                0.07 if part == "thigh" else 0.048,
                "trousers",
                LEGS,
            )


def _head(assets: Assets, body: Any, anatomy: Anatomy, appearance: Appearance) -> None:
    group = TARGET_GROUPS[HEAD]
    k = anatomy.head_breadth_m / 0.1522
    assets.painted(
        "face",
        assets.texture("face", face_texture, appearance),
        specular=0.06,
        shininess=0.15,
    )
    assets.add(body, f"{SKIN}face", head_surface(anatomy), "face", group, castshadow=False)
    # A smooth core casts the shadow: the nose's own would be a few jagged texels across the mouth.
    core = (
        0.80 * anatomy.head_depth_m / 2,
        0.86 * anatomy.head_breadth_m / 2,
        0.94 * anatomy.head_height_m / 2,
    )
    assets.ellipsoid(body, "head:core", (-0.004, 0.0, 0.0), core, "skin", group)
    _hair(assets, body, group, anatomy, appearance)
    ear = ear_surface(anatomy)
    for side, y in (("right", -1.0), ("left", 1.0)):
        assets.add(
            body,
            f"{SKIN}ear:{side}",
            ear if side == "left" else mirrored(ear),
            "skin",
            group,
            pos=(-0.008 * k, 0.0735 * k * y, -0.006 * k),
            quat=turned(-0.45 * y),
            castshadow=False,  # it would be a few jagged texels on the neck
        )
    # The neck hangs from the head into the collar; only the part above the collar is visible.
    neck = limb(0.105 * k, np.array([0.0445, 0.0435, 0.0435]) * k, sides=20, rings=4, far_cap=0.1)
    assets.add(
        body,
        f"{SKIN}neck",
        neck,
        "skin",
        group,
        pos=(-0.008, 0.0, -0.040),
        quat=(0.7071068, 0.0, 0.7071068, 0.0),
    )
    if appearance.glasses:
        _glasses(assets, body, group, anatomy)


def _hair(assets: Assets, body: Any, group: int, anatomy: Anatomy, appearance: Appearance) -> None:
    """The cap of hair, with long hair below it or a bun behind."""
    if appearance.hair == "bald":
        return
    picture = assets.texture("hair", hair_texture, appearance)
    assets.painted("hair", picture, specular=0.10, shininess=0.2)
    assets.add(body, "hair", hair_surface(anatomy, appearance.hair), "hair", group)
    if appearance.hair == "long":
        assets.add(body, "hair:long", curtain_surface(anatomy), "hair", group)
    elif appearance.hair == "bun":
        assets.add(body, "hair:bun", bun_surface(anatomy), "hair", group)


def _glasses(assets: Assets, body: Any, group: int, anatomy: Anatomy) -> None:
    k = anatomy.head_depth_m / 0.1978
    w = anatomy.head_breadth_m / 0.1522
    assets.plain("frame", (0.06, 0.06, 0.07), specular=0.3, shininess=0.5)
    for side, y in (("right", -1.0), ("left", 1.0)):
        centre = np.array([0.099 * k, 0.034 * w * y, 0.004])
        turn = np.linspace(0, 2 * np.pi, 13)
        rim = np.column_stack(
            [0 * turn - 0.004 * np.cos(turn) * y, 0.024 * w * np.cos(turn), 0.018 * np.sin(turn)]
        )
        for i in range(len(turn) - 1):
            ends = (tuple(centre + rim[i]), tuple(centre + rim[i + 1]))
            assets.capsule(body, f"rim:{side}:{i}", ends, 0.0016, "frame", group, castshadow=False)
        ends = ((0.095 * k, 0.058 * w * y, 0.008), (-0.01 * k, 0.079 * w * y, 0.010))
        assets.capsule(body, f"temple:{side}", ends, 0.0016, "frame", group, castshadow=False)
    ends = ((0.102 * k, -0.011 * w, 0.008), (0.102 * k, 0.011 * w, 0.008))
    assets.capsule(body, "bridge", ends, 0.0016, "frame", group, castshadow=False)


def _hand(
    assets: Assets,
    body: Any,
    side: str,
    target: int,
    palm: Surface,
    chain: tuple[tuple[Finger, tuple[Surface, ...]], ...],
) -> None:
    """Palm and fingers with their segments; the left hand is the right hand mirrored in y."""
    group = TARGET_GROUPS[target]
    left = side == "left"
    flip = np.diag([1.0, -1.0, 1.0]) if left else np.eye(3)
    palm = mirrored(palm) if left else palm
    assets.add(body, f"{SKIN}palm:{side}", palm, "hand", group, castshadow=False)
    extent = palm.vertices_m.max(axis=0) - palm.vertices_m.min(axis=0)
    core = (0.36 * extent[0], 0.34 * extent[1], 0.22 * extent[2])
    assets.ellipsoid(body, f"core:palm:{side}", (-0.15 * extent[0], 0.0, 0.0), core, "skin", group)
    for finger, segments in chain:
        rotation = flip @ finger.rotation @ flip
        # An axis is an axial vector: a mirror reverses it within the mirror's plane.
        axis = -(flip @ finger.axis) if left else finger.axis
        parent, offset = body, flip @ finger.base_m
        for i, surface in enumerate(segments):
            name = f"{finger.name}{i}:{side}"
            placed = {"pos": offset.tolist()}
            if i == 0:
                placed["quat"] = assets.quaternion(rotation)
            parent = parent.add_body(name=name, **placed)
            parent.add_joint(name=name, axis=axis.tolist())
            assets.add(
                parent,
                f"{SKIN}{name}",
                surface,
                "hand",
                group,
                mesh=f"{finger.name}{i}",
                castshadow=False,
            )
            # A thinner core casts the shadow, without speckles on the finger itself.
            ends = ((0.0, 0.0, 0.0), (finger.lengths_m[i], 0.0, 0.0))
            radius = 0.6 * finger.radii_m[i + 1]
            assets.capsule(parent, f"core:{name}", ends, radius, "skin", group)
            offset = np.array([finger.lengths_m[i], 0.0, 0.0])
