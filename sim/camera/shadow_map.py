"""The shadow map of a world's light: the same for all views of a pose, so drawn once."""

from __future__ import annotations

import ctypes
from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.errors import InfrastructureError
from sim.gl import REMEDY, functions, load_mujoco
from sim.scene.world import World

# MuJoCo's own: keeps a surface from shadowing itself, at the slope of the surface.
_OFFSET_FACTOR, _OFFSET_UNITS = -1.5, -4.0
# Filters, wrapping and comparison of a texture; the last two are of OpenGL 1.4, whose names we do
# not load.
_SETTINGS = (0x2800, 0x2801, 0x2802, 0x2803, 0x884C, 0x884D)
_BORDER_PX = 1  # stays empty, so that no shadow at the border goes on for ever


def update_scene(model: Any, data: Any, option: Any, camera: Any, scene: Any) -> None:
    """Fill an MjvScene: what can move first, as it hides much of the room, which need not be lit.

    MuJoCo draws in the order of the scene, and a hidden fragment costs little once it is hidden.
    """
    mujoco, kinds = load_mujoco(), load_mujoco().mjtCatBit
    mujoco.mjv_updateScene(model, data, option, None, camera, kinds.mjCAT_DYNAMIC, scene)
    mujoco.mjv_addGeoms(model, data, option, mujoco.MjvPerturb(), kinds.mjCAT_STATIC, scene)
    assert scene.status == 0, "geoms were dropped: MjvScene is too small"


class ShadowMap:
    """Draws the depth of what casts shadows, as a light sees it; belongs to its canvas.

    number: of the light among those that cast shadows; the first has MuJoCo's own map, the second
    one like it. texture: the map's, as OpenGL names it.
    """

    def __init__(
        self, world: World, context: Any, near_m: float, far_m: float, number: int
    ) -> None:
        mujoco = self._mujoco = load_mujoco()
        self._gl = functions()
        self._model, self._data, self._context = world.model, world.data, context
        self._near_m, self._far_m = near_m, far_m
        self._scene = mujoco.MjvScene(self._model, maxgeom=self._model.ngeom + 50)
        self._drawn: tuple[frozenset[int], NDArray[Any], NDArray[Any]] | None = None
        self._world_to_map: Floats | None = None
        self._number = number
        self.texture, self._frame_buffer = int(context.shadowTex), int(context.shadowFBO)
        if number:
            self.texture, self._frame_buffer = _another(self.texture, int(context.shadowSize))
        self._clear()

    def draw(self, option: Any, groups: Collection[int]) -> Floats | None:
        """Draw the shadows of these geom groups in the current pose, unless that is what is drawn.

        Returns world_to_map (4, 4): to coordinates 0-1 of the map, and depth that grows towards
        the light; None where no light casts shadows.
        """
        drawn = frozenset(groups), self._data.geom_xpos.copy(), self._data.geom_xmat.copy()
        if self._drawn is None or not _same(drawn, self._drawn):
            self._world_to_map = self._draw(option)
            self._drawn = drawn
        return self._world_to_map

    def close(self) -> None:
        """Free a map that is not MuJoCo's own."""
        if self._number:
            name = ctypes.c_uint(self._frame_buffer)
            self._gl.glDeleteFramebuffers(1, ctypes.byref(name))
            name = ctypes.c_uint(self.texture)
            self._gl.glDeleteTextures(1, ctypes.byref(name))

    def _clear(self) -> None:
        gl = self._gl
        gl.glBindFramebuffer(gl.GL_FRAMEBUFFER, self._frame_buffer)
        gl.glDrawBuffer(gl.GL_NONE)
        gl.glClearDepth(0.0)
        gl.glClear(gl.GL_DEPTH_BUFFER_BIT)
        self._mujoco.mjr_restoreBuffer(self._context)

    def _draw(self, option: Any) -> Floats | None:
        mujoco, scene, gl = self._mujoco, self._scene, self._gl
        update_scene(self._model, self._data, option, mujoco.MjvCamera(), scene)
        casting = [light for light in scene.lights[: scene.nlight] if light.castshadow]
        if len(casting) <= self._number:
            return None
        for geom in scene.geoms[: scene.ngeom]:
            if not geom.castshadow:
                geom.segid = -1  # is not drawn
        position, forward, up = _axes(casting[self._number])
        half = float(self._context.shadowClip)
        for eye in scene.camera:
            eye.pos, eye.forward, eye.up = position, forward, up
            eye.orthographic = 1
            eye.frustum_center, eye.frustum_width = 0.0, half
            eye.frustum_bottom, eye.frustum_top = -half, half
            eye.frustum_near, eye.frustum_far = self._near_m, self._far_m
        scene.flags[:] = 0
        scene.flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = 1  # depth is wanted, no light
        gl.glBindFramebuffer(gl.GL_FRAMEBUFFER, self._frame_buffer)
        gl.glEnable(gl.GL_POLYGON_OFFSET_FILL)
        gl.glPolygonOffset(_OFFSET_FACTOR, _OFFSET_UNITS)
        inside = int(self._context.shadowSize) - 2 * _BORDER_PX
        viewport = mujoco.MjrRect(_BORDER_PX, _BORDER_PX, inside, inside)
        mujoco.mjr_render(viewport, scene, self._context)
        gl.glDisable(gl.GL_POLYGON_OFFSET_FILL)
        return self._matrix(position, forward, up, half)

    def _matrix(self, position: Floats, forward: Floats, up: Floats, half_m: float) -> Floats:
        """World to map, as the map was drawn."""
        depth_m = self._far_m - self._near_m
        rows = np.stack([np.cross(forward, up), up, -forward])
        world_to_light = np.eye(4)
        world_to_light[:3, :3], world_to_light[:3, 3] = rows, -rows @ position
        inside = 1.0 - 2.0 * _BORDER_PX / float(self._context.shadowSize)
        light_to_map = np.diag([inside / (2 * half_m), inside / (2 * half_m), 1.0 / depth_m, 1.0])
        light_to_map[:3, 3] = 0.5, 0.5, self._far_m / depth_m
        return np.asarray(light_to_map @ world_to_light)


