"""The torso as drawn: shoulders, chest and waist, a shirt with a collar."""

from __future__ import annotations

from typing import Any

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.targets import HEAD
from sim.anatomy import Anatomy
from sim.person.cloth import tailored
from sim.person.geoms import CLOTHES, TARGET_GROUPS
from sim.surfaces.assets import Assets
from sim.surfaces.shapes import (
    Surface,
    capped,
    closed_grid,
    interpolate,
    revolved,
    superellipse,
)

COLLAR_TOP_M = 0.088  # above the mid-shoulder point


def add_torso(assets: Assets, body: Any, anatomy: Anatomy, shirt: str) -> None:
    """Add chest, waist and collar, clothed with the material `shirt`, to the posed body."""
    assets.add(body, "torso", tailored(torso_surface(anatomy), 2, share=1.0), shirt, CLOTHES)
    # The collar goes with the head's group: it hides the neck of a head that nothing else
    # hides, so the amodal pass shows it.
    collar = revolved(
        np.array(
            [
                [0.050, 0.040],
                [0.0565, 0.048],
                [0.0555, 0.066],
                [0.0570, COLLAR_TOP_M - 0.008],
                [0.0560, COLLAR_TOP_M - 0.002],
                [0.0520, COLLAR_TOP_M],
                [0.0480, COLLAR_TOP_M - 0.004],
                [0.0470, COLLAR_TOP_M - 0.030],
            ]
        ),
        28,
    )
    collar = tailored(collar, 2)
    assets.add(body, "collar", collar, shirt, TARGET_GROUPS[HEAD], pos=(0.004, 0.0, 0.0))


def torso_surface(anatomy: Anatomy) -> Surface:
    """Shoulders, chest and waist in the torso frame, with a high collar."""
    return closed_grid(torso_grid(anatomy))


def torso_grid(anatomy: Anatomy) -> Floats:
    """The vertices (rings, 37, 3) of the torso's surface."""
    k = anatomy.stature_m / 1.72
    s = anatomy.shoulder_half_breadth_m / 0.18576
    # height, half breadth, front, back, exponent of the cross-section
    table = np.array(
        [
            [-0.560, 0.120, 0.070, 0.080, 2.4],
            [-0.530, 0.165, 0.100, 0.115, 2.5],
            [-0.450, 0.166, 0.112, 0.118, 2.5],
            [-0.340, 0.148, 0.108, 0.104, 2.4],
            [-0.240, 0.152, 0.112, 0.106, 2.4],
            [-0.150, 0.166, 0.118, 0.112, 2.5],
            [-0.090, 0.182, 0.110, 0.108, 2.5],
            [-0.045, 0.198, 0.090, 0.092, 2.4],
            [-0.020, 0.198, 0.076, 0.080, 2.3],
            [0.000, 0.194, 0.067, 0.072, 2.2],
            [0.018, 0.180, 0.061, 0.067, 2.1],
            [0.034, 0.139, 0.056, 0.062, 2.0],
            [0.047, 0.086, 0.053, 0.057, 2.0],
            [0.058, 0.055, 0.049, 0.051, 2.0],
            [0.070, 0.046, 0.044, 0.044, 2.0],
        ]
    )
    z = np.concatenate([np.linspace(-0.56, -0.12, 12), np.linspace(-0.10, 0.07, 16)])
    half, front, back, exponent = interpolate(table, z).T
    grid = np.empty((len(z), 37, 3))
    for ring in range(len(z)):
        outline = -superellipse(36, exponent[ring])  # the seam at the back
        depth = np.where(outline[:, 0] >= 0, front[ring], back[ring])
        grid[ring, :, 0] = depth * outline[:, 0] * k
        grid[ring, :, 1] = half[ring] * outline[:, 1] * (s if z[ring] < 0.03 else k)
        grid[ring, :, 2] = z[ring] * (k if z[ring] < 0 else 1)
    # The shoulders stand a little behind the neck; the chest curves forward.
    grid[..., 0] += np.interp(z, [-0.56, -0.15, 0.0, 0.09], [-0.01, 0.0, 0.0, 0.006])[:, None]
    return capped(grid)[::-1]
