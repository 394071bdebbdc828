"""Paths of head and hands in an oblique view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import Markup

from pjpdaf.arrays import Floats
from pjpdaf.targets import TARGETS
from reports.page.charts.svg import TOP, WIDTH, legend, marker, path_data, round_step, svg
from reports.words import LABELS

# View of the 3-D paths: columns are the world's x, y, z in the picture (right, up).
_VIEW = np.array([[-0.62, 0.78, 0.0], [-0.30, -0.24, 0.92]])
_OUTLIERS = 0.01  # of the estimates at either end of an axis; they do not make the box


@dataclass(frozen=True, eq=False)
class Axes:
    """The frame of the points, by the axes that are drawn: towards the viewer, right, up.

    R (3, 3): from the points' frame to these, a signed permutation; names: of the three.
    """

    R: Floats
    names: tuple[str, str, str]

    @property
    def signs(self) -> Floats:
        """Of the numbers (3,) on the drawn axes."""
        return np.asarray(self.R.sum(axis=1))


# x towards the cameras, y to the person's left, z up.
WORLD_AXES = Axes(np.eye(3), ("x [mm]", "y [mm]", "z [mm]"))
# x right, y down, z forward: as in OpenCV.
CAMERA_AXES = Axes(
    np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]),
    ("z, depth [mm]", "x, right [mm]", "y, down [mm]"),
)


def path_chart(
    truth_mm: Floats | None, estimates_mm: Floats, height: int = 340, axes: Axes = WORLD_AXES
) -> Markup:
    """Draw 3-D paths (F, T, 3) [mm]: estimates in colour, truth thin (Fig. 4.2, 4.4).

    axes: of the frame that the points are in. Estimates more than 300 mm outside the box of the
    truth are cut off; without a truth the box is that of all estimates but outliers.
    """
    estimates_mm = estimates_mm @ axes.R.T
    if truth_mm is None:
        known = estimates_mm[np.isfinite(estimates_mm).all(axis=-1)]
        known = known if len(known) else np.zeros((1, 3))
        flat = np.quantile(known, [_OUTLIERS, 1 - _OUTLIERS], axis=0)
    else:
        truth_mm = truth_mm @ axes.R.T
        flat = truth_mm.reshape(-1, 3)
    low = np.floor(flat.min(axis=0) / 100 - 0.5) * 100
    high = np.ceil(flat.max(axis=0) / 100 + 0.5) * 100
    near = (estimates_mm > low - 300) & (estimates_mm < high + 300)
    estimates_mm = np.where(near.all(axis=-1, keepdims=True), estimates_mm, np.nan)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    box = (low + corners * (high - low)) @ _VIEW.T
    scale = min((WIDTH - 2 * 46) / np.ptp(box[:, 0]), (height - TOP - 40) / np.ptp(box[:, 1]))
    middle = (box.max(axis=0) + box.min(axis=0)) / 2
    centre = np.array([WIDTH / 2, (TOP + height - 14) / 2])

    def place(points_mm: Floats) -> Floats:
        return np.asarray(centre + (points_mm @ _VIEW.T - middle) * [scale, -scale])

    parts = [_box(low, high, place, axes)]
    kinds = {"estimate": estimates_mm} | ({} if truth_mm is None else {"truth": truth_mm})
    for kind, paths in kinds.items():
        for t, target in enumerate(TARGETS):
            line = path_data(place(paths[:, t]))
            parts.append(f'<path class="line {kind} {target}" d="{line}"/>')
    for t, target in enumerate(TARGETS):
        known = estimates_mm[np.isfinite(estimates_mm[:, t]).all(axis=1), t]
        if len(known):
            x, y = place(known[-1])
            parts.append(marker(target, float(x), float(y), 5.0, f"{LABELS[target]}, last frame"))
    parts.append(legend(TARGETS))
    truth = "" if truth_mm is None else ": estimates in colour, truth thin"
    return svg(parts, height, f"Paths of head and hands in 3-D{truth}")


def _box(low: Floats, high: Floats, place: Any, axes: Axes) -> str:
    """Floor grid of a 3-D box with its axes and their ticks [mm]."""
    parts = []
    step = round_step(float((high - low).max()) / 5)
    edges: list[tuple[int, int, Floats]] = [
        # axis of the ticks, axis of the grid lines, corner of the third axis
        (0, 1, low),
        (1, 0, low),
    ]
    for along, across, fixed in edges:
        for value in np.arange(np.ceil(low[along] / step) * step, high[along] + 1, step):
            ends = np.array([fixed, fixed], dtype=np.float64)
            ends[:, along] = value
            ends[:, across] = low[across], high[across]
            parts.append(f'<path class="grid" d="{path_data(place(ends))}"/>')
            x, y = place(ends[1])
            anchor = "start" if along == 0 else "end"
            shift = 6 if along == 0 else -6
            parts.append(
                f'<text class="soft" x="{x + shift:.1f}" y="{y + 10:.1f}" text-anchor="{anchor}">'
                f"{axes.signs[along] * value + 0.0:g}</text>"
            )
    # Without a number at its foot, where those of the floor are.
    for value in np.arange((np.floor(low[2] / step) + 1) * step, high[2] + 1, step):
        at = place(np.array([low[0], high[1], value]))
        parts.append(
            f'<text class="soft" x="{at[0] + 6:.1f}" y="{at[1] + 4:.1f}">'
            f"{axes.signs[2] * value + 0.0:g}</text>"
        )
    upright = np.array([[low[0], high[1], low[2]], [low[0], high[1], high[2]]])
    parts.append(f'<path class="grid" d="{path_data(place(upright))}"/>')
    places = (
        (np.array([(low[0] + high[0]) / 2, high[1], low[2]]), 26, 26, "start"),
        (np.array([high[0], (low[1] + high[1]) / 2, low[2]]), -22, 26, "end"),
        (np.array([low[0], high[1], high[2]]), -8, -8, "middle"),
    )
    for name, (point, dx, dy, anchor) in zip(axes.names, places, strict=True):
        x, y = place(point)
        parts.append(
            f'<text x="{x + dx:.1f}" y="{y + dy:.1f}" text-anchor="{anchor}">{name}</text>'
        )
    return "".join(parts)
