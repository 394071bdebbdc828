"""Optical flow: where the surface that each pixel shows is in the same view's picture of another
frame.

Every geom is rigid, fingers too: a pixel's surface point moves with its geom. A point is HIDDEN
where the other frame's depth is nearer than the point in all four pixels around its position, by
more than the width of a pixel there (`sim.dataset.labels.stereo`); a surface that did not move,
where that very pixel shows another geom nearer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from sim.dataset.labels.records import HIDDEN, NO_SURFACE, SEEN, Matches
from sim.dataset.labels.stereo import met_at, pixel_rays, status_of
from sim.lens import Lens, real_pixels
from sim.scene.world import World


@dataclass(frozen=True, eq=False)
class Moment:
    """A view of a moment: what it shows, and where all geoms are.

    geoms, depth_m (h, w), depth NaN for nothing; positions_m (ngeom, 3), rotations (ngeom, 3, 3).
    """

    geoms: NDArray[np.int32]
    depth_m: NDArray[np.float32]
    positions_m: Floats
    rotations: Floats

    @staticmethod
    def of(world: World, geoms: NDArray[np.int32], depth_m: NDArray[np.float32]) -> Moment:
        """The moment of a view of the world as it stands."""
        turns = world.data.geom_xmat.reshape(-1, 3, 3).copy()
        return Moment(geoms, depth_m, world.data.geom_xpos.copy(), turns)


class ViewFlow:
    """Optical flow of a view's camera, which stands still."""

    def __init__(self, camera: Camera, lens: Lens | None) -> None:
        self._camera, self._lens = camera, lens
        self._rays = pixel_rays(camera)
        rows, columns = np.mgrid[: camera.height_px, : camera.width_px].astype(np.float32)
        self._own_px = np.stack([columns, rows], axis=-1)

    def between(self, here: Moment, there: Moment) -> Matches:
        """Positions [px] in the other moment's picture of what each pixel shows, and their status.

        Positions may lie outside the picture; they are NaN only behind the camera and beyond the
        reach of its lens.
        """
        focal_px = float(self._camera.K[0, 0])
        there_is = np.isfinite(here.depth_m)
        moved = self._moved(here, there) & there_is
        ys, xs = np.nonzero(moved)
        pixels, z = self._positions(here, there, ys, xs)
        places = self._own_px.copy()
        places[~there_is] = np.nan
        places[ys, xs] = pixels
        # Of what stands still: its own pixel shows what has come before it.
        covered = (there.geoms != here.geoms) & (there.depth_m < here.depth_m)
        status = np.where(there_is, np.uint8(SEEN), np.uint8(NO_SURFACE))
        status[covered] = HIDDEN
        inside, met = met_at(there.depth_m, *pixels.T)
        status[ys, xs] = status_of(np.ones(len(ys), bool), inside, z, met, focal_px)
        return Matches(status, places_px=places)

    def _moved(self, here: Moment, there: Moment) -> NDArray[np.bool_]:
        """Which pixels (h, w) show a geom that is elsewhere at the other moment."""
        same = (here.positions_m == there.positions_m).all(axis=1)
        same &= (here.rotations == there.rotations).all(axis=(1, 2))
        return np.take(np.append(~same, False), here.geoms)

    def _positions(
        self, here: Moment, there: Moment, ys: NDArray[np.intp], xs: NDArray[np.intp]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Pixels (n, 2) and depths (n,) [m] at the other moment of the surfaces of n pixels."""
        camera = self._camera
        geoms, depth_m = here.geoms[ys, xs], here.depth_m[ys, xs].astype(np.float64)
        turns = there.rotations @ here.rotations.transpose(0, 2, 1)
        shifts = there.positions_m - np.einsum("gij,gj->gi", turns, here.positions_m)
        # In the camera's frame: X' = R A Rᵀ (X - t) + R b + t for X' = A X + b in the world.
        R, t = camera.R_cw, camera.t_cw
        turns_c = R @ turns @ R.T
        shifts_c = shifts @ R.T + t - np.einsum("gij,j->gi", turns_c, t)
        inside_c = self._rays[ys, xs] * depth_m[:, None]
        there_c = np.einsum("nij,nj->ni", turns_c[geoms], inside_c) + shifts_c[geoms]
        z = there_c[:, 2]
        q = there_c @ camera.K.T
        ideal = (q[:, :2] / np.where(z > 0, z, np.nan)[:, None]).astype(np.float32)
        x, y = real_pixels(camera, self._lens, ideal[:, 0], ideal[:, 1])
        return np.stack([x, y], axis=-1), z.astype(np.float32)
