"""The person's variety: every look builds, and none of it changes whose skin is whose."""

from dataclasses import replace
from itertools import cycle, product

import cv2
import numpy as np
import pytest

from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND, TARGETS
from sim.camera.render import StereoRenderer
from sim.person.face import EXPRESSIONS
from sim.person.geoms import SKIN
from sim.person.hair import HAIR
from sim.person.rest import rest_pose
from sim.person.sleeves import SLEEVES
from sim.scene.world import build
from sim.specs import Appearance, RigSpec, RoomSpec, SceneSpec
from sim.surfaces.textures import PATTERNS, SURFACES

SCENE = SceneSpec(rig=RigSpec(tilt_rad=0.28, width_px=320, height_px=240, focal_px=270.0))
HANDS = (RIGHT_HAND, LEFT_HAND)
# From very light to dark, about the middles of Chardon's six classes.
TONES = (
    (0.95, 0.80, 0.73),
    (0.87, 0.66, 0.55),
    (0.79, 0.57, 0.43),
    (0.66, 0.45, 0.31),
    (0.47, 0.30, 0.20),
    (0.29, 0.19, 0.14),
)


def look(appearance, room=None, colour=True, amodal=False):
    scene = replace(SCENE, appearance=appearance, room=room or SCENE.room)
    world = build(scene)
    world.place(rest_pose(scene.anatomy))
    with StereoRenderer(world) as renderer:
        return world, renderer.render(colour=colour, amodal=amodal)[0]


def geoms_named(world, start):
    return [g for g in range(world.model.ngeom) if world.model.geom(g).name.startswith(start)]


def shown(world, view, start):
    return np.isin(view.geoms, geoms_named(world, start))


def test_every_look_builds_and_only_named_skin_is_a_target():
    others = zip(cycle(SLEEVES), cycle(PATTERNS), cycle(EXPRESSIONS), strict=False)
    for hair, (sleeves, pattern, expression) in zip(HAIR, others, strict=False):
        look_ = Appearance(
            hair=hair,
            sleeves=sleeves,
            shirt_pattern=pattern,
            beard=True,
            glasses=True,
            expression=expression,
        )
        world = build(replace(SCENE, appearance=look_))
        for geom, target in enumerate(world.targets):
            assert (target >= 0) == world.model.geom(geom).name.startswith(SKIN)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"sleeves": "none"}, r"Appearance.sleeves must be one of long, rolled, short, got 'none'"),
        (
            {"hair": "red"},
            r"Appearance.hair must be one of short, long, bald, curly, .*, got 'red'",
        ),
        ({"expression": "sad"}, r"Appearance.expression must be one of neutral, .*, got 'sad'"),
        ({"shirt_pattern": "dots"}, r"shirt_pattern must be one of plain, stripes, checks, got"),
    ],
)
def test_an_unknown_word_is_refused(wrong, words):
    with pytest.raises(ValueError, match=words):
        build(replace(SCENE, appearance=Appearance(**wrong)))


def test_an_unknown_table_is_refused():
    with pytest.raises(ValueError, match="table_surface must be one of wood, cloth, plain, got"):
        build(replace(SCENE, room=RoomSpec(table_surface="glass")))


def test_bare_arms_show_skin_of_no_target():
    """The shorter the sleeve, the more; of the same colour as the hands' skin."""
    bare = []
    for sleeves in SLEEVES:
        world, view = look(Appearance(sleeves=sleeves))
        arm = shown(world, view, "bare:")
        assert (view.targets[arm] == -1).all()
        bare.append(int(arm.sum()))
        if arm.any():
            hsv = cv2.cvtColor(view.colour.astype(np.float32) / 255, cv2.COLOR_BGR2HSV)
            hands = np.isin(view.targets, HANDS)
            np.testing.assert_allclose(
                # The hands are a little redder, over the knuckles.
                np.median(hsv[arm], axis=0)[:2],
                np.median(hsv[hands], axis=0)[:2],
                rtol=0.08,
            )
    assert bare[0] == 0
    assert 375 < bare[1] < 0.9 * bare[2]


@pytest.mark.parametrize("sleeves", SLEEVES)
def test_a_free_hand_is_whole_with_any_sleeve_and_ends_at_the_wrist(sleeves):
    world, view = look(Appearance(sleeves=sleeves), colour=False, amodal=True)
    wrists = [world.data.body(f"hand:{side}").xpos for side in ("right", "left")]
    for target, palm in zip(HANDS, wrists, strict=True):
        visible = int((view.targets == target).sum())
        assert visible > 0.95 * view.amodal_px[target]
        ys, xs = np.nonzero(view.targets == target)
        points = _points(world, view, xs, ys)
        assert np.linalg.norm(points - palm, axis=1).max() < 0.135  # a finger's tip is farthest


