"""Colour, depth and ids of both views, low level and repeatable to the bit."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from types import TracebackType
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.targets import TARGETS
from sim.gl import context, load_mujoco
from sim.lens import Lens
from sim.world import CAMERAS, SUPERSAMPLE, World


@dataclass(frozen=True, eq=False)
class ViewRender:
    """What one camera sees, without the sensor's noise. Parts that were not asked for are None.

    colour (h, w, 3) uint8 BGR, supersampled. depth_m (h, w) float32 planar z, geoms (h, w) int32
    geom ids with -1 for nothing, targets (h, w) int8 with -1 for none: all three sampled at the
    pixel centres in one pass without antialiasing. amodal_px (T,): the targets' skin pixels with
    all other things removed; its own hair and collar or cuff still hide a target's skin, so that a
    free head or hand counts as whole.
    """

    colour: NDArray[np.uint8] | None
    depth_m: NDArray[np.float32] | None
    geoms: NDArray[np.int32] | None
    targets: NDArray[np.int8] | None
    amodal_px: NDArray[np.int64] | None


class StereoRenderer:
    """Renders a world's two views. Belongs to the thread that made it; close it, or use `with`.

    Raises InfrastructureError where there is no OpenGL.
    """

    def __init__(self, world: World) -> None:
        self._mujoco = load_mujoco()
        context()
        self.world = world
        self._thread = threading.get_ident()
        self._scene = self._mujoco.MjvScene(world.model, maxgeom=world.model.ngeom + 50)
        font = self._mujoco.mjtFontScale.mjFONTSCALE_100
        self._context: Any = self._mujoco.MjrContext(world.model, font)
        self._context.readDepthMap = self._mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self._cameras = [self._fixed_camera(name) for name in CAMERAS]
        self._option = self._mujoco.MjvOption()
        self._option.flags[:] = 0
        for flag in ("TEXTURE", "STATIC"):
            self._option.flags[getattr(self._mujoco.mjtVisFlag, f"mjVIS_{flag}")] = 1
        flags = self._mujoco.mjtRndFlag
        self._colour_flags = {flags.mjRND_SHADOW: 1, flags.mjRND_CULL_FACE: 1}
        self._id_flags = {flags.mjRND_SEGMENT: 1, flags.mjRND_IDCOLOR: 1, flags.mjRND_CULL_FACE: 1}
        self._groups = range(len(self._option.geomgroup))

    def render(
        self, colour: bool = True, labels: bool = True, amodal: bool = True, person: bool = True
    ) -> tuple[ViewRender, ViewRender]:
        """Both views of the world's current pose; `person=False` hides the person alone."""
        left, right = (
            self.view(index, colour, labels, amodal, person) for index in range(len(CAMERAS))
        )
        return left, right

    def view(
        self,
        index: int,
        colour: bool = True,
        labels: bool = True,
        amodal: bool = True,
        person: bool = True,
    ) -> ViewRender:
        """One view of the world's current pose: 0 left, 1 right."""
        shown = [g for g in self._groups if person or g not in self.world.person_groups]
        self._begin()
        camera, pinhole = self._cameras[index], self.world.rig.cameras[index]
        frame = _Frame(camera, (pinhole.height_px, pinhole.width_px), self.world.lenses[index])
        self._update(camera, shown)
        picture = self._colour(frame) if colour else None
        depth, geoms, targets = self._labels(frame) if labels else (None, None, None)
        counts = self._amodal(frame) if amodal else None
        return ViewRender(picture, depth, geoms, targets, counts)

    def close(self) -> None:
        """Free the GPU's copies of the model; safe to call twice."""
        if self._context is not None:
            context()
            self._context.free()
            self._context = None

    def __enter__(self) -> StereoRenderer:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _fixed_camera(self, name: str) -> Any:
        camera = self._mujoco.MjvCamera()
        camera.type = self._mujoco.mjtCamera.mjCAMERA_FIXED
        camera.fixedcamid = self.world.model.camera(name).id
        return camera

    def _begin(self) -> None:
        if self._context is None:
            raise ValueError("this StereoRenderer is closed")
        if threading.get_ident() != self._thread:
            raise ValueError("a StereoRenderer belongs to the thread that made it")
        context()
        # Another renderer of this process may have bound its own frame buffer since.
        self._mujoco.mjr_setBuffer(self._mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)

    def _update(self, camera: Any, groups: Any) -> None:
        self._option.geomgroup[:] = [int(g in groups) for g in self._groups]
        category = self._mujoco.mjtCatBit.mjCAT_ALL
        model, data = self.world.model, self.world.data
        self._mujoco.mjv_updateScene(model, data, self._option, None, camera, category, self._scene)
        assert self._scene.status == 0, "geoms were dropped: MjvScene is too small"

    def _draw(self, size: tuple[int, int], flags: dict[Any, int]) -> Any:
        self._scene.flags[:] = 0
        for flag, value in flags.items():
            self._scene.flags[flag] = value
        viewport = self._mujoco.MjrRect(0, 0, size[1], size[0])
        self._mujoco.mjr_render(viewport, self._scene, self._context)
        return viewport

    def _colour(self, frame: _Frame) -> NDArray[np.uint8]:
        large = frame.drawn(SUPERSAMPLE)
        viewport = self._draw(large, self._colour_flags)
        rgb = np.empty((*large, 3), np.uint8)
        self._mujoco.mjr_readPixels(rgb, None, viewport, self._context)
        if frame.lens is None:
            small = cv2.resize(rgb, frame.size[::-1], interpolation=cv2.INTER_AREA)[::-1]
        else:
            warped = frame.lens.colour(np.ascontiguousarray(rgb[::-1]))
            small = cv2.resize(warped, frame.size[::-1], interpolation=cv2.INTER_AREA)
        return np.ascontiguousarray(small[..., ::-1])

    def _ids(
        self, frame: _Frame, with_depth: bool
    ) -> tuple[NDArray[np.int32], NDArray[np.float32] | None]:
        """Geom ids and, if asked for, raw depth at the pixel centres, from one pass."""
        size = frame.drawn(1) if frame.lens is None else frame.drawn(SUPERSAMPLE)
        viewport = self._draw(size, self._id_flags)
        rgb = np.empty((*size, 3), np.uint8)
        raw = np.empty(size, np.float32) if with_depth else None
        self._mujoco.mjr_readPixels(rgb, raw, viewport, self._context)
        if frame.lens is None:
            rgb, raw = rgb[::-1], None if raw is None else raw[::-1]
        else:
            rgb, raw = frame.lens.labels(rgb), None if raw is None else frame.lens.labels(raw)
        scene_id = rgb[..., 0].astype(np.int32)
        if self._scene.ngeom > 254:
            scene_id |= rgb[..., 1].astype(np.int32) << 8
            scene_id |= rgb[..., 2].astype(np.int32) << 16
        geom_type = int(self._mujoco.mjtObj.mjOBJ_GEOM)
        geom_of = np.full(self._scene.ngeom + 1, -1, np.int32)
        for geom in self._scene.geoms[: self._scene.ngeom]:
            if geom.segid >= 0 and geom.objtype == geom_type:
                geom_of[geom.segid + 1] = geom.objid
        return np.take(geom_of, scene_id), raw

    def _labels(
        self, frame: _Frame
    ) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.int8]]:
        geoms, raw = self._ids(frame, with_depth=True)
        assert raw is not None
        # -1 wraps to the last entry, which is "no target".
        targets = np.take(np.append(self.world.targets, np.int8(-1)), geoms)
        return self._metres(raw), geoms, targets

    def _metres(self, raw: NDArray[np.float32]) -> NDArray[np.float32]:
        """Reversed depth (1 at znear, 0 at zfar) to planar z, in double precision between."""
        model = self.world.model
        near = float(np.float32(model.vis.map.znear * model.stat.extent))
        far = float(np.float32(model.vis.map.zfar * model.stat.extent))
        metres: NDArray[np.float32] = (
            near * far / (near + raw.astype(np.float64) * (far - near))
        ).astype(np.float32)
        return metres

    def _amodal(self, frame: _Frame) -> NDArray[np.int64]:
        counts = np.zeros(len(TARGETS), np.int64)
        for target, group in enumerate(self.world.amodal_groups):
            self._update(frame.camera, (group,))
            geoms, _ = self._ids(frame, with_depth=False)
            shown = np.bincount(geoms.ravel() + 1, minlength=self.world.model.ngeom + 1)[1:]
            counts[target] = shown[self.world.targets == target].sum()
        return counts


@dataclass(frozen=True, eq=False)
class _Frame:
    """MuJoCo's camera, the real picture's (height, width), the lens in between."""

    camera: Any
    size: tuple[int, int]
    lens: Lens | None

    def drawn(self, scale: int) -> tuple[int, int]:
        """Height and width of what is drawn for it."""
        if self.lens is None:
            return scale * self.size[0], scale * self.size[1]
        return scale * self.lens.ideal.height_px, scale * self.lens.ideal.width_px
