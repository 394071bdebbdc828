"""Colour, depth and ids of both views, repeatable to the bit."""

from __future__ import annotations

from collections.abc import Collection
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, Image
from pjpdaf.camera import Camera
from pjpdaf.targets import TARGETS
from sim.camera.boxes import GeomBoxes
from sim.camera.canvas import Canvas, Size
from sim.camera.normals import NONE, encoded, through_lens
from sim.camera.rays import cast, cast_normals
from sim.camera.still import StillScene, StillView, tiles_of
from sim.camera.window import Window, around, whole
from sim.lens import Lens
from sim.person.geoms import LEGS
from sim.pose import Pose
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

    still: a pose whose scene, without the moving parts of the person, is drawn once; each view then
    draws what differs from it (`sim.camera.still`), without it everything. Objects that it does not
    name are taken where they are now. Raises InfrastructureError where there is no OpenGL.
    """

    def __init__(self, world: World, still: Pose | None = None) -> None:
        self.world = world
        self._canvas = Canvas(world)
        self._boxes = GeomBoxes(world.model)
        self._still: StillScene | None = None
        self._still_places = None
        if still is not None:
            with world.borrowed():
                world.place(still)
                self._still_places = world.joints_and_places()

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
        world, groups = self.world, self._groups(person)
        output = _Output(world.rig.cameras[index], world.lenses[index])
        self._canvas.begin()
        still = self._still_scene() if colour or labels else None
        base, labels_at, colours_at = None, whole(output.pinhole), whole(output.pinhole)
        if still is not None:
            base = still.views[index]
            labels_at, colours_at = still.windows(index, world.data, self._shown(groups))
        self._canvas.show(CAMERAS[index], groups)
        picture = self._colour(output, colours_at, base) if colour else None
        depth = geoms = targets = masks = None
        if labels:
            geoms, depth = self._labels(output, groups, labels_at, base)
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
        groups = self._groups(person=True)
        self._canvas.show(CAMERAS[0], groups)
        geoms, depth = self._labels(_Output(camera, None), groups, whole(camera), None)
        return depth, geoms

    def normals(self, index: int, geoms: NDArray[np.int32]) -> Image:
        """Surface normals (h, w, 3) of a view of the current pose, encoded as `sim.camera.normals`.

        geoms (h, w): geom ids of the view. Where a lens leaves no drawn pixel of the geom around a
        pixel's centre, the triangle that a ray meets gives its normal.
        """
        self._canvas.begin()
        output = _Output(self.world.rig.cameras[index], self.world.lenses[index])
        groups = self._groups(person=True)
        self._canvas.show(CAMERAS[index], groups)
        self._canvas.aim(output.pinhole)
        drawn = self._canvas.normals(output.drawn(output.label_scale))
        if output.lens is None:
            picture = drawn[::-1].copy()
        else:
            ids, _ = self._ids(output, whole(output.pinhole), None)
            picture, known = through_lens(output.lens, drawn, ids, geoms)
            ys, xs = np.nonzero(~known)
            met = cast_normals(self.world, output.camera, np.column_stack([xs, ys]), groups)[2]
            picture[ys, xs] = encoded(met)
        picture[geoms < 0] = NONE
        return picture

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
            counts[number] = np.count_nonzero(self._skin(_Output(wide, None), number, group))
        return counts

    def _groups(self, person: bool) -> tuple[int, ...]:
        hidden = () if person else self.world.person_groups
        return tuple(group for group in self._canvas.groups if group not in hidden)

    def _shown(self, groups: Collection[int]) -> NDArray[np.bool_]:
        return np.isin(self.world.model.geom_group, list(groups))

    def _still_scene(self) -> StillScene | None:
        """The still scene, drawn the first time that it is needed."""
        if self._still is None and self._still_places is not None:
            with self.world.borrowed():
                self.world.restore(self._still_places)
                self._still = self._drawn_still()
        return self._still

    def _drawn_still(self) -> StillScene:
        world, canvas = self.world, self._canvas
        groups = (*self._groups(person=False), LEGS)
        views = []
        world_to_maps: tuple[Floats, ...] = ()
        for index, name in enumerate(CAMERAS):
            output = _Output(world.rig.cameras[index], world.lenses[index])
            camera = output.pinhole
            canvas.show(name, groups)
            canvas.aim(camera)
            rgb, fine = canvas.colour_and_depth(output.drawn(SUPERSAMPLE))
            geoms, depth = canvas.ids(output.drawn(output.label_scale), with_depth=True)
            assert depth is not None
            world_to_maps = canvas.world_to_maps()
            views.append(
                StillView(
                    camera=camera,
                    rgb=rgb,
                    picture=_developed(rgb),
                    geoms=geoms,
                    depth=depth,
                    depth_m=canvas.metres(depth),
                    tiles=tiles_of(camera, canvas.metres(fine), SUPERSAMPLE, world_to_maps),
                )
            )
        shown = self._shown(groups)
        edge_m = canvas.shadow_edge_m()
        return StillScene(
            self._boxes, world.model, world.data, shown, world_to_maps, tuple(views), edge_m
        )

    def _colour(self, output: _Output, window: Window, base: StillView | None) -> Image:
        """The picture (h, w, 3) BGR: what is drawn in a window of it, around it the still scene."""
        if window.empty and base is not None:
            drawn = np.empty((0, 0, 3), np.uint8)
        else:
            self._canvas.aim(window.crop(output.pinhole))
            height, width = window.size
            drawn = self._canvas.colour((SUPERSAMPLE * height, SUPERSAMPLE * width))
        if output.lens is not None:
            if base is not None:
                fine = base.rgb.copy()
                fine[window.part(SUPERSAMPLE, len(fine))] = drawn
                drawn = fine
            warped = output.lens.colour(cv2.flip(drawn, 0))
            small = cv2.resize(warped, output.size[::-1], interpolation=cv2.INTER_AREA)
            return np.asarray(cv2.cvtColor(small, cv2.COLOR_RGB2BGR))
        if base is None:
            return _developed(drawn)
        picture = base.picture.copy()
        if not window.empty:
            picture[window.part(1)] = _developed(drawn)
        return picture

    def _skin(self, output: _Output, number: int, group: int) -> NDArray[np.bool_]:
        """Mask (h, w) of a target's skin in its amodal group, which the canvas shows."""
        boxes_w = self._boxes.corners(self.world.data, self._shown((group,)))
        window = around(output.pinhole, boxes_w)
        is_skin = np.append(self.world.targets == number, False)  # the last is for -1, nothing
        if output.lens is not None:
            fine, _ = self._ids(output, window, None)
            return is_skin[self._through_lens(output, output.lens, (group,), fine, None)[0]]
        mask = np.zeros(output.size, bool)
        if not window.empty:
            self._canvas.aim(window.crop(output.pinhole))
            ids, _ = self._canvas.ids(window.size, with_depth=False)
            mask[window.part(1)] = is_skin[ids][::-1]
        return mask

    def _labels(
        self, output: _Output, groups: Collection[int], window: Window, base: StillView | None
    ) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Geom ids and depth [m] (h, w) at the pixel centres: a window of them, else as still."""
        geoms, raw = self._ids(output, window, base, with_depth=True)
        assert raw is not None
        if output.lens is not None:
            geoms, depth = self._through_lens(output, output.lens, groups, geoms, raw)
            assert depth is not None
            return geoms, depth
        if base is None:
            depth = self._canvas.metres(raw)
        else:
            depth = base.depth_m.copy()
            at = window.part(1, len(depth))
            depth[at] = self._canvas.metres(raw[at])
        return np.ascontiguousarray(geoms[::-1]), np.ascontiguousarray(depth[::-1])

    def _ids(
        self, output: _Output, window: Window, base: StillView | None, with_depth: bool = False
    ) -> tuple[NDArray[np.int32], NDArray[np.float32] | None]:
        """Geom ids and reversed depth as OpenGL draws them, rows from below, from one pass.

        Drawn in a window; around it as in the still scene, or nothing.
        """
        scale, size = output.label_scale, output.drawn(output.label_scale)
        geoms = np.full(size, -1, np.int32) if base is None else base.geoms.copy()
        depth = None
        if with_depth:
            depth = np.zeros(size, np.float32) if base is None else base.depth.copy()
        if not window.empty:
            self._canvas.aim(window.crop(output.pinhole))
            height, width = window.size
            ids, raw = self._canvas.ids((scale * height, scale * width), with_depth)
            at = window.part(scale, len(geoms))
            geoms[at] = ids
            if depth is not None:
                depth[at] = raw
        return geoms, depth

    def _through_lens(
        self,
        output: _Output,
        lens: Lens,
        groups: Collection[int],
        fine: NDArray[np.int32],
        raw: NDArray[np.float32] | None,
    ) -> tuple[NDArray[np.int32], NDArray[np.float32] | None]:
        """Geom ids and, with reversed depth, depth [m] at the pixel centres of the real picture.

        Where drawn pixels and pixel centres differ, edges are settled by rays: no id is mixed or
        off by a part of a pixel.
        """
        geoms, sure = lens.ids(fine)
        depth = None
        if raw is not None:
            mixed, even = lens.inverse_depth(raw, BEND_PER_M * self._canvas.near_m)
            depth, sure = self._canvas.metres(mixed), sure & even
        ys, xs = np.nonzero(~sure)
        hit, hit_m = cast(self.world, output.camera, np.column_stack([xs, ys]), groups)
        geoms[ys, xs] = hit
        if depth is not None:
            depth[ys, xs] = np.where(hit < 0, self._canvas.far_m, hit_m)
        return geoms, depth


def _developed(fine_rgb: Image) -> Image:
    """BGR (h, w, 3) from RGB (s h, s w, 3) as OpenGL gives it, SUPERSAMPLE times as fine."""
    size = fine_rgb.shape[1] // SUPERSAMPLE, fine_rgb.shape[0] // SUPERSAMPLE
    small = cv2.resize(fine_rgb, size, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.flip(cv2.cvtColor(small, cv2.COLOR_RGB2BGR), 0))


@dataclass(frozen=True, eq=False)
class _Output:
    """The picture to render: its camera, and the lens through which it is resampled."""

    camera: Camera
    lens: Lens | None

    @property
    def size(self) -> Size:
        """Height and width of the picture."""
        return self.camera.height_px, self.camera.width_px

    @property
    def pinhole(self) -> Camera:
        """The ideal camera whose picture OpenGL draws for it."""
        return self.camera if self.lens is None else self.lens.ideal

    @property
    def label_scale(self) -> int:
        """How many times as fine as the picture its labels are drawn."""
        return 1 if self.lens is None else SUPERSAMPLE

    def drawn(self, scale: int) -> Size:
        """Height and width of the picture that OpenGL draws for it."""
        return scale * self.pinhole.height_px, scale * self.pinhole.width_px
