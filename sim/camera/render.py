"""Colour, depth and ids of both views, low level and repeatable to the bit."""

from __future__ import annotations

import threading
from collections.abc import Iterable
from dataclasses import dataclass, replace
from types import TracebackType
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.targets import TARGETS
from sim.camera.rays import cast
from sim.gl import context, load_mujoco
from sim.lens import Lens
from sim.scene.world import CAMERAS, SUPERSAMPLE, World

NO_LENS = np.zeros(0)
BEND_PER_M = 3e-4  # of 1/z: 0.5 mm at 1.3 m; where surfaces bend more, rays are cast


@dataclass(frozen=True, eq=False)
class ViewRender:
    """What one camera sees, without the sensor's noise. Parts that were not asked for are None.

    colour (h, w, 3) uint8 BGR, supersampled. depth_m (h, w) float32 planar z, geoms (h, w) int32
    geom ids with -1 for nothing, targets (h, w) int8 with -1 for none: all three sampled at the
    pixel centres in one pass without antialiasing. amodal (T, h, w) bool: the targets' skin with
    all other things removed; its own hair and collar or cuff still hide a target's skin, so that a
    free head or hand counts as whole.
    """

    colour: NDArray[np.uint8] | None
    depth_m: NDArray[np.float32] | None
    geoms: NDArray[np.int32] | None
    targets: NDArray[np.int8] | None
    amodal: NDArray[np.bool_] | None

    @property
    def amodal_px(self) -> NDArray[np.int64] | None:
        """Pixels of each amodal mask (T,)."""
        return None if self.amodal is None else np.count_nonzero(self.amodal, axis=(1, 2))


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
        model = world.model
        self._near_m = float(np.float32(model.vis.map.znear * model.stat.extent))
        self._far_m = float(np.float32(model.vis.map.zfar * model.stat.extent))
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
        size = pinhole.height_px, pinhole.width_px
        frame = _Frame(camera, pinhole, size, self.world.lenses[index])
        self._update(camera, shown)
        picture = self._colour(frame) if colour else None
        depth, geoms, targets = self._labels(frame, shown) if labels else (None, None, None)
        masks = self._amodal(frame) if amodal else None
        return ViewRender(picture, depth, geoms, targets, masks)

    def pinhole(self, camera: Camera) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """Depth (h, w) [m] and geom ids (h, w) as any ideal camera would see the current pose.

        Raises ValueError for one with a lens, or larger than SUPERSAMPLE times the world's own.
        """
        self._begin()
        self._update(self._cameras[0], self._groups)
        frame = self._through(camera)
        geoms, depth = self._ids(frame, self._groups, with_depth=True)
        assert depth is not None
        return depth, geoms

    def amodal_beyond(self, index: int) -> NDArray[np.int64]:
        """Pixels (T,) of the targets' amodal masks, with those beyond the picture's border.

        Of a picture twice as wide and high, the view in its middle; what is farther out is not
        counted. The pixels are those of the view (of its ideal pinhole, where it has a lens).
        """
        self._begin()
        lens = self.world.lenses[index]
        camera = lens.ideal if lens else self.world.rig.cameras[index]
        K = np.array(camera.K)
        width, height = camera.width_px, camera.height_px
        K[:2, 2] += width // 2, height // 2
        wide = replace(camera, K=K, width_px=2 * width, height_px=2 * height, distortion=NO_LENS)
        counts = np.zeros(len(TARGETS), np.int64)
        for target, group in enumerate(self.world.amodal_groups):
            self._update(self._cameras[index], (group,))
            geoms, _ = self._ids(self._through(wide), (group,), with_depth=False)
            counts[target] = np.count_nonzero(self._shows(target)[geoms])
        return counts

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
        self, frame: _Frame, groups: Iterable[int], with_depth: bool
    ) -> tuple[NDArray[np.int32], NDArray[np.float32] | None]:
        """Geom ids and, if asked for, depth [m] at the pixel centres, from one pass.

        Through a lens, where drawn pixels and pixel centres are not the same, edges are settled by
        rays: no id is mixed or off by a part of a pixel.
        """
        size = frame.drawn(1) if frame.lens is None else frame.drawn(SUPERSAMPLE)
        viewport = self._draw(size, self._id_flags)
        rgb = np.empty((*size, 3), np.uint8)
        raw = np.empty(size, np.float32) if with_depth else None
        self._mujoco.mjr_readPixels(rgb, raw, viewport, self._context)
        if frame.lens is None:
            geoms = self._geoms(rgb[::-1])
            return geoms, None if raw is None else self._metres(raw[::-1])
        geoms, sure = frame.lens.ids(self._geoms(rgb))
        depth = None
        if raw is not None:
            mixed, even = frame.lens.inverse_depth(raw, BEND_PER_M * self._near_m)
            depth, sure = self._metres(mixed), sure & even
        ys, xs = np.nonzero(~sure)
        hit, hit_m = cast(self.world, frame.camera, np.column_stack([xs, ys]), groups)
        geoms[ys, xs] = hit
        if depth is not None:
            depth[ys, xs] = np.where(hit < 0, self._far_m, hit_m)
        return geoms, depth

    def _geoms(self, rgb: NDArray[np.uint8]) -> NDArray[np.int32]:
        scene_id = rgb[..., 0].astype(np.int32)
        if self._scene.ngeom > 254:
            scene_id |= rgb[..., 1].astype(np.int32) << 8
            scene_id |= rgb[..., 2].astype(np.int32) << 16
        geom_type = int(self._mujoco.mjtObj.mjOBJ_GEOM)
        geom_of = np.full(self._scene.ngeom + 1, -1, np.int32)
        for geom in self._scene.geoms[: self._scene.ngeom]:
            if geom.segid >= 0 and geom.objtype == geom_type:
                geom_of[geom.segid + 1] = geom.objid
        return np.take(geom_of, scene_id)

    def _labels(
        self, frame: _Frame, groups: Iterable[int]
    ) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.int8]]:
        geoms, depth = self._ids(frame, groups, with_depth=True)
        assert depth is not None
        # -1 wraps to the last entry, which is "no target".
        targets = np.take(np.append(self.world.targets, np.int8(-1)), geoms)
        return depth, geoms, targets

    def _metres(self, raw: NDArray[np.float32] | Floats) -> NDArray[np.float32]:
        """Reversed depth (1 at znear, 0 at zfar) to planar z, in double precision between."""
        near, far = self._near_m, self._far_m
        metres: NDArray[np.float32] = (
            near * far / (near + raw.astype(np.float64) * (far - near))
        ).astype(np.float32)
        return metres

    def _amodal(self, frame: _Frame) -> NDArray[np.bool_]:
        masks = np.zeros((len(TARGETS), *frame.size), bool)
        for target, group in enumerate(self.world.amodal_groups):
            self._update(frame.fixed, (group,))
            geoms, _ = self._ids(frame, (group,), with_depth=False)
            masks[target] = self._shows(target)[geoms]
        return masks

    def _shows(self, target: int) -> NDArray[np.bool_]:
        """Per geom id whether it is the target's skin; the last is for -1, nothing."""
        return np.append(self.world.targets == target, False)

    def _through(self, camera: Camera) -> _Frame:
        """Draw next through any pinhole, in place of the fixed camera of the last `_update`."""
        if np.any(camera.distortion):
            raise ValueError("only a camera without a lens can be drawn directly")
        size = camera.height_px, camera.width_px
        screen = self.world.model.vis.global_
        if size[0] > screen.offheight or size[1] > screen.offwidth:
            raise ValueError(f"a picture of {size[1]} x {size[0]} is larger than the frame buffer")
        (fx, cx), (fy, cy) = camera.K[0, [0, 2]], camera.K[1, [1, 2]]
        near = self._near_m
        for drawn in self._scene.camera:
            drawn.pos = camera.centre_w
            drawn.forward, drawn.up = camera.R_cw[2], -camera.R_cw[1]
            # The picture's border is half a pixel outside the centres of its first and last pixels.
            drawn.frustum_center = near * ((camera.width_px - 1) / 2 - cx) / fx
            drawn.frustum_width = near * camera.width_px / 2 / fx
            drawn.frustum_top = near * (cy + 0.5) / fy
            drawn.frustum_bottom = near * (cy + 0.5 - camera.height_px) / fy
        return _Frame(None, camera, size, None)


@dataclass(frozen=True, eq=False)
class _Frame:
    """MuJoCo's camera, the camera that it stands for, its picture's (height, width), its lens."""

    fixed: Any
    camera: Camera
    size: tuple[int, int]
    lens: Lens | None

    def drawn(self, scale: int) -> tuple[int, int]:
        """Height and width of what is drawn for it."""
        if self.lens is None:
            return scale * self.size[0], scale * self.size[1]
        return scale * self.lens.ideal.height_px, scale * self.lens.ideal.width_px
