"""Surface normals against MuJoCo's rays and the normals of the meshes' vertices."""

from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.camera import undistort_points
from sim.camera.normals import NONE, decoded, encoded
from sim.camera.rays import cast, cast_normals
from sim.camera.render import StereoRenderer
from sim.person.rest import rest_pose
from sim.scene.world import build
from sim.specs import RigSpec, SceneSpec

SCENE = SceneSpec(rig=RigSpec(tilt_rad=0.28, width_px=320, height_px=240, focal_px=270.0))
BOUND_DEG = 0.4  # of a byte a component


@pytest.fixture(scope="module", params=[(), (-0.2, 0.05, 0.001, -0.0008)], ids=["pinhole", "lens"])
def view(request):
    """World in a pose, geoms and decoded normals of its left view."""
    world = build(replace(SCENE, rig=replace(SCENE.rig, distortion=request.param)))
    world.place(rest_pose(SCENE.anatomy, curl=0.5))
    with StereoRenderer(world) as renderer:
        drawn = renderer.view(0, colour=False, amodal=False)
        picture = renderer.normals(0, drawn.geoms)
    return world, drawn.geoms, picture


def angle_deg(a, b):
    cosine = (a * b).sum(axis=-1) / np.linalg.norm(a, axis=-1) / np.linalg.norm(b, axis=-1)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def grid(geoms, step=3):
    ys, xs = np.mgrid[1 : geoms.shape[0] : step, 1 : geoms.shape[1] : step]
    return ys.ravel(), xs.ravel()


def test_a_byte_a_component_is_less_than_the_bound_off():
    normals = np.random.default_rng(5).normal(size=(2000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    back = decoded(encoded(normals)[None])[0]
    assert angle_deg(normals, back).max() < BOUND_DEG
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    np.testing.assert_array_equal(decoded(encoded(axes)[None])[0], axes)
    assert np.isnan(decoded(np.full((1, 1, 3), NONE, np.uint8))).all()


def test_flat_surfaces_have_the_normals_that_rays_meet(view):
    world, geoms, picture = view
    ys, xs = grid(geoms)
    met, _, normals = cast_normals(world, world.rig.left, np.column_stack([xs, ys]))
    flat = (met == geoms[ys, xs]) & np.isin(world.model.geom_type[met], [0, 6])  # plane, box
    off = angle_deg(decoded(picture)[ys, xs], normals)[flat]
    print("flat:", len(off), np.percentile(off, [50, 99, 100]))
    assert flat.sum() > 3000
    assert np.median(off) < BOUND_DEG
    # Through a lens, a pixel at the edge of a box may be the mean of two of its sides.
    assert (off < BOUND_DEG).mean() > 0.99
    if not world.lenses[0]:
        assert off.max() < BOUND_DEG


def vertex_normals_at(world, geom, point_w):
    """The normals of a mesh's vertices, interpolated where a point lies on a triangle (n, 3)."""
    model, data = world.model, world.data
    mesh = model.geom_dataid[geom]
    xmat, xpos = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    normals = model.mesh_normal[model.mesh_normaladr[mesh] :][: model.mesh_normalnum[mesh]]
    first = model.mesh_faceadr[mesh]
    faces = model.mesh_face[first : first + model.mesh_facenum[mesh]]
    face_normals = model.mesh_facenormal[first : first + model.mesh_facenum[mesh]]
    p = (point_w - xpos) @ xmat
    a, b, c = (vertices[faces[:, i]].astype(float) for i in range(3))
    across = np.cross(b - a, c - a)
    area = (across**2).sum(axis=1)
    area[area == 0] = np.nan
    u = (np.cross(b - a, p - a) * across).sum(axis=1) / area  # weight of c
    v = (np.cross(p - a, c - a) * across).sum(axis=1) / area  # weight of b
    away = np.abs(((p - a) * across).sum(axis=1)) / np.sqrt(area)
    on = (u > -1e-3) & (v > -1e-3) & (u + v < 1 + 1e-3) & (away < 1e-5)
    if not on.any():
        return None
    k = int(np.nanargmin(np.where(on, away, np.nan)))
    weights = np.array([1 - u[k] - v[k], v[k], u[k]])
    return xmat @ (weights @ normals[face_normals[k]].astype(float))


def test_bent_surfaces_have_the_normals_between_their_vertices(view):
    """Interpolated by hand where a ray meets a triangle: no raster, no shader."""
    world, geoms, picture = view
    camera = world.rig.left
    ys, xs = (v[::2] for v in grid(geoms))
    met, depth_m = cast(world, camera, np.column_stack([xs, ys]))
    person = (met == geoms[ys, xs]) & (world.model.geom_group[met] > 0)
    ideal = undistort_points(camera, np.column_stack([xs, ys]).astype(float))
    rays = np.column_stack([ideal, np.ones(len(ideal))]) @ np.linalg.inv(camera.K).T
    points_w = (rays * depth_m[:, None] - camera.t_cw) @ camera.R_cw
    off = []
    for k in np.flatnonzero(person):
        expected = vertex_normals_at(world, int(met[k]), points_w[k])
        if expected is not None:
            own = decoded(picture[ys[k], xs[k]][None, None])[0, 0]
            off.append(angle_deg(own, camera.R_cw @ expected))
    print("bent:", len(off), np.percentile(off, [50, 95, 100]))
    assert len(off) > 300
    assert np.median(off) < BOUND_DEG
    assert np.mean(np.array(off) < 3 * BOUND_DEG) > (0.9 if world.lenses[0] else 0.97)


def test_where_nothing_is_there_is_no_normal(view):
    _, geoms, picture = view
    known = np.isfinite(decoded(picture)).all(axis=-1)
    np.testing.assert_array_equal(known, geoms >= 0)


def test_surfaces_face_the_camera(view):
    world, geoms, picture = view
    ys, xs = grid(geoms)
    rays = np.column_stack([xs, ys, np.ones(len(xs))]) @ np.linalg.inv(world.rig.left.K).T
    facing = (decoded(picture)[ys, xs] * rays).sum(axis=1)
    assert np.nanmean(facing < 0.05) > 0.99
