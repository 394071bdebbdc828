"""MuJoCo's offscreen frame buffer: draws a world's colours, geom ids and depth."""

from __future__ import annotations

import threading
from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, Image
from pjpdaf.camera import Camera
from sim.camera.normal_shader import normal_shader
from sim.camera.shader import BoundMap, kinds_of, mark_textured, shader_of, soft_edge_m
from sim.camera.shadow_map import ShadowMap, update_scene
from sim.gl import context, load_mujoco
from sim.scene.world import World

Size = tuple[int, int]  # height, width [px]


class Canvas:
    """Draws a world in its current pose; pictures have OpenGL's order of rows, from below.

    Belongs to the thread that made it. groups: all geom groups. Raises InfrastructureError where
    there is no OpenGL.
    """

    def __init__(self, world: World) -> None:
        mujoco = self._mujoco = load_mujoco()
        context()
        self._model, self._data = world.model, world.data
        self._thread = threading.get_ident()
        self._shown: tuple[int, ...] = ()
        self._geoms_of: dict[tuple[int, ...], NDArray[np.int32]] = {}
        self._scene = mujoco.MjvScene(self._model, maxgeom=self._model.ngeom + 50)
        font = mujoco.mjtFontScale.mjFONTSCALE_100
        self._context: Any = mujoco.MjrContext(self._model, font)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self._option = mujoco.MjvOption()
        self._option.flags[:] = 0
        for flag in ("TEXTURE", "STATIC"):
            self._option.flags[getattr(mujoco.mjtVisFlag, f"mjVIS_{flag}")] = 1
        flags = mujoco.mjtRndFlag
        self._colour_flags = (flags.mjRND_CULL_FACE,)  # shadows are the shader's
        self._id_flags = (flags.mjRND_SEGMENT, flags.mjRND_IDCOLOR, flags.mjRND_CULL_FACE)
        visual, extent = self._model.vis, self._model.stat.extent
        self.near_m = float(np.float32(visual.map.znear * extent))
        self.far_m = float(np.float32(visual.map.zfar * extent))
        self.groups = range(len(self._option.geomgroup))
        mark_textured(self._model)
        casting = int(np.count_nonzero(self._model.light_castshadow & self._model.light_active))
        self._shadows = tuple(
            ShadowMap(world, self._context, self.near_m, self.far_m, number)
            for number in range(max(casting, 1))
        )

    def begin(self) -> None:
        """Make this frame buffer current. Raises ValueError where it is closed or another thread's.

        Another canvas of this process may have bound its own frame buffer since the last call.
        """
        if self._context is None:
            raise ValueError("this StereoRenderer is closed")
        if threading.get_ident() != self._thread:
            raise ValueError("a StereoRenderer belongs to the thread that made it")
        context()
        self._mujoco.mjr_setBuffer(self._mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)

    def close(self) -> None:
        """Free the GPU's copies of the model; safe to call twice."""
        if self._context is not None:
            context()
            for shadows in self._shadows:
                shadows.close()
            self._context.free()
            self._context = None

    def show(self, camera: str, groups: Collection[int]) -> None:
        """Draw next these geom groups, in the current pose, through a fixed camera of the model."""
        self._shown = tuple(groups)
        self._option.geomgroup[:] = [int(group in groups) for group in self.groups]
        fixed = self._mujoco.MjvCamera()
        fixed.type = self._mujoco.mjtCamera.mjCAMERA_FIXED
        fixed.fixedcamid = self._model.camera(camera).id
        update_scene(self._model, self._data, self._option, fixed, self._scene)

    def aim(self, camera: Camera) -> None:
        """Draw next through any pinhole, in place of the fixed camera of the last `show`.

        Raises ValueError for a camera with a lens, or larger than the frame buffer.
        """
        if np.any(camera.distortion):
            raise ValueError("only a camera without a lens can be drawn directly")
        width, height = camera.width_px, camera.height_px
        screen = self._model.vis.global_
        if height > screen.offheight or width > screen.offwidth:
            raise ValueError(f"a picture of {width} x {height} is larger than the frame buffer")
        (fx, cx), (fy, cy) = camera.K[0, [0, 2]], camera.K[1, [1, 2]]
        near = self.near_m
        for drawn in self._scene.camera:
            drawn.pos = camera.centre_w
            drawn.forward, drawn.up = camera.R_cw[2], -camera.R_cw[1]
            # The picture's border is half a pixel outside the centres of its first and last pixels.
            drawn.frustum_center = near * ((width - 1) / 2 - cx) / fx
            drawn.frustum_width = near * width / 2 / fx
            drawn.frustum_top = near * (cy + 0.5) / fy
            drawn.frustum_bottom = near * (cy + 0.5 - height) / fy

    def colour(self, size: Size) -> Image:
        """RGB (h, w, 3) with shadows."""
        rgb, _ = self._colour(size, with_depth=False)
        return rgb

    def colour_and_depth(self, size: Size) -> tuple[Image, NDArray[np.float32]]:
        """RGB (h, w, 3) and reversed depth (h, w), from one pass."""
        rgb, depth = self._colour(size, with_depth=True)
        assert depth is not None
        return rgb, depth

    def world_to_maps(self) -> tuple[Floats, ...]:
        """From the world to the shadow map (4, 4) of each light with shadows, of what is shown."""
        drawn = (shadows.draw(self._option, self._shown) for shadows in self._shadows)
        return tuple(matrix for matrix in drawn if matrix is not None)

    def shadow_edge_m(self) -> float:
        """Half the width [m] of the edges of the shadows in what is shown."""
        return max(map(soft_edge_m, self._scene.lights[: self._scene.nlight]), default=0.0)

    def ids(
        self, size: Size, with_depth: bool
    ) -> tuple[NDArray[np.int32], NDArray[np.float32] | None]:
        """Geom ids (h, w), -1 for nothing, and reversed depth (h, w) if wanted, from one pass."""
        rgb, depth = self._draw(size, self._id_flags, with_depth)
        scene_id = rgb[..., 0].astype(np.int32)
        if self._scene.ngeom > 254:
            scene_id |= rgb[..., 1].astype(np.int32) << 8
            scene_id |= rgb[..., 2].astype(np.int32) << 16
        return np.take(self._geom_of(), scene_id), depth

    def normals(self, size: Size) -> Image:
        """Encoded normals (h, w, 3) of `sim.camera.normals`; of no surface, MuJoCo's background."""
        shader = normal_shader()
        shader.use()
        try:
            return self._draw(size, self._colour_flags, with_depth=False)[0]
        finally:
            shader.leave()

    def metres(self, depth: NDArray[np.float32] | Floats) -> NDArray[np.float32]:
        """Reversed depth (1 at znear, 0 at zfar) to planar z, in double precision between."""
        near, far = self.near_m, self.far_m
        metres: NDArray[np.float32] = (
            near * far / (near + depth.astype(np.float64) * (far - near))
        ).astype(np.float32)
        return metres

    def _colour(self, size: Size, with_depth: bool) -> tuple[Image, NDArray[np.float32] | None]:
        world_to_maps = self.world_to_maps() or (np.eye(4),)  # of no light: it is not looked at
        eye_to_world = self._eye_to_world()
        maps = [
            BoundMap(world_to_map @ eye_to_world, shadows.texture)
            for world_to_map, shadows in zip(world_to_maps, self._shadows, strict=True)
        ]
        shader = shader_of(kinds_of(self._scene.lights[: self._scene.nlight]))
        shader.use(maps, self.shadow_edge_m())
        try:
            return self._draw(size, self._colour_flags, with_depth)
        finally:
            shader.leave()

    def _geom_of(self) -> NDArray[np.int32]:
        """Geom of each drawn id, first of nothing; the same whenever these groups are shown."""
        if self._shown not in self._geoms_of:
            geom_type = int(self._mujoco.mjtObj.mjOBJ_GEOM)
            geom_of = np.full(self._scene.ngeom + 1, -1, np.int32)
            for geom in self._scene.geoms[: self._scene.ngeom]:
                if geom.segid >= 0 and geom.objtype == geom_type:
                    geom_of[geom.segid + 1] = geom.objid
            self._geoms_of[self._shown] = geom_of
        return self._geoms_of[self._shown]

    def _eye_to_world(self) -> Floats:
        """From OpenGL's axes (4, 4) of the camera through which is drawn: x right, y up, z back."""
        left, right = self._scene.camera  # of two eyes, between which MuJoCo draws
        forward = np.asarray(left.forward, dtype=np.float64)
        across = np.cross(forward, left.up)
        axes = [v / np.linalg.norm(v) for v in (across, np.cross(across, forward), -forward)]
        matrix = np.eye(4)
        matrix[:3, :3] = np.column_stack(axes)
        matrix[:3, 3] = np.mean([left.pos, right.pos], axis=0, dtype=np.float64)
        return matrix

    def _draw(
        self, size: Size, flags: Collection[Any], with_depth: bool
    ) -> tuple[Image, NDArray[np.float32] | None]:
        return render_pass(self._scene, self._context, size, flags, with_depth)


def render_pass(
    scene: Any, context: Any, size: Size, flags: Collection[Any], with_depth: bool
) -> tuple[Image, NDArray[np.float32] | None]:
    """Render a pass and read it back: RGB (h, w, 3) and depth (h, w) if wanted, rows from below.

    scene: MjvScene; context: MjrContext, whose frame buffer is current; flags: of mjtRndFlag that
    are set, all others are not.
    """
    mujoco = load_mujoco()
    scene.flags[:] = 0
    for flag in flags:
        scene.flags[flag] = 1
    viewport = mujoco.MjrRect(0, 0, size[1], size[0])
    mujoco.mjr_render(viewport, scene, context)
    rgb = np.empty((*size, 3), np.uint8)
    depth = np.empty(size, np.float32) if with_depth else None
    mujoco.mjr_readPixels(rgb, depth, viewport, context)
    return rgb, depth
