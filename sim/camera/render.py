"""Colour, depth and ids of both views, repeatable to the bit."""

from __future__ import annotations

from collections.abc import Collection
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Image
from pjpdaf.camera import Camera
from pjpdaf.targets import TARGETS
from sim.camera.canvas import Canvas, Size
from sim.camera.rays import cast
from sim.lens import Lens
from sim.scene.world import CAMERAS, SUPERSAMPLE, World

NO_LENS = np.zeros(0)
BEND_PER_M = 3e-4  # of 1/z: 0.5 mm at 1.3 m; where surfaces bend more, rays are cast


@dataclass(frozen=True, eq=False)
class ViewRender:
    """A view without the sensor's effects; arrays that were not asked for are None.

    colour (h, w, 3) uint8 BGR, supersampled. depth_m (h, w) float32 planar z, geoms (h, w) int32
    geom ids with -1 for nothing, targets (h, w) int8 with -1 for no target: all three sampled at
    the pixel centres in one pass without antialiasing. amodal (T, h, w) bool: the targets' skin
    with everything else removed; a target's own hair and collar or cuff still hide its skin, so
    that a free head or hand counts as whole.
    """

    colour: Image | None
    depth_m: NDArray[np.float32] | None
    geoms: NDArray[np.int32] | None
    targets: NDArray[np.int8] | None
    amodal: NDArray[np.bool_] | None

    @property
    def amodal_px(self) -> NDArray[np.int64] | None:
        """Pixels of each amodal mask (T,)."""
        return None if self.amodal is None else np.count_nonzero(self.amodal, axis=(1, 2))


class StereoRenderer(AbstractContextManager["StereoRenderer"]):
    """Renders a world's two views. Belongs to the thread that made it; close it, or use `with`.

    Raises InfrastructureError where there is no OpenGL.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self._canvas = Canvas(world)

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the GPU's copies of the model; safe to call twice."""
        self._canvas.close()

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
        world, hidden = self.world, () if person else self.world.person_groups
        groups = [group for group in self._canvas.groups if group not in hidden]
        output = _Output(world.rig.cameras[index], world.lenses[index])
        self._canvas.begin()
        self._canvas.show(CAMERAS[index], groups)
        picture = self._colour(output) if colour else None
        depth = geoms = targets = masks = None
        if labels:
            geoms, depth = self._ids(output, groups, with_depth=True)
            # -1 wraps to the last entry, which is "no target".
            targets = np.take(np.append(world.targets, np.int8(-1)), geoms)
        if amodal:
            masks = np.zeros((len(TARGETS), *output.size), bool)
            for number, group in enumerate(world.amodal_groups):
                self._canvas.show(CAMERAS[index], (group,))
                masks[number] = self._skin(output, number, group)
        return ViewRender(picture, depth, geoms, targets, masks)

    def pinhole(self, camera: Camera) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """Depth (h, w) [m] and geom ids (h, w) as any ideal camera would see the current pose.

        Raises ValueError for a camera with a lens, or larger than SUPERSAMPLE times the world's.
        """
        self._canvas.begin()
        self._canvas.show(CAMERAS[0], self._canvas.groups)
        self._canvas.aim(camera)
        geoms, depth = self._ids(_Output(camera, None), self._canvas.groups, with_depth=True)
        assert depth is not None
        return depth, geoms

    def amodal_beyond(self, index: int) -> NDArray[np.int64]:
        """Pixels (T,) of the targets' amodal masks, including those beyond the picture's border.

        Counted in a picture twice as wide and high, with the view in its middle. The pixels are
        those of the view (of its ideal pinhole, where it has a lens).
        """
        self._canvas.begin()
        lens = self.world.lenses[index]
        camera = lens.ideal if lens else self.world.rig.cameras[index]
        K = np.array(camera.K)
        width, height = camera.width_px, camera.height_px
        K[:2, 2] += width // 2, height // 2
        wide = replace(camera, K=K, width_px=2 * width, height_px=2 * height, distortion=NO_LENS)
        counts = np.zeros(len(TARGETS), np.int64)
        for number, group in enumerate(self.world.amodal_groups):
            self._canvas.show(CAMERAS[index], (group,))
            self._canvas.aim(wide)
            counts[number] = np.count_nonzero(self._skin(_Output(wide, None), number, group))
        return counts

    def _colour(self, output: _Output) -> Image:
        rgb = self._canvas.colour(output.drawn(SUPERSAMPLE))
        if output.lens is None:
            small = cv2.resize(rgb, output.size[::-1], interpolation=cv2.INTER_AREA)[::-1]
        else:
            warped = output.lens.colour(np.ascontiguousarray(rgb[::-1]))
            small = cv2.resize(warped, output.size[::-1], interpolation=cv2.INTER_AREA)
        return np.ascontiguousarray(small[..., ::-1])

    def _skin(self, output: _Output, number: int, group: int) -> NDArray[np.bool_]:
        """Mask (h, w) of a target's skin in its amodal group, which the canvas shows."""
        geoms, _ = self._ids(output, (group,), with_depth=False)
        # The last is for -1, nothing.
        return np.append(self.world.targets == number, False)[geoms]

    def _ids(
        self, output: _Output, groups: Collection[int], with_depth: bool
    ) -> tuple[NDArray[np.int32], NDArray[np.float32] | None]:
        """Geom ids and, if asked for, depth [m] at the pixel centres, from one pass.

        Through a lens, where drawn pixels and pixel centres differ, edges are settled by rays: no
        id is mixed or off by a part of a pixel.
        """
        canvas, lens = self._canvas, output.lens
        fine, raw = canvas.ids(output.drawn(1 if lens is None else SUPERSAMPLE), with_depth)
        if lens is None:
            geoms = np.ascontiguousarray(fine[::-1])
            return geoms, None if raw is None else canvas.metres(raw[::-1])
        geoms, sure = lens.ids(fine)
        depth = None
        if raw is not None:
            mixed, even = lens.inverse_depth(raw, BEND_PER_M * canvas.near_m)
            depth, sure = canvas.metres(mixed), sure & even
        ys, xs = np.nonzero(~sure)
        hit, hit_m = cast(self.world, output.camera, np.column_stack([xs, ys]), groups)
        geoms[ys, xs] = hit
        if depth is not None:
            depth[ys, xs] = np.where(hit < 0, canvas.far_m, hit_m)
        return geoms, depth


@dataclass(frozen=True, eq=False)
class _Output:
    """The picture to render: its camera, and the lens through which it is resampled."""

    camera: Camera
    lens: Lens | None

    @property
    def size(self) -> Size:
        """Height and width of the picture."""
        return self.camera.height_px, self.camera.width_px

    def drawn(self, scale: int) -> Size:
        """Height and width of the picture that OpenGL draws for it."""
        height, width = self.size
        if self.lens is not None:
            height, width = self.lens.ideal.height_px, self.lens.ideal.width_px
        return scale * height, scale * width
