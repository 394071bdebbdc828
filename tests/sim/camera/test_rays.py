"""Drawn ids and depth against rays, which know no raster; any pinhole against fixed ones."""

from dataclasses import replace

import numpy as np
import pytest

from sim.camera.rays import cast
from sim.camera.render import StereoRenderer
from sim.person.rest import rest_pose
from sim.scene.world import build
from sim.specs import Appearance, ObjectSpec, RigSpec, RoomSpec, SceneSpec

CAN = ObjectSpec("can", "can", (0.066, 0.066, 0.115), (0.72, 0.08, 0.10), (0.5, -0.3))
SCENE = SceneSpec(
    appearance=Appearance(glasses=True),
    rig=RigSpec(vergence_rad=0.05, principal_offset_px=(6.3, -4.2)),
    room=RoomSpec(objects=(CAN,)),
)
LENS = replace(SCENE, rig=replace(SCENE.rig, distortion=(-0.2, 0.05, 0.001, -0.0008)))


@pytest.fixture(scope="module", params=[SCENE, LENS], ids=["pinhole", "lens"])
def filmed(request):
    world = build(request.param)
    world.place(rest_pose(request.param.anatomy))
    with StereoRenderer(world) as renderer:
        yield world, renderer


@pytest.mark.sample(2)
@pytest.mark.parametrize("view", [0, 1])
def test_ids_and_depth_are_what_rays_meet(filmed, view):
    world, renderer = filmed
    drawn = renderer.view(view, colour=False, amodal=False)
    ys, xs = np.mgrid[:480, :640]
    geoms, depth = cast(world, world.rig.cameras[view], np.column_stack([xs.ravel(), ys.ravel()]))
    same = geoms == drawn.geoms.ravel()
    assert np.count_nonzero(~same) <= 20  # of 307,200: pixel centres that lie on an edge
    targets = np.append(world.targets, -1)
    for target in range(3):
        mine, its = targets[drawn.geoms.ravel()] == target, targets[geoms] == target
        assert np.count_nonzero(mine != its) <= 1e-3 * np.count_nonzero(its)
    off_m = np.abs(depth - drawn.depth_m.ravel())[same & (geoms >= 0)]
    assert np.median(off_m) < 1e-5
    assert np.quantile(off_m, 0.999) < 1.2e-4
    assert off_m.max() < 2e-3


def test_rays_meet_only_the_groups_that_are_there(filmed):
    world, renderer = filmed
    ys, xs = np.mgrid[:480:3, :640:3]
    pixels = np.column_stack([xs.ravel(), ys.ravel()])
    masks = renderer.view(0, colour=False, labels=False).amodal
    for target, group in enumerate(world.amodal_groups):
        geoms, _ = cast(world, world.rig.left, pixels, (group,))
        skin = np.append(world.targets, -1)[geoms] == target
        assert np.count_nonzero(skin != masks[target, ::3, ::3].ravel()) <= 2
        assert skin.sum() > 100


def test_a_ray_into_the_void_meets_nothing(filmed):
    world, _ = filmed
    geoms, depth = cast(world, world.rig.left, np.array([[320.0, 240.0]]), ())
    assert geoms.tolist() == [-1]
    assert np.isnan(depth).all()


@pytest.mark.parametrize("view", [0, 1])
def test_any_pinhole_draws_what_the_fixed_camera_draws(filmed, view):
    world, renderer = filmed
    if world.lenses[view]:
        pytest.skip("the fixed camera has a lens")
    drawn = renderer.view(view, colour=False, amodal=False)
    depth, geoms = renderer.pinhole(world.rig.cameras[view])
    assert np.count_nonzero(geoms != drawn.geoms) <= 2
    np.testing.assert_allclose(depth, drawn.depth_m, atol=1e-4)
    # And leaves nothing behind: the next view is the fixed camera's own again.
    again = renderer.view(view, colour=False, amodal=False)
    assert np.array_equal(again.geoms, drawn.geoms)


def test_a_pinhole_turned_and_moved_sees_what_rays_meet(filmed):
    world, renderer = filmed
    camera = world.rig.right
    K = np.array([[470.0, 0, 250.0], [0, 455.0, 260.0], [0, 0, 1]])
    turned = replace(
        camera, K=K, R_cw=world.rig.left.R_cw, width_px=600, height_px=500, distortion=np.zeros(0)
    )
    depth, geoms = renderer.pinhole(turned)
    assert geoms.shape == (500, 600)
    ys, xs = np.mgrid[:500:4, :600:4]
    met, met_m = cast(world, turned, np.column_stack([xs.ravel(), ys.ravel()]))
    same = met == geoms[::4, ::4].ravel()
    assert np.count_nonzero(~same) <= 4
    assert np.nanmedian(np.abs(met_m - depth[::4, ::4].ravel())[same]) < 1e-5


def test_a_pinhole_that_cannot_be_drawn_is_refused(filmed):
    world, renderer = filmed
    left = world.rig.left
    with pytest.raises(ValueError, match="without a lens"):
        renderer.pinhole(replace(left, distortion=np.array([0.1, 0.0, 0.0, 0.0])))
    with pytest.raises(ValueError, match="larger than the frame buffer"):
        renderer.pinhole(replace(left, width_px=5000, distortion=np.zeros(0)))


def test_amodal_pixels_beyond_the_border(filmed):
    """The same person, filmed with the principal point so far aside that a hand is cut off."""
    world, renderer = filmed
    if world.lenses[0]:
        pytest.skip("cut off by the principal point, which a lens turns into another picture")
    whole = renderer.view(0, colour=False, labels=False).amodal_px
    np.testing.assert_array_equal(renderer.amodal_beyond(0), whole)
    xs = np.nonzero(renderer.view(0, colour=False, labels=False).amodal[2])[1]
    shift = 639 - int(np.median(xs))
    aside = replace(SCENE.rig, principal_offset_px=(6.3 + shift, -4.2))
    cut = build(replace(SCENE, rig=aside))
    cut.place(rest_pose(SCENE.anatomy))
    with StereoRenderer(cut) as other:
        inside, beyond = other.view(0, colour=False, labels=False).amodal_px, other.amodal_beyond(0)
    assert 0.35 * whole[2] < inside[2] < 0.65 * whole[2]
    np.testing.assert_allclose(beyond, whole, atol=3)
