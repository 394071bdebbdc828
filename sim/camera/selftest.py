"""Start-up self-test: a sphere must appear where the camera says, or nothing is rendered at all.

Versions of MuJoCo have differed in the sign of the principal point, and drivers in worse.
"""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, StereoRig
from pjpdaf.errors import InfrastructureError
from sim.camera.render import StereoRenderer
from sim.gl import load_mujoco
from sim.scene.rig import turn_x, turn_y
from sim.scene.world import compiled

TOLERANCE_PX = 0.3
SIZE_PX = (160, 120)
RADIUS_M = 0.08
CENTRE_W = np.array([0.17, -0.12, 0.25])

_passed = False


def ellipse_centre(camera: Camera, centre_w: Floats, radius_m: float) -> Floats:
    """Centre (2,) [px] of the ellipse that a sphere projects to (dual conic).

    It differs from the projected centre by up to a third of a pixel: that is perspective.
    """
    c = camera.R_cw @ centre_w + camera.t_cw
    dual = camera.K @ (np.outer(c, c) - radius_m**2 * np.eye(3)) @ camera.K.T
    return np.asarray(dual[:2, 2] / dual[2, 2])


def turned_rig() -> StereoRig:
    """Two turned cameras with off-centre principal points and fx != fy, 1.2 m before the sphere."""
    width, height = SIZE_PX
    cameras = []
    for side in (-1.0, 1.0):
        K = np.array([[150.0, 0, 79.5 + side * 23.25], [0, 141.0, 59.5 - 17.5], [0, 0, 1.0]])
        R_cw = turn_x(0.1) @ turn_y(0.12 * side) @ np.diag([1.0, -1.0, -1.0])
        centre_w = np.array([0.06 * side, 0.0, 1.4])
        cameras.append(Camera(K, R_cw, -R_cw @ centre_w, width, height))
    return StereoRig(cameras[0], cameras[1])


def offsets_px(rig: StereoRig) -> Floats:
    """Rendered minus expected centre of the sphere per view (2, 2) [px]; NaN where not seen."""
    mujoco = load_mujoco()
    spec = mujoco.MjSpec()
    spec.visual.quality.numslices, spec.visual.quality.numstacks = 48, 32
    sphere = mujoco.mjtGeom.mjGEOM_SPHERE
    spec.worldbody.add_geom(type=sphere, size=[RADIUS_M, 0, 0], pos=CENTRE_W.tolist())
    world = compiled(spec, rig)
    offsets = []
    with StereoRenderer(world) as renderer:
        for camera, view in zip(
            rig.cameras, renderer.render(colour=False, amodal=False), strict=True
        ):
            assert view.geoms is not None
            ys, xs = np.nonzero(view.geoms == 0)
            expected = ellipse_centre(camera, CENTRE_W, RADIUS_M)
            centre = np.array([xs.mean(), ys.mean()]) if len(xs) else np.full(2, np.nan)
            offsets.append(centre - expected)
    return np.array(offsets)


def check() -> None:
    """Render the sphere in both views.

    Raises InfrastructureError where it is more than TOLERANCE_PX from where the cameras say, or
    where there is no OpenGL.
    """
    offsets = offsets_px(turned_rig())
    worst = float(np.max(np.abs(offsets)))
    if not worst <= TOLERANCE_PX:  # NaN fails as well
        raise InfrastructureError(
            f"the renderer's self-test failed: a sphere is {worst:.2f} px from where the camera "
            f"says (at most {TOLERANCE_PX}); "
            "install the version of mujoco that requirements.lock names"
        )


def check_once() -> None:
    """`check`, the first time in this process only."""
    global _passed
    if not _passed:
        check()
        _passed = True
