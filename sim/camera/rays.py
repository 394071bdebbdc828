"""Rays cast into a scene: geom and depth at a pixel, without drawing."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, undistort_points
from sim.gl import load_mujoco
from sim.scene.world import World

GROUPS = 6  # of geoms, in MuJoCo


def cast(
    world: World, camera: Camera, pixels: Floats, groups: Iterable[int] = range(GROUPS)
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Geom ids (n,), -1 for nothing, and planar depths (n,) [m], NaN for nothing, at n pixels.

    pixels (n, 2): of the camera's real picture, anywhere in a pixel; groups: of the geoms that rays
    can hit. By MuJoCo's `mj_multiRay`, which has no raster: shapes and meshes are hit exactly.
    """
    return _cast(world, camera, pixels, groups, None)


def cast_normals(
    world: World, camera: Camera, pixels: Floats, groups: Iterable[int] = range(GROUPS)
) -> tuple[NDArray[np.int32], NDArray[np.float32], Floats]:
    """As `cast`, and the normals (n, 3) of what is met, of a mesh its triangle's, in the camera's
    frame.
    """
    normals_w = np.zeros((len(pixels), 3))
    geoms, depth = _cast(world, camera, pixels, groups, normals_w)
    return geoms, depth, np.asarray(normals_w @ camera.R_cw.T)


def _cast(
    world: World, camera: Camera, pixels: Floats, groups: Iterable[int], normals_w: Floats | None
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """As `cast`; the normals are written into normals_w (n, 3), world."""
    mujoco = load_mujoco()
    ideal = undistort_points(camera, pixels)
    n = len(ideal)
    inside = np.column_stack([ideal, np.ones(n)]) @ np.linalg.inv(camera.K).T
    length = np.linalg.norm(inside, axis=1)
    directions = (inside / length[:, None]) @ camera.R_cw
    geoms, distance = np.full(n, -1, np.int32), np.full(n, -1.0)
    shown = np.array([group in set(groups) for group in range(GROUPS)], np.uint8)
    mujoco.mj_multiRay(
        world.model,
        world.data,
        camera.centre_w,
        directions.ravel(),
        shown,
        True,
        -1,
        geoms,
        distance,
        None if normals_w is None else normals_w.reshape(-1),
        n,
        mujoco.mjMAXVAL,
    )
    depth = np.where(geoms >= 0, distance / length, np.nan)
    return geoms, depth.astype(np.float32)
