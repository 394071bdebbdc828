"""Independent truth: rays into the rebuilt scene against the ids and depth of a data set's files.

A ray knows no raster, no lens map and no file format. The scene is posed at the moment that
truth.parquet names (the right view's is later by the shutter skew), and rays go through the centres
of a regular grid of pixels and of all pixels near the borders of the targets' masks, which is where
masks go wrong.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.errors import FileError
from pjpdaf.targets import TARGETS
from sim.camera.rays import cast
from sim.dataset.files.layout import DEPTH_UNIT_M
from sim.dataset.labels.classes import classes_of
from sim.dataset.labels.instances import Instances, instances_of
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS, World
from sim.sequence import Simulation
from sim.steps import step as count_step

STEP_PX = 6
BAND_PX = 2  # around the borders of the targets' masks, where every pixel is compared
MOST_WRONG = 1e-3  # goal: share of pixels whose instance differs
MOST_MEDIAN_M = 5e-5  # goal: median difference of depth, half a unit of which the files round away


@dataclass(frozen=True, eq=False)
class RayFigures:
    """Differences between rays and files, over all compared frames and views.

    rays: number of rays; pixels: of the pictures; wrong: number of pixels that show another
    instance, where a ray of the grid counts for its square and a ray near a target's border for its
    pixel. target_pixels, target_wrong (T,): pixels of each target's masks, and pixels in exactly
    one of the masks of file and truth. class_wrong: as wrong, of the semantic classes, None without
    that label. depths_m: |difference| of all rays of the grid whose
    ids agree; most_m: the maximum, near borders too.
    """

    rays: int
    pixels: int
    wrong: float
    target_pixels: NDArray[np.int64]
    target_wrong: Floats
    class_wrong: float | None
    depths_m: NDArray[np.float32]
    most_m: float

    @property
    def wrong_share(self) -> float:
        """Share of all pixels whose instance differs."""
        return self.wrong / max(self.pixels, 1)

    @property
    def target_shares(self) -> Floats:
        """Different pixels over mask pixels of each target (T,)."""
        return np.asarray(self.target_wrong / np.maximum(self.target_pixels, 1))

    @property
    def class_share(self) -> float:
        """Share of all pixels whose semantic class differs; 0 without that label."""
        return (self.class_wrong or 0.0) / max(self.pixels, 1)

    @property
    def median_m(self) -> float:
        """Median |difference| of depth, 0 without compared pixels."""
        return float(np.median(self.depths_m)) if len(self.depths_m) else 0.0

    @property
    def rarely_m(self) -> float:
        """99 % quantile of |difference| of depth."""
        return float(np.quantile(self.depths_m, 0.99)) if len(self.depths_m) else 0.0

    @property
    def met(self) -> bool:
        """Whether the files meet the goals MOST_WRONG and MOST_MEDIAN_M."""
        shares = self.wrong_share, self.class_share
        return max(shares) <= MOST_WRONG and self.median_m <= MOST_MEDIAN_M


def pooled(all_figures: Iterable[RayFigures]) -> RayFigures:
    """Pool the figures of several comparisons; all 0 without any."""
    parts = list(all_figures)
    zeros = np.zeros(len(TARGETS))
    classes = [part.class_wrong for part in parts if part.class_wrong is not None]
    return RayFigures(
        rays=sum(part.rays for part in parts),
        pixels=sum(part.pixels for part in parts),
        wrong=sum(part.wrong for part in parts),
        target_pixels=sum((part.target_pixels for part in parts), zeros.astype(np.int64)),
        target_wrong=sum((part.target_wrong for part in parts), zeros),
        class_wrong=sum(classes) if classes else None,
        depths_m=np.concatenate([np.zeros(0, np.float32), *(part.depths_m for part in parts)]),
        most_m=max((part.most_m for part in parts), default=0.0),
    )


def ray_check(
    simulation: Simulation, sequence: StoredSequence, frames: Iterable[int], step: int = STEP_PX
) -> RayFigures:
    """Compare frames of a sequence with rays into the scene from which it was made.

    simulation: of its recipe; it is only posed, nothing is rendered. step: of the grid [px]. The
    labels seg and depth are needed. Raises FileError where a file is missing or damaged, a frame
    does not exist, or the simulation has other cameras than rig.json.
    """
    world = simulation.world
    for name, real, stored in zip(CAMERAS, world.rig.cameras, sequence.rig.cameras, strict=True):
        same = all(
            np.array_equal(getattr(real, field), getattr(stored, field))
            for field in ("K", "R_cw", "t_cw", "distortion", "width_px", "height_px")
        )
        if not same:
            raise FileError(
                sequence.folder, f"the {name} camera of rig.json is not that of recipe.json"
            )
    instances, classes = instances_of(world), classes_of(world)
    figures = []
    for index in frames:
        if not 0 <= index < sequence.frame_count:
            raise FileError(sequence.folder, f"has no frame {index}")
        time_s = sequence.truths[index].time_s
        for view in range(len(CAMERAS)):
            later_s = simulation.performance.scene.sensor.skew_s if view else 0.0
            world.place(simulation.performance.script.pose(time_s + later_s))
            figures.append(_of_view(world, sequence, instances, classes, index, view, step))
        count_step()
    return pooled(figures)


def _of_view(
    world: World,
    sequence: StoredSequence,
    instances: Instances,
    classes: NDArray[np.uint8],
    index: int,
    view: int,
    step: int,
) -> RayFigures:
    seg, depth_m = sequence.seg(view, index), sequence.depth_m(view, index)
    band = _borders(seg)
    grid = np.zeros(seg.shape, bool)
    grid[step // 2 :: step, step // 2 :: step] = True
    ys, xs = np.nonzero(band | grid)
    geoms, met_m = cast(world, world.rig.cameras[view], np.column_stack([xs, ys]))
    met, stored, near = instances.ids(geoms), seg[ys, xs], band[ys, xs]
    # A ray of the grid counts for the part of its square that is not near a border.
    square = float(np.count_nonzero(~band)) / max(int(np.count_nonzero(~near)), 1)
    stands_for = np.where(near, 1.0, square)
    off_m = np.abs(met_m - depth_m[ys, xs])[met == stored]
    known = np.isfinite(off_m)
    of_grid = known & grid[ys, xs][met == stored]
    targets = 1 + np.arange(len(TARGETS))
    class_wrong = None
    if sequence.has(f"semantic_{CAMERAS[view]}"):
        other = classes[geoms] != sequence.classes(view, index)[ys, xs]
        class_wrong = float(stands_for[other].sum())
    return RayFigures(
        rays=len(xs),
        pixels=seg.size,
        wrong=float(stands_for[met != stored].sum()),
        target_pixels=np.array([np.count_nonzero(seg == t) for t in targets]),
        target_wrong=np.array([stands_for[(met == t) != (stored == t)].sum() for t in targets]),
        class_wrong=class_wrong,
        depths_m=off_m[of_grid].astype(np.float32),
        most_m=float(off_m[known].max(initial=0.0)),
    )


def _borders(seg: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Pixels (h, w) within BAND_PX of a border of a target's mask, on both of its sides."""
    kernel = np.ones((2 * BAND_PX + 1, 2 * BAND_PX + 1), np.uint8)
    near = np.zeros(seg.shape, bool)
    for target in range(1, 1 + len(TARGETS)):
        mask = (seg == target).astype(np.uint8)
        near |= cv2.dilate(mask, kernel) != cv2.erode(mask, kernel)
    return near


def lines_of(figures: RayFigures) -> list[str]:
    """The figures as lines of text, for a terminal or a card."""
    shares = ", ".join(
        f"{target} {share:.3%}"
        for target, share in zip(TARGETS, figures.target_shares, strict=True)
    )
    classes = (
        []
        if figures.class_wrong is None
        else [f"classes: {figures.class_share:.4%} of pixels differ (goal {MOST_WRONG:.1%})"]
    )
    return [
        f"ids: {figures.wrong_share:.4%} of pixels differ (goal {MOST_WRONG:.1%})",
        *classes,
        f"masks: pixels that differ, of the mask's: {shares}",
        f"depth: median {1e3 * figures.median_m:.4f} mm off (goal {1e3 * MOST_MEDIAN_M:.2f} mm), "
        f"99 % within {1e3 * figures.rarely_m:.3f} mm, at most {1e3 * figures.most_m:.2f} mm; "
        f"files are rounded to {1e3 * DEPTH_UNIT_M:.1f} mm",
    ]