def _points(world, view, xs, ys):
    camera = world.rig.left
    rays = np.column_stack([xs, ys, np.ones(len(xs))]) @ np.linalg.inv(camera.K).T
    return (rays * view.depth_m[ys, xs][:, None] - camera.t_cw) @ camera.R_cw


def test_hands_have_the_same_labels_with_any_sleeve():
    masks = []
    for sleeves in SLEEVES:
        _, view = look(Appearance(sleeves=sleeves), colour=False)
        masks.append(np.isin(view.targets, HANDS))
    size = masks[0].sum()
    for mask in masks[1:]:
        # Cuff and bare wrist end the hand at nearly the same place.
        assert (mask ^ masks[0]).sum() < 0.06 * size


@pytest.mark.long
def test_hair_is_no_skin_and_long_hair_covers_more_of_it():
    heads = {}
    for hair in HAIR:
        world, view = look(Appearance(hair=hair), colour=False)
        mine = shown(world, view, "hair")
        assert (view.targets[mine] == -1).all()
        assert mine.any() == (hair != "bald")
        heads[hair] = int((view.targets == HEAD).sum())
    assert heads["long"] < heads["short"] < 0.9 * heads["bald"]
    assert heads["short"] < heads["receding"] < heads["bald"]


def test_a_beard_is_the_faces_and_glasses_are_not():
    _, plain = look(Appearance())
    _, beard = look(Appearance(beard=True))
    world, glasses = look(Appearance(glasses=True))
    np.testing.assert_array_equal(plain.targets, beard.targets)
    assert (plain.colour != beard.colour).any(axis=-1)[plain.targets == HEAD].mean() > 0.08
    frame = np.zeros_like(glasses.targets, dtype=bool)
    for part in ("rim", "temple", "bridge"):
        frame |= shown(world, glasses, part)
    assert 8 < frame.sum() < 100
    np.testing.assert_array_equal(plain.targets[~frame], glasses.targets[~frame])
    assert (glasses.targets[frame] == -1).all()


@pytest.mark.long
def test_skin_tones_arrive_in_the_picture_in_their_order():
    """At least six levels, each visibly darker than the one before, on hands and head alike."""
    levels = []
    for skin in TONES:
        _, view = look(Appearance(skin_rgb=skin, hair="bald"))
        lab = cv2.cvtColor(view.colour.astype(np.float32) / 255, cv2.COLOR_BGR2LAB)
        levels.append([np.median(lab[view.targets == t][:, 0]) for t in range(len(TARGETS))])
    assert (np.diff(levels, axis=0) < -4.0).all()


@pytest.mark.sample(1)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_the_shirt_has_the_colour_and_the_pattern_asked_for(pattern):
    world, view = look(Appearance(shirt_rgb=(0.15, 0.22, 0.52), shirt_pattern=pattern))
    shirt = shown(world, view, "torso") & ~_edge(shown(world, view, "torso"))
    hsv = cv2.cvtColor(view.colour.astype(np.float32) / 255, cv2.COLOR_BGR2HSV)[shirt]
    blue = (hsv[:, 0] > 200) & (hsv[:, 0] < 250)
    assert blue.mean() > 0.97  # the print has the same hue
    spread = np.subtract(*np.percentile(hsv[:, 1], [90, 10]))
    assert (spread > 0.25) == (pattern != "plain")


def _edge(mask):
    return cv2.erode(mask.astype(np.uint8), np.ones((5, 5))) == 0


@pytest.mark.long
def test_the_table_has_the_colour_asked_for_on_every_surface():
    for surface, rgb in product(SURFACES, ((0.30, 0.50, 0.34), (0.72, 0.52, 0.38))):
        room = RoomSpec(table_rgb=rgb, table_surface=surface)
        world, view = look(Appearance(), room)
        top = shown(world, view, "table:top")
        mean = view.colour[top].mean(axis=0)[::-1]
        np.testing.assert_allclose(mean / mean.sum(), np.array(rgb) / sum(rgb), atol=0.02)


def test_warm_light_is_redder_and_a_gain_is_a_gain():
    """The rendered white follows `light_rgb`: colours are products of light and surface."""
    views = {}
    for rgb in ((1.0, 1.0, 1.0), (1.25, 0.95, 0.6)):
        room = RoomSpec(light_rgb=rgb, light_gain=0.7)
        world, views[rgb] = look(Appearance(), room)
    wall = shown(world, views[rgb], "wall:back")
    white, warm = (view.colour[wall].mean(axis=0)[::-1] for view in views.values())
    np.testing.assert_allclose(warm / white, rgb, rtol=0.02)


def test_the_key_light_turns_about_the_vertical():
    shadows = []
    for azimuth in (-0.5, 0.5):
        _, view = look(Appearance(), RoomSpec(light_azimuth_rad=azimuth))
        dark = view.colour.mean(axis=-1)[150:, :]
        shadows.append(dark[:, :160].mean() - dark[:, 160:].mean())
    assert abs(shadows[0] - shadows[1]) > 0.5
