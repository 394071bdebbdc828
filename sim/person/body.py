"""The seated person: clothed but for head and hands, every part posed from a `sim.pose.Pose`.

Skin that belongs to a target: face, ears and the short stretch of neck above the high collar are
the head's; palm, fingers and the wrist outside the sleeve are the hand's. Painted eyes, brows, lips
and beard are part of the face; hair, glasses, and bare arms (sleeves not long) are no target's.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND
from sim.anatomy import Anatomy
from sim.person import head as head_shapes
from sim.person.hand import Finger, fingers, mirrored, palm_surface
from sim.pose import SIDES
from sim.specs import Appearance
from sim.surfaces.assets import Assets, check_word
from sim.surfaces.shapes import (
    Surface,
    capped,
    closed_grid,
    interpolate,
    limb,
    revolved,
    superellipse,
)
from sim.surfaces.textures import PATTERNS

# Geom groups, so that parts can be hidden: the room stays when the person goes.
ROOM, CLOTHES = 0, 1
TARGET_GROUPS = {HEAD: 2, RIGHT_HAND: 3, LEFT_HAND: 4}
SKIN = "skin:"  # prefix of the names of all geoms that are a target's visible skin
HAND_TARGETS = (RIGHT_HAND, LEFT_HAND)  # in the order of SIDES
ELBOW_M, WRIST_M = 0.043, 0.031  # radii of the sleeve, of an average arm
COLLAR_TOP_M = 0.088  # above the mid-shoulder point
SLEEVES = ("long", "rolled", "short")  # rolled: bare forearm; short: bare above the elbow as well
SHORT_SLEEVE = 0.60  # of the upper arm
SHIRT_M = 0.64  # length of the shirt, which its texture spans once
_ALONG_X = (0.7071068, 0.0, 0.7071068, 0.0)  # z of a body of revolution to x


def mocap_parts() -> tuple[str, ...]:
    """Names of the person's posed bodies."""
    arms = [f"{part}:{side}" for side in SIDES for part in ("upper_arm", "forearm", "hand")]
    return ("torso", "head", *arms)


def add_person(assets: Assets, anatomy: Anatomy, appearance: Appearance) -> None:
    """Add the person's bodies, meshes and materials to the spec; all bodies at the origin.

    Raises ValueError for a word of the appearance that is not known.
    """
    check_word("Appearance.sleeves", appearance.sleeves, SLEEVES)
    check_word("Appearance.hair", appearance.hair, head_shapes.HAIR)
    check_word("Appearance.shirt_pattern", appearance.shirt_pattern, PATTERNS)
    world = assets.spec.worldbody
    bodies = {name: world.add_body(name=name, mocap=True) for name in mocap_parts()}
    shirt = assets.cloth("shirt", appearance.shirt_rgb, appearance.shirt_pattern)
    assets.plain("skin", appearance.skin_rgb, specular=0.05, shininess=0.2)
    _torso(assets, bodies["torso"], anatomy, shirt)
    _legs(assets, anatomy)
    _head(assets, bodies["head"], anatomy, appearance)
    chain = fingers(anatomy)
    palm = palm_surface(anatomy)
    for side, target in zip(SIDES, HAND_TARGETS, strict=True):
        _arm(
            assets,
            bodies[f"upper_arm:{side}"],
            bodies[f"forearm:{side}"],
            anatomy,
            side,
            appearance,
        )
        _hand(assets, bodies[f"hand:{side}"], side, target, palm, chain)


def _torso(assets: Assets, body: Any, anatomy: Anatomy, shirt: str) -> None:
    assets.add(body, "torso", tailored(torso_surface(anatomy), 2, share=1.0), shirt, CLOTHES)
    # The collar goes with the head's group: it is what hides the neck of a head that nothing else
    # hides, so the amodal pass shows it.
    collar = revolved(
        np.array(
            [
                [0.050, 0.040],
                [0.0565, 0.048],
                [0.0555, 0.066],
                [0.0570, COLLAR_TOP_M - 0.008],
                [0.0560, COLLAR_TOP_M - 0.002],
                [0.0520, COLLAR_TOP_M],
                [0.0480, COLLAR_TOP_M - 0.004],
                [0.0470, COLLAR_TOP_M - 0.030],
            ]
        ),
        28,
    )
    collar = tailored(collar, 2, share=1 / 3)
    assets.add(body, "collar", collar, shirt, TARGET_GROUPS[HEAD], pos=(0.004, 0.0, 0.0))


