"""The share of a target that lies outside the picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from sim.camera.rays import cast
from sim.dataset.labels.masks import box_of
from sim.lens import Lens, real_pixels
from sim.scene.world import World


@dataclass(frozen=True, eq=False)
class IdealPixels:
    """The ideal picture of a view with a lens.

    camera: its pinhole; pixels (n, 2): those that the real picture shows; real (n, 2): their
    positions in the real picture.
    """

    camera: Camera
    pixels: Floats
    real: NDArray[np.float32]

    @staticmethod
    def of(camera: Camera, lens: Lens) -> IdealPixels:
        """The ideal picture of a camera with this lens."""
        rows, columns = np.mgrid[: lens.ideal.height_px, : lens.ideal.width_px]
        pixels = np.column_stack([columns.ravel(), rows.ravel()]).astype(np.float64)
        at = (pixels + camera.K[:2, 2] - lens.ideal.K[:2, 2]).astype(np.float32)
        real = np.column_stack(real_pixels(camera, lens, at[:, 0], at[:, 1]))
        size = np.array([camera.width_px, camera.height_px])
        inside = ((real >= -0.5) & (real < size - 0.5)).all(axis=1)
        return IdealPixels(lens.ideal, pixels[inside], real[inside])

    def around(self, box: Floats) -> Floats:
        """The ideal pixels (n, 2) in and just around a box of real ones."""
        low, high = box[:2] - 1, box[:2] + box[2:]
        return self.pixels[((self.real >= low) & (self.real <= high)).all(axis=1)]


def pixels_inside(
    world: World, ideal: IdealPixels | None, amodal: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Pixels (T,) of the amodal masks (T, h, w) inside the picture.

    In the raster in which `StereoRenderer.amodal_beyond` counts: with a lens, of the ideal picture,
    by rays into the world as it stands.
    """
    if ideal is None:
        return np.asarray(np.count_nonzero(amodal, axis=(1, 2)), np.int64)
    skins = np.append(world.targets, np.int8(-1))
    counts = np.zeros(len(amodal), np.int64)
    for target, (mask, group) in enumerate(zip(amodal, world.amodal_groups, strict=True)):
        if mask.any():
            geoms, _ = cast(world, ideal.camera, ideal.around(box_of(mask)), (group,))
            counts[target] = np.count_nonzero(skins[geoms] == target)
    return counts


def touches_border(mask: NDArray[np.bool_]) -> bool:
    """Whether a mask reaches the picture's border."""
    return bool(mask[[0, -1]].any() or mask[:, [0, -1]].any())


def truncation(
    amodal: NDArray[np.bool_],
    inside: NDArray[np.int64] | None,
    beyond: NDArray[np.int64] | None,
    in_frame: NDArray[np.bool_],
) -> Floats:
    """Share (T,) of each target's amodal pixels that lies outside the picture.

    Exactly 0 for a mask that is clear of the border. inside (T,): pixels inside the picture, of
    `pixels_inside`; beyond (T,): with the pixels beyond its border, out to half the picture's size;
    both None where no target can be cut off. in_frame (T,): whether the target's centre is in the
    picture; decides between 0 and 1 for a target without pixels (its own hair hides it, or it is
    farther out).
    """
    share = np.zeros(len(amodal))
    if inside is None or beyond is None:
        return share
    for target, mask in enumerate(amodal):
        if not mask.any():
            share[target] = beyond[target] > 0 or not in_frame[target]
        elif touches_border(mask):
            share[target] = max(1 - float(inside[target]) / max(float(beyond[target]), 1.0), 0.0)
    return share
