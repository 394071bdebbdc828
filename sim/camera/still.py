"""What stands still before still cameras is drawn once: later pictures draw what differs from it.

The still scene is the world in a given pose without the person. A picture of another pose is that
of the still scene, but for a window around all that differs: geoms that are moved, come or gone,
where they are and where they were, and whatever their shadows may fall upon. So a picture depends
on its pose and on the still scene, never on what was drawn before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats, Image
from pjpdaf.camera import Camera
from sim.camera.boxes import GeomBoxes
from sim.camera.window import Window, bounds_of, joined

TILE_PX = 16
# Along each axis, of the shadow map's width: two texels, and what rounding may add.
_MAP_MARGIN = 0.002


@dataclass(frozen=True, eq=False)
class StillView:
    """The still scene as drawn for a view, by an ideal camera; rows are counted from below.

    rgb (s h, s w, 3), s times as fine as the view; geoms and depth (h', w') as fine as labels are
    drawn: geom ids, -1 for nothing, and reversed depth, depth_m the same in metres. picture
    (h, w, 3) BGR, of the view without a lens, rows from above. tiles: where its surfaces are.
    """

    camera: Camera
    rgb: Image
    picture: Image
    geoms: NDArray[np.int32]
    depth: NDArray[np.float32]
    depth_m: NDArray[np.float32]
    tiles: Tiles


@dataclass(frozen=True, eq=False)
class MapBoxes:
    """The ends low, high (rows, columns, 3) of a box around each tile's surfaces on a shadow map:
    across, up, depth, which grows towards the light.
    """

    low: Floats
    high: Floats

    def shaded_by(self, low: Floats, high: Floats) -> Window:
        """The window of tiles that may show a shadow of boxes (n, 3) on the shadow map.

        All of a box is in the way of what is behind its nearest side.
        """
        meets = np.ones((*self.low.shape[:2], len(low)), dtype=bool)
        for axis in range(3):
            meets &= self.low[:, :, axis, None] <= high[:, axis] + _MAP_MARGIN
            if axis < 2:
                meets &= self.high[:, :, axis, None] >= low[:, axis] - _MAP_MARGIN
        return _window(np.asarray(meets.any(axis=-1)))


@dataclass(frozen=True, eq=False)
class Tiles:
    """Where the surfaces lie that a view shows in each of its tiles of TILE_PX, row by row.

    far_m (rows, columns): planar depth of the farthest. on_maps: their boxes on the shadow map of
    each light with shadows.
    """

    far_m: Floats
    on_maps: tuple[MapBoxes, ...]

    def showing(self, camera: Camera, boxes_w: Floats) -> Window:
        """The window of tiles in which something in boxes (n, 8, 3) may be seen."""
        bounds = bounds_of(camera, boxes_w)
        first = TILE_PX * np.arange(max(self.far_m.shape))[:, None]
        columns, rows = first[: self.far_m.shape[1]], first[: self.far_m.shape[0]]
        across = (columns <= bounds.right) & (columns + TILE_PX > bounds.left)
        down = (rows <= bounds.bottom) & (rows + TILE_PX > bounds.top)
        meets = down[:, None] & across
        meets &= bounds.near_m <= self.far_m[:, :, None]
        return _window(np.asarray(meets.any(axis=-1)))


def tiles_of(
    camera: Camera,
    fine_depth_m: NDArray[np.float32],
    scale: int,
    world_to_maps: Sequence[Floats],
) -> Tiles:
    """Tiles of what a camera sees: planar depth (s h, s w) [m], rows from below, s times as fine.

    On the map each tile is taken for all between its nearest and its farthest point.
    """
    height, width = camera.height_px, camera.width_px
    rows, columns = -(-height // TILE_PX), -(-width // TILE_PX)
    step = TILE_PX * scale
    padded = np.pad(
        fine_depth_m[::-1],
        ((0, rows * step - scale * height), (0, columns * step - scale * width)),
        mode="edge",
    )
    tiles = padded.reshape(rows, step, columns, step)
    near_m, far_m = (np.asarray(end(tiles, axis=(1, 3)), float) for end in (np.min, np.max))
    if not world_to_maps:
        return Tiles(far_m, ())
    x = TILE_PX * np.arange(columns + 1) - 0.5
    y = TILE_PX * np.arange(rows + 1) - 0.5
    grid = np.stack([*np.meshgrid(x, y), np.ones((rows + 1, columns + 1))], axis=-1)
    rays_w = grid @ np.linalg.inv(camera.K).T @ camera.R_cw
    corners = [rays_w[i : rows + i, j : columns + j] for i in (0, 1) for j in (0, 1)]
    ends_m = np.stack([near_m, far_m], axis=-1)
    points = np.stack(corners, axis=2)[:, :, :, None] * ends_m[:, :, None, :, None]
    on_maps = []
    for world_to_map in world_to_maps:
        on_map = (points + camera.centre_w) @ world_to_map[:3, :3].T + world_to_map[:3, 3]
        boxes = on_map.reshape(rows, columns, -1, 3)
        on_maps.append(MapBoxes(boxes.min(axis=2), boxes.max(axis=2)))
    return Tiles(far_m, tuple(on_maps))


def _window(tiles: NDArray[np.bool_]) -> Window:
    """The smallest window that holds these tiles (rows, columns)."""
    rows, columns = np.nonzero(tiles)
    if not len(rows):
        return Window(0, 0, 0, 0)
    ends = columns.min(), rows.min(), columns.max() + 1, rows.max() + 1
    left, top, right, bottom = (int(end) * TILE_PX for end in ends)
    return Window(left, top, right, bottom)


class StillScene:
    """The poses of the still scene's geoms, and its views.

    shown (ngeom,) bool: the geoms that it shows. edge_m: half the width of its shadows' edges.
    """

    def __init__(
        self,
        boxes: GeomBoxes,
        model: Any,
        data: Any,
        shown: NDArray[np.bool_],
        world_to_maps: tuple[Floats, ...],
        views: tuple[StillView, ...],
        edge_m: float,
    ) -> None:
        self.views = views
        self._edge_m = edge_m
        self._boxes, self._shown = boxes, shown
        self._casts = np.asarray(model.geom_castshadow, dtype=bool)
        self._world_to_maps = world_to_maps
        self._xpos, self._xmat = data.geom_xpos.copy(), data.geom_xmat.copy()
        self._corners = boxes.corners(data, np.ones_like(shown))

    def windows(self, index: int, data: Any, shown: NDArray[np.bool_]) -> tuple[Window, Window]:
        """The windows of a view outside which labels, and colours, are those of the still scene.

        data: the present pose; shown (ngeom,) bool: the geoms that are drawn now.
        """
        moved = (data.geom_xpos != self._xpos).any(axis=1)
        moved |= (data.geom_xmat != self._xmat).any(axis=1)
        differs = moved | (shown != self._shown)
        now, before = differs & shown, differs & self._shown
        corners = np.concatenate(
            [self._boxes.corners(data, now), self._corners[before[self._boxes.geoms]]]
        )
        view = self.views[index]
        width, height = view.camera.width_px, view.camera.height_px
        labels = view.tiles.showing(view.camera, corners).within(width, height)
        if not self._world_to_maps:
            return labels, labels
        of = np.concatenate(
            [self._boxes.geoms[which[self._boxes.geoms]] for which in (now, before)]
        )
        casting, colours = corners[self._casts[of]], labels
        for boxes, world_to_map in zip(view.tiles.on_maps, self._world_to_maps, strict=True):
            on_map = casting @ world_to_map[:3, :3].T + world_to_map[:3, 3]
            edge = self._edge_m * np.linalg.norm(world_to_map[:3, :3], axis=1)
            shadows = boxes.shaded_by(on_map.min(axis=1) - edge, on_map.max(axis=1) + edge)
            colours = joined(colours, shadows.within(width, height))
        return labels, colours