def torso_surface(anatomy: Anatomy) -> Surface:
    """Shoulders, chest and waist in the torso frame, with a high collar."""
    k = anatomy.stature_m / 1.72
    s = anatomy.shoulder_half_breadth_m / 0.18576
    # height, half breadth, front, back, exponent of the cross-section
    table = np.array(
        [
            [-0.560, 0.120, 0.070, 0.080, 2.4],
            [-0.530, 0.165, 0.100, 0.115, 2.5],
            [-0.450, 0.166, 0.112, 0.118, 2.5],
            [-0.340, 0.148, 0.108, 0.104, 2.4],
            [-0.240, 0.152, 0.112, 0.106, 2.4],
            [-0.150, 0.166, 0.118, 0.112, 2.5],
            [-0.090, 0.182, 0.110, 0.108, 2.5],
            [-0.045, 0.198, 0.090, 0.092, 2.4],
            [-0.020, 0.198, 0.076, 0.080, 2.3],
            [0.000, 0.188, 0.069, 0.074, 2.2],
            [0.018, 0.168, 0.063, 0.069, 2.1],
            [0.034, 0.130, 0.057, 0.063, 2.0],
            [0.047, 0.083, 0.053, 0.057, 2.0],
            [0.058, 0.055, 0.049, 0.051, 2.0],
            [0.070, 0.046, 0.044, 0.044, 2.0],
        ]
    )
    z = np.concatenate([np.linspace(-0.56, -0.12, 12), np.linspace(-0.10, 0.07, 16)])
    half, front, back, exponent = interpolate(table, z).T
    grid = np.empty((len(z), 37, 3))
    for ring in range(len(z)):
        outline = -superellipse(36, exponent[ring])  # the seam at the back
        depth = np.where(outline[:, 0] >= 0, front[ring], back[ring])
        grid[ring, :, 0] = depth * outline[:, 0] * k
        grid[ring, :, 1] = half[ring] * outline[:, 1] * (s if z[ring] < 0.03 else k)
        grid[ring, :, 2] = z[ring] * (k if z[ring] < 0 else 1)
    # The shoulders stand a little behind the neck; the chest curves forward.
    grid[..., 0] += np.interp(z, [-0.56, -0.15, 0.0, 0.09], [-0.01, 0.0, 0.0, 0.006])[:, None]
    return closed_grid(capped(grid)[::-1])


def tailored(surface: Surface, axis: int, share: float = 1 / 3) -> Surface:
    """The surface clothed: the shirt's texture runs along an axis of the part at its true scale.

    share: of the shirt's width that goes round the part.
    """
    along = -surface.vertices_m[:, axis] / SHIRT_M
    uv = np.column_stack([surface.uv[:, 0] * share, along - along.min()])
    return Surface(surface.vertices_m, surface.normals, uv, surface.faces)


def limb_ring(radius_m: float, thickness_m: float) -> Surface:
    """A torus about z."""
    turn = np.linspace(0, 2 * np.pi, 29)
    tube = superellipse(8, 2.0)
    grid = np.empty((len(turn), len(tube), 3))
    reach = radius_m + thickness_m * tube[:, 0]
    grid[..., 0] = np.cos(turn)[:, None] * reach
    grid[..., 1] = np.sin(turn)[:, None] * reach
    grid[..., 2] = thickness_m * tube[:, 1]
    return closed_grid(grid)


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
                CLOTHES,
            )


