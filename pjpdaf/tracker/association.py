"""Association of a step (thesis 3.4): gates, weights and weighted innovations of every view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from pjpdaf.arrays import Bools, Floats
from pjpdaf.checks import AboveZero, BetweenZeroAndOne, check_bounds
from pjpdaf.interfaces import Detections
from pjpdaf.tracker.clutter import ClutterReading, Relative
from pjpdaf.tracker.jpda import association_probabilities, squared_distances
from pjpdaf.tracker.occlusion import OcclusionRule
from pjpdaf.tracker.projective import innovation_covariance, inverse
from pjpdaf.tracker.state import Prior


@dataclass(frozen=True)
class AssociationParameters:
    """Gates and joint probabilistic data association (Eq. 3.24-3.34)."""

    # P_D of Eq. 3.33, Table 4.1 [1].
    p_detect: BetweenZeroAndOne = 0.9
    # Gate d^2 <= g^2 (Eq. 3.24); g^2 of Table 4.1 [1].
    gate: AboveZero = 15.0
    # C of Eq. 3.32, Table 4.1; its unit is that of clutter_reading.
    clutter_reading: ClutterReading = field(default_factory=Relative)
    clutter: AboveZero = 0.1
    # A target is located in a view where the mass 1 - beta_0n is at least this [1]. Ours.
    found_mass: BetweenZeroAndOne = 0.5

    def __post_init__(self) -> None:
        check_bounds("TrackerParameters", self)


class Association(NamedTuple):
    """Result of a step's association, per target and view.

    innovation (T, N, r) weighted (Eq. 3.38) [px]; theta (T, N, r, r) Eq. 3.43; best (T, N, r)
    innovation of the likeliest measurement and beta_best (T, N) its weight; beta_0 (T, N);
    present (T, N) the picture was there and the target is in front of the camera; merged (T, N)
    the occlusion rule; empty (T, N) no measurement in the gate; found_mass: the weight from which
    a target counts as located.
    """

    innovation: Floats
    theta: Floats
    best: Floats
    beta_best: Floats
    beta_0: Floats
    present: Bools
    merged: Bools
    empty: Bools
    found_mass: float

    @property
    def used(self) -> Bools:
        """Views that take part in a target's update, (T, N)."""
        return self.present & ~self.merged


def without_measurements(
    parameters: AssociationParameters, prior: Prior, arrived: Bools
) -> Association:
    """Return an association to be filled, nothing seen in it; arrived (N,): pictures there."""
    T, N, r, _ = prior.H.shape
    return Association(
        innovation=np.zeros((T, N, r)),
        theta=np.zeros((T, N, r, r)),
        best=np.zeros((T, N, r)),
        beta_best=np.zeros((T, N)),
        beta_0=np.ones((T, N)),
        present=~np.isnan(prior.z[..., 0]).T & arrived,
        merged=np.zeros((T, N), dtype=bool),
        empty=np.ones((T, N), dtype=bool),
        found_mass=parameters.found_mass,
    )


def associate(
    parameters: AssociationParameters,
    occlusion: OcclusionRule,
    clutter: Sequence[float],
    prior: Prior,
    detections: tuple[Detections, ...],
) -> Association:
    """Per-view JPDA of the prediction (Eq. 3.36-3.38, 3.43); clutter: C of each view."""
    T = len(prior.mean)
    S = innovation_covariance(prior.H.swapaxes(0, 1), prior.P, prior.R)  # (N, T, r, r)
    S_inverse = inverse(S)
    targets = np.arange(T)
    arrived = np.array([not view.missing for view in detections])
    out = without_measurements(parameters, prior, arrived)
    for n, view in enumerate(detections):
        if view.missing or len(view) == 0:
            continue
        pixels = view.centres_px[:, None] - prior.z[n]  # (m, T, 2); NaN behind the camera
        # A third component of the innovation would be 0.
        d2 = squared_distances(pixels, S_inverse[n, :, :2, :2])
        gated = d2 <= parameters.gate
        if not gated.any():
            continue
        likelihood = parameters.clutter_reading.likelihood(d2, gated, S[n])
        beta = association_probabilities(likelihood, gated, parameters.p_detect, clutter[n])
        pixels = np.where(gated[:, :, None], pixels, 0.0)
        weights = beta[1:, :, None] * pixels
        out.innovation[:, n, :2] = weights.sum(axis=0)
        out.theta[:, n, :2, :2] = np.matmul(weights.transpose(1, 2, 0), pixels.transpose(1, 0, 2))
        out.best[:, n, :2] = pixels[beta[1:].argmax(axis=0), targets]
        out.beta_best[:, n] = beta[1:].max(axis=0)
        out.beta_0[:, n] = beta[0]
        out.empty[:, n] = ~gated.any(axis=0)
        out.merged[:, n] = occlusion(gated, beta[1:])
    return out


def assign(parameters: AssociationParameters, prior: Prior, assigned_px: Floats) -> Association:
    """Association of measurements whose origin is known: weights of 1.

    assigned_px (N, T, 2): the undistorted measurement of each target in each view, NaN where it
    has none.
    """
    innovation = (assigned_px - prior.z).swapaxes(0, 1)  # (T, N, 2); NaN: unseen, or behind
    given: Bools = np.asarray(np.isfinite(innovation).all(axis=-1))
    innovation = np.where(given[..., None], innovation, 0.0)
    out = without_measurements(parameters, prior, np.ones(len(assigned_px), dtype=bool))
    out.innovation[..., :2] = innovation
    out.theta[..., :2, :2] = innovation[..., :, None] * innovation[..., None, :]
    out.best[..., :2] = innovation
    out.beta_best[given] = 1.0
    out.beta_0[given] = 0.0
    out.empty[given] = False
    return out
