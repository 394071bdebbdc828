"""Errors of an episode: every target against its own truth (thesis 4.2, Eq. 4.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, project
from reports.score.records import Episode

BANDS_M = (0.05, 0.10)
Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class EpisodeScore:
    """Errors of F frames, T targets, V views. NaN: the tracker gave no estimate (or as noted).

    error_m, depth_m, lateral_m (F, T): against the centre; depth_m is signed, along the left
    camera's viewing ray to the truth, positive beyond it; lateral_m is the rest, never negative.
    surface_m (F, T): against the visible surface, NaN where the target is unseen.
    view_px (F, T, V): distance in the undistorted picture; err_acc_px (F, T): its mean (Eq. 4.1);
    infinite for an estimate behind a camera.
    visible (F, T, V): visible fractions; merged (F, T): the target's skin touches another's in
    some view. nees (F, T): (x - x̂)ᵀ P⁻¹ (x - x̂), 3 degrees of freedom, NaN where P has no inverse.
    """

    error_m: Floats
    lateral_m: Floats
    depth_m: Floats
    surface_m: Floats
    view_px: Floats
    err_acc_px: Floats
    visible: Floats
    merged: Bools
    nees: Floats

    @property
    def covered(self) -> Bools:
        """Frames with an estimate, (F, T)."""
        return np.isfinite(self.error_m)

    def within(self, bound_m: float) -> Bools:
        """Frames with an estimate no further off than bound_m [m], (F, T). No estimate: False."""
        inside: Bools = np.nan_to_num(self.error_m, nan=np.inf) <= bound_m
        return inside


def score(episode: Episode) -> EpisodeScore:
    """Score every frame of an episode."""
    truths = [outcome.truth for outcome in episode.frames]
    centres = np.stack([truth.centres_m for truth in truths])
    surfaces = np.stack([truth.surfaces_m for truth in truths])
    estimates = np.stack([outcome.estimates.positions_m for outcome in episode.frames])
    covariances = np.stack([outcome.estimates.covariances_m2 for outcome in episode.frames])
    marks = np.stack([[view.centroids_px for view in truth.views] for truth in truths])
    # An estimate with any number missing is no estimate.
    estimates = np.where(np.isfinite(estimates).all(axis=-1, keepdims=True), estimates, np.nan)
    lateral, depth = lateral_and_depth(episode.cameras[0], estimates, centres)
    pixels = np.stack(
        [
            view_errors(camera, estimates, centres, marks[:, v])
            for v, camera in enumerate(episode.cameras)
        ],
        axis=-1,
    )
    merged = np.stack([[view.merged for view in truth.views] for truth in truths])
    return EpisodeScore(
        error_m=np.asarray(np.linalg.norm(estimates - centres, axis=-1)),
        lateral_m=lateral,
        depth_m=depth,
        surface_m=np.asarray(np.linalg.norm(estimates - surfaces, axis=-1)),
        view_px=pixels,
        err_acc_px=np.asarray(pixels.mean(axis=-1)),
        visible=np.stack([[v.visible_fractions for v in truth.views] for truth in truths]).swapaxes(
            1, 2
        ),
        merged=np.asarray(merged.any(axis=(1, 3))),
        nees=normalised_errors(estimates - centres, covariances),
    )


def lateral_and_depth(
    camera: Camera, estimates_w: Floats, truths_w: Floats
) -> tuple[Floats, Floats]:
    """Parts of the error (..., 3) [m] across and along the camera's viewing ray to the truth.

    Lateral (...) >= 0, depth (...) signed: positive where the estimate is too far away.
    """
    rays = truths_w - camera.centre_w
    rays = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    errors = estimates_w - truths_w
    depth = np.sum(errors * rays, axis=-1)
    lateral = np.linalg.norm(errors - depth[..., None] * rays, axis=-1)
    return np.asarray(lateral), np.asarray(depth)


def view_errors(camera: Camera, estimates_w: Floats, centres_w: Floats, marks_px: Floats) -> Floats:
    """Distance (...) [px] of projected estimates (..., 3) [m] from targets in the view (..., 2).

    marks_px: centroid of the visible skin, in the undistorted picture; where NaN (unseen) the
    projected centre takes its place. Infinite where the estimate is behind the camera, NaN without
    an estimate and where the truth itself is unseen and behind the camera.
    """
    wanted = np.where(np.isfinite(marks_px), marks_px, project(camera, centres_w))
    projected = project(camera, estimates_w)
    behind = np.isfinite(estimates_w).all(axis=-1) & ~np.isfinite(projected).all(axis=-1)
    distance = np.linalg.norm(projected - wanted, axis=-1)
    distance = np.where(behind & np.isfinite(wanted).all(axis=-1), np.inf, distance)
    return np.asarray(distance, dtype=np.float64)


def normalised_errors(errors_m: Floats, covariances_m2: Floats) -> Floats:
    """NEES eᵀ P⁻¹ e (...) of errors (..., 3) [m], P (..., 3, 3) [m²]; NaN unless P > 0."""
    out = np.full(errors_m.shape[:-1], np.nan)
    finite = np.isfinite(errors_m).all(axis=-1) & np.isfinite(covariances_m2).all(axis=(-2, -1))
    for place in zip(*np.nonzero(finite), strict=True):
        try:
            root = np.linalg.cholesky(covariances_m2[place])
        except np.linalg.LinAlgError:
            continue
        out[place] = float(np.sum(np.linalg.solve(root, errors_m[place]) ** 2))
    return out


def quantile(values: Floats, q: float) -> float:
    """Quantile of values (n,) by linear interpolation; NaN counts as infinite, none gives NaN.

    So a tracker cannot better its median by keeping silent.
    """
    if len(values) == 0:
        return float("nan")
    ordered = np.sort(np.nan_to_num(values, nan=np.inf, posinf=np.inf))
    place = q * (len(ordered) - 1)
    low, part = int(place), place - int(place)
    if part < 1e-12 or ordered[low] == np.inf:
        return float(ordered[low])
    return float(ordered[low] + part * (ordered[low + 1] - ordered[low]))