def _head(assets: Assets, body: Any, anatomy: Anatomy, appearance: Appearance) -> None:
    group = TARGET_GROUPS[HEAD]
    k = anatomy.head_breadth_m / 0.1522
    assets.painted(
        "face",
        head_shapes.face_texture(assets.rng("face"), appearance),
        specular=0.06,
        shininess=0.15,
    )
    assets.painted(
        "hair",
        head_shapes.hair_texture(assets.rng("hair"), appearance),
        specular=0.10,
        shininess=0.2,
    )
    assets.add(
        body, f"{SKIN}face", head_shapes.head_surface(anatomy), "face", group, castshadow=False
    )
    # A smooth core casts the shadow: the nose's own would be a few jagged texels across the mouth.
    core = (
        0.80 * anatomy.head_depth_m / 2,
        0.86 * anatomy.head_breadth_m / 2,
        0.94 * anatomy.head_height_m / 2,
    )
    assets.ellipsoid(body, "head:core", (-0.004, 0.0, 0.0), core, "skin", group)
    if appearance.hair != "bald":
        assets.add(body, "hair", head_shapes.hair_surface(anatomy), "hair", group)
    if appearance.hair == "long":
        assets.add(body, "hair:long", head_shapes.curtain_surface(anatomy), "hair", group)
    for side, y in (("right", -1.0), ("left", 1.0)):
        assets.ellipsoid(
            body,
            f"{SKIN}ear:{side}",
            (-0.008 * k, 0.0735 * k * y, -0.006 * k),
            (0.017 * k, 0.0065 * k, 0.029 * k),
            "skin",
            group,
            yaw_rad=-0.45 * y,
        )
    # The neck hangs from the head into the collar; only what the collar leaves is seen.
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


def _arm(
    assets: Assets, upper: Any, fore: Any, anatomy: Anatomy, side: str, appearance: Appearance
) -> None:
    """Sleeve, and below it the bare arm: skin of no target."""
    k = anatomy.stature_m / 1.72
    wrist = WRIST_M * anatomy.hand_breadth_m / 0.0851
    # A little short of the wrist, where the hand's own skin begins.
    long_m, upper_m = anatomy.forearm_m - 0.012, anatomy.upper_arm_m
    cloth = np.array([ELBOW_M, 0.0455, 0.0415, 0.036, wrist / k]) * k
    arm = np.array([0.0480, 0.0505, 0.0485, 0.0450, ELBOW_M]) * k
    skin = np.array([0.0360, 0.0405, 0.0365, 0.0295, 0.76 * wrist / k]) * k
    share = {"long": 1.0, "rolled": 0.30, "short": 0.0}[appearance.sleeves]
    # The sleeve's part that covers the upper arm, and then what is bare of it.
    if appearance.sleeves == "short":
        ends = np.array([1.0, 1.02, 1.0, 0.98, 1.0]) * arm[:1]
        _sleeve(assets, upper, f"upper_arm:{side}", SHORT_SLEEVE * upper_m, ends, hem_m=0.003)
        bare = np.array([0.0400, 0.0425, 0.0410, 0.0375, 0.0360]) * k
        surface = limb(upper_m, bare, sides=20, rings=8)
        assets.add(upper, f"bare:upper_arm:{side}", surface, "skin", CLOTHES)
    else:
        surface = tailored(limb(upper_m, arm, sides=22, rings=9, end_rings=5), 0)
        assets.add(upper, f"upper_arm:{side}", surface, "shirt", CLOTHES)
    if appearance.sleeves == "long":
        surface = limb(long_m, cloth, sides=20, rings=9, flatness=0.94, far_cap=0.15)
        assets.add(fore, f"forearm:{side}", tailored(surface, 0), "shirt", CLOTHES)
        _cuff(assets, fore, side, long_m, wrist)
        return
    if share > 0.0:
        ends = np.array([1.0, 1.06, 1.08]) * cloth[0]
        _sleeve(assets, fore, f"forearm:{side}", share * long_m, ends, hem_m=0.006)
    surface = limb(long_m, skin, sides=20, rings=11, far_cap=0.15)
    assets.add(fore, f"bare:forearm:{side}", surface, "skin", CLOTHES)
    # The same wrist once more with the hand, as the cuff of a long sleeve: in the amodal pass it
    # hides the stub that reaches into the forearm. Thinner, so that the forearm covers it.
    stub = limb(0.030, skin[-1] * np.array([1.10, 0.985]), sides=20, rings=3, far_cap=0.14)
    group = TARGET_GROUPS[HAND_TARGETS[SIDES.index(side)]]
    at = (long_m - 0.030, 0.0, 0.0)
    assets.add(fore, f"wrist:{side}", stub, "skin", group, pos=at, castshadow=False)