def _another(texture: int, size: int) -> tuple[int, int]:
    """A depth texture with the settings of another one, and a frame buffer that draws into it."""
    gl, target = functions(), functions().GL_TEXTURE_2D
    value, settings = ctypes.c_int(), {}
    gl.glBindTexture(target, texture)
    for name in _SETTINGS:
        gl.glGetTexParameteriv(target, name, ctypes.byref(value))
        settings[name] = value.value
    gl.glGetTexLevelParameteriv(target, 0, gl.GL_TEXTURE_INTERNAL_FORMAT, ctypes.byref(value))
    made, frame_buffer = ctypes.c_uint(), ctypes.c_uint()
    gl.glGenTextures(1, ctypes.byref(made))
    gl.glBindTexture(target, made.value)
    gl.glTexImage2D(target, 0, value.value, size, size, 0, gl.GL_DEPTH_COMPONENT, gl.GL_FLOAT, None)
    for name, setting in settings.items():
        gl.glTexParameteri(target, name, setting)
    gl.glBindTexture(target, 0)
    gl.glGenFramebuffers(1, ctypes.byref(frame_buffer))
    gl.glBindFramebuffer(gl.GL_FRAMEBUFFER, frame_buffer.value)
    gl.glFramebufferTexture2D(gl.GL_FRAMEBUFFER, gl.GL_DEPTH_ATTACHMENT, target, made.value, 0)
    gl.glDrawBuffer(gl.GL_NONE)
    gl.glReadBuffer(gl.GL_NONE)
    if gl.glCheckFramebufferStatus(gl.GL_FRAMEBUFFER) != gl.GL_FRAMEBUFFER_COMPLETE:
        raise InfrastructureError("the OpenGL driver has no second shadow map", REMEDY)
    return made.value, frame_buffer.value


def _axes(light: Any) -> tuple[Floats, Floats, Floats]:
    """Position, forward and up (3,) of a light, up as MuJoCo takes it."""
    forward = np.asarray(light.dir, dtype=np.float64)
    forward = forward / np.linalg.norm(forward)
    up = np.cross(forward, (-1.0, 0.0, 0.0))
    if up @ up <= 0.01:
        up = np.cross(forward, (0.0, 1.0, 0.0))
    return np.asarray(light.pos, dtype=np.float64), forward, up / np.linalg.norm(up)


def _same(
    one: tuple[frozenset[int], NDArray[Any], NDArray[Any]],
    other: tuple[frozenset[int], NDArray[Any], NDArray[Any]],
) -> bool:
    return one[0] == other[0] and all(map(np.array_equal, one[1:], other[1:]))
