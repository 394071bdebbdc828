import numpy as np
import pytest

from sim.camera.boxes import PIECE_M, GeomBoxes
from sim.gl import load_mujoco
from sim.person.rest import rest_pose
from sim.scene.world import build
from sim.specs import ObjectSpec, RoomSpec, SceneSpec

PICTURE = ObjectSpec("picture", "picture", (0.02, 0.4, 0.3), (0.4, 0.3, 0.2), (0.5, 0.2))
SCENE = SceneSpec(room=RoomSpec(objects=(PICTURE,)))


@pytest.fixture(scope="module")
def world():
    world = build(SCENE)
    world.place(rest_pose(SCENE.anatomy))
    return world


def test_boxes_hold_every_triangle_of_every_mesh(world):
    model, data = world.model, world.data
    boxes = GeomBoxes(model)
    rng = np.random.default_rng(0)
    meshes = np.flatnonzero(model.geom_type == int(load_mujoco().mjtGeom.mjGEOM_MESH))
    assert len(meshes) > 60
    for geom in meshes:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
        start = model.mesh_vertadr[mesh]
        triangles = model.mesh_vert[start:][model.mesh_face[first : first + count]]
        points = rng.dirichlet(np.ones(3), size=count)[:, None] @ triangles
        points_w = points[:, 0] @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
        one = np.arange(model.ngeom) == geom
        inside = np.zeros(count, bool)
        for corners in boxes.corners(data, one):
            edges = corners[[4, 2, 1]] - corners[0]
            along = (points_w - corners[0]) @ edges.T / (edges**2).sum(axis=1)
            inside |= ((along > -1e-4) & (along < 1 + 1e-4)).all(axis=1)
        assert inside.all(), model.geom(geom).name


def test_long_meshes_have_several_boxes_and_planes_flat_ones(world):
    boxes = GeomBoxes(world.model)
    counts = np.bincount(boxes.geoms, minlength=world.model.ngeom)
    assert counts.min() == 1
    long = np.flatnonzero(counts > 1)
    assert {"torso", "upper_arm:left"} <= {world.model.geom(g).name for g in long}
    assert (2 * world.model.geom_aabb[long, 3:].max(axis=1) > PIECE_M).all()
    plane = world.model.geom("table:top").id
    (corners,) = boxes.corners(world.data, np.arange(world.model.ngeom) == plane)
    room = SCENE.room
    assert np.ptp(corners, axis=0) == pytest.approx(
        [room.table_depth_m, room.table_width_m, 0.0], abs=1e-6
    )