def _sleeve(
    assets: Assets, body: Any, name: str, length_m: float, radii_m: Floats, hem_m: float
) -> None:
    """A sleeve that ends on the way, with a hem or a rolled cuff that is hem_m thick."""
    surface = limb(length_m, radii_m, sides=22, rings=6, end_rings=5, far_cap=0.05)
    assets.add(body, name, tailored(surface, 0), "shirt", CLOTHES)
    r, wide = float(radii_m[-1]), 0.012 + 3.5 * hem_m
    outline = np.array(
        [
            [r - 0.010, -wide],
            [r + 0.6 * hem_m, -wide],
            [r + hem_m, -0.75 * wide],
            [r + hem_m, -0.15 * wide],
            [r + 0.6 * hem_m, 0.0],
            [r - 0.010, 0.0],
        ]
    )
    hem = tailored(revolved(outline, 22), 2)
    assets.add(
        body, f"hem:{name}", hem, "shirt", CLOTHES, pos=(length_m + 0.004, 0.0, 0.0), quat=_ALONG_X
    )


def _cuff(assets: Assets, fore: Any, side: str, long_m: float, wrist_m: float) -> None:
    """The end of a long sleeve. With the hand's group, as the collar is with the head's."""
    cuff = revolved(
        np.array(
            [
                [wrist_m * 0.93, -0.020],
                [wrist_m + 0.0015, -0.018],
                [wrist_m + 0.0022, 0.0],
                [wrist_m + 0.0012, 0.006],
                [wrist_m - 0.003, 0.006],
                [wrist_m - 0.004, -0.004],
            ]
        ),
        20,
    )
    group = TARGET_GROUPS[HAND_TARGETS[SIDES.index(side)]]
    at = (long_m - 0.003, 0.0, 0.0)
    cuff = tailored(cuff, 2)
    assets.add(fore, f"cuff:{side}", cuff, "shirt", group, pos=at, quat=_ALONG_X)


def _hand(
    assets: Assets,
    body: Any,
    side: str,
    target: int,
    palm: Surface,
    chain: tuple[Finger, ...],
) -> None:
    """Palm and fingers; the left hand is the right one mirrored in y."""
    group = TARGET_GROUPS[target]
    left = side == "left"
    flip = np.diag([1.0, -1.0, 1.0]) if left else np.eye(3)
    palm = mirrored(palm) if left else palm
    assets.add(body, f"{SKIN}palm:{side}", palm, "skin", group, castshadow=False)
    extent = palm.vertices_m.max(axis=0) - palm.vertices_m.min(axis=0)
    core = (0.42 * extent[0], 0.36 * extent[1], 0.30 * extent[2])
    assets.ellipsoid(body, f"core:palm:{side}", (-0.15 * extent[0], 0.0, 0.0), core, "skin", group)
    for finger in chain:
        rotation = flip @ finger.rotation @ flip
        # An axis is an axial vector: a mirror reverses it within the mirror's plane.
        axis = -(flip @ finger.axis) if left else finger.axis
        parent, offset = body, flip @ finger.base_m
        for i, surface in enumerate(finger.segments()):
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
                "skin",
                group,
                mesh=f"{finger.name}{i}",
                castshadow=False,
            )
            # A thinner core casts the shadow, without speckles on the finger itself.
            ends = ((0.0, 0.0, 0.0), (finger.lengths_m[i], 0.0, 0.0))
            radius = 0.6 * finger.radii_m[i + 1]
            assets.capsule(parent, f"core:{name}", ends, radius, "skin", group)
            offset = np.array([finger.lengths_m[i], 0.0, 0.0])
