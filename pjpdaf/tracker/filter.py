"""PJPDAF, thesis 3.5: projective joint probabilistic data association filter."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, final

import numpy as np

from pjpdaf.arrays import Floats, readonly
from pjpdaf.camera import Camera
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.presets.parameters import TrackerParameters
from pjpdaf.tracker.jpda import Bools, association_probabilities, clusters, squared_distances
from pjpdaf.tracker.projective import (
    Projection,
    gain,
    innovation_covariance,
    joseph,
    linearise,
    predict,
    process_noise,
    start_covariance,
    symmetric,
    transition,
    update,
)
from pjpdaf.tracker.start import Starter, find_head_and_hands


@dataclass(frozen=True, eq=False)
class TrackState:
    """All that changes from frame to frame.

    mean (T, 6): X Y Z [m], X' Y' Z' [m/s]; covariance (T, 6, 6); unseen_s (T,) time since the
    target was last found in two views [s]; status: as in `Estimates`.
    """

    mean: Floats
    covariance: Floats
    unseen_s: Floats
    status: tuple[str, ...]

    def __post_init__(self) -> None:
        T = len(self.status)
        shapes = {"mean": (T, 6), "covariance": (T, 6, 6), "unseen_s": (T,)}
        for name, shape in shapes.items():
            value = readonly(getattr(self, name), shape, f"TrackState.{name}")
            object.__setattr__(self, name, value)


class Association(NamedTuple):
    """What one step's association says, per target and view.

    innovation (T, N, r) weighted (Eq. 3.38) [px]; theta (T, N, r, r) Eq. 3.43; best (T, N, r)
    innovation of the likeliest measurement and beta_best (T, N) its weight, only for
    'most_probable'; beta_0 (T, N); present (T, N) the picture was there and the target is in front
    of the camera; merged (T, N) the occlusion rule; empty (T, N) no measurement in the gate.
    """

    innovation: Floats
    theta: Floats
    best: Floats
    beta_best: Floats
    beta_0: Floats
    present: Bools
    merged: Bools
    empty: Bools


class Prior(NamedTuple):
    """Predicted states with the model of all views at that point.

    mean (T, 6); P (T, 6, 6); H (T, N, r, 6); R (r, r) of one view.
    """

    mean: Floats
    P: Floats
    H: Floats
    R: Floats


@final
class PJPDAF:
    """Tracker of T targets in N calibrated views; all that changes is in `TrackState`.

    cameras: N >= 1; measurements are undistorted pixels. starter: the first positions from a
    frame's detections (section 3.6); `start_at` starts anywhere instead, with any T >= 1.
    """

    def __init__(
        self,
        cameras: tuple[Camera, ...],
        parameters: TrackerParameters | None = None,
        starter: Starter = find_head_and_hands,
    ) -> None:
        self.cameras = tuple(cameras)
        self.parameters = parameters if parameters is not None else TrackerParameters()
        self.starter = starter
        p = self.parameters
        self._projection = Projection.of(self.cameras, p.measurement)
        variances = [p.measurement_px2, p.measurement_px2]
        self._R = np.diag(variances + ([p.third_row_variance] if p.third_row_variance else []))
        self._clutter = [
            p.clutter / (camera.width_px * camera.height_px)
            if p.clutter_reading == "area"
            else p.clutter
            for camera in self.cameras
        ]
        self._model = lru_cache(maxsize=8)(
            lambda dt_s: (transition(dt_s), process_noise(self.parameters, dt_s))
        )

    def start(self, seen: tuple[Detections, ...]) -> TrackState | None:
        """The first state, or None where the views do not agree yet (section 3.6)."""
        self._check(seen)
        positions = self.starter(self.cameras, seen, self.parameters)
        return None if positions is None else self.start_at(positions)

    def start_at(self, positions_w: Floats) -> TrackState:
        """A state from labelled positions (T, 3) [m], at rest, with P_0 of Table 4.1."""
        positions = readonly(positions_w, (None, 3), "start positions")
        if len(positions) == 0 or not np.all(np.isfinite(positions)):
            raise ValueError("start positions must be finite and at least one")
        T = len(positions)
        mean = np.concatenate([positions, np.zeros((T, 3))], axis=1)
        covariance = np.tile(start_covariance(self.parameters), (T, 1, 1))
        return TrackState(mean, covariance, np.zeros(T), ("tracked",) * T)

    def step(
        self, state: TrackState, seen: tuple[Detections, ...], dt_s: float
    ) -> tuple[TrackState, Estimates]:
        """Predict, associate in each view, update (section 3.5). seen: one record a view."""
        self._check(seen)
        prior, association = self.associate(state, seen, dt_s)
        mean, covariance = UPDATES[self.parameters.update](self.parameters, prior, association)
        after = self._judge(state, mean, covariance, association, dt_s)
        return after, self.estimates(after)

    def step_assigned(
        self, state: TrackState, assigned_px: Floats, dt_s: float
    ) -> tuple[TrackState, Estimates]:
        """A step in which the origin of every measurement is known: no association.

        assigned_px (N, T, 2): the undistorted measurement of each target in each view, NaN where
        it has none.
        """
        N, T = len(self.cameras), len(state.status)
        assigned = readonly(assigned_px, (N, T, 2), "assigned_px")
        prior, z = self._prior(state, dt_s)
        innovation = (assigned - z).swapaxes(0, 1)  # (T, N, 2); NaN: unseen, or behind the camera
        given: Bools = np.asarray(np.isfinite(innovation).all(axis=-1))
        innovation = np.where(given[..., None], innovation, 0.0)
        out = self._nothing_seen(T, ~np.isnan(z[..., 0]).T)
        out.innovation[..., :2] = innovation
        out.theta[..., :2, :2] = innovation[..., :, None] * innovation[..., None, :]
        out.best[..., :2] = innovation
        out.beta_best[given] = 1.0
        out.beta_0[given] = 0.0
        out.empty[given] = False
        mean, covariance = UPDATES[self.parameters.update](self.parameters, prior, out)
        after = self._judge(state, mean, covariance, out, dt_s)
        return after, self.estimates(after)

    def estimates(self, state: TrackState) -> Estimates:
        """What a state says."""
        return _estimates(state.mean, state.covariance, state.status)

    def predict(self, state: TrackState, dt_s: float) -> Estimates:
        """What is expected dt_s after `state` (Eq. 3.35-3.36)."""
        return _estimates(*self._ahead(state, dt_s), state.status)

    def associate(
        self, state: TrackState, seen: tuple[Detections, ...], dt_s: float
    ) -> tuple[Prior, Association]:
        """The first two stages of a step: prediction and per-view JPDA (Eq. 3.35-3.38, 3.43)."""
        p = self.parameters
        prior, z = self._prior(state, dt_s)
        T = len(prior.mean)
        H = prior.H.swapaxes(0, 1)
        S = innovation_covariance(H, prior.P, self._R)  # (N, T, r, r)
        S_inverse = np.asarray(np.linalg.inv(S), dtype=np.float64)
        arrived = np.array([not view.missing for view in seen])
        out = self._nothing_seen(T, ~np.isnan(z[..., 0]).T & arrived)
        for n, view in enumerate(seen):
            if view.missing or len(view) == 0:
                continue
            pixels = view.centres_px[:, None] - z[n]  # (m, T, 2); NaN behind the camera
            # A third component of the innovation would be 0.
            d2 = squared_distances(pixels, S_inverse[n, :, :2, :2])
            gated = d2 <= p.gate
            if not gated.any():
                continue
            likelihood = np.exp(-0.5 * np.where(gated, d2, np.inf))
            if p.clutter_reading != "relative":
                likelihood = likelihood / np.sqrt(np.linalg.det(2 * math.pi * S[n]))
            beta = association_probabilities(likelihood, gated, p.p_detect, self._clutter[n])
            pixels = np.where(gated[:, :, None], pixels, 0.0)
            weights = beta[1:, :, None] * pixels
            out.innovation[:, n, :2] = weights.sum(axis=0)
            out.theta[:, n, :2, :2] = np.matmul(
                weights.transpose(1, 2, 0), pixels.transpose(1, 0, 2)
            )
            if p.update == "most_probable":
                out.best[:, n, :2] = pixels[beta[1:].argmax(axis=0), range(T)]
                out.beta_best[:, n] = beta[1:].max(axis=0)
            out.beta_0[:, n] = beta[0]
            out.empty[:, n] = ~gated.any(axis=0)
            out.merged[:, n] = OCCLUSIONS[p.occlusion](gated, beta[1:])
        return prior, out

    def _prior(self, state: TrackState, dt_s: float) -> tuple[Prior, Floats]:
        """The prediction, and where it is in each view (N, T, 2), NaN behind the camera."""
        mean, P = self._ahead(state, dt_s)
        third = len(self._R) == 3
        z, H, _ = linearise(self._projection, self.parameters.measurement, mean[:, :3], third)
        H[np.isnan(z[..., 0])] = 0.0
        return Prior(mean, P, H.swapaxes(0, 1), self._R), z

    def _nothing_seen(self, T: int, present: Bools) -> Association:
        """An association without any measurement; present (T, N)."""
        N, r = len(self.cameras), len(self._R)
        return Association(
            innovation=np.zeros((T, N, r)),
            theta=np.zeros((T, N, r, r)),
            best=np.zeros((T, N, r)),
            beta_best=np.zeros((T, N)),
            beta_0=np.ones((T, N)),
            present=present,
            merged=np.zeros((T, N), dtype=bool),
            empty=np.ones((T, N), dtype=bool),
        )

    def _ahead(self, state: TrackState, dt_s: float) -> tuple[Floats, Floats]:
        if not 0.0 < dt_s < math.inf:
            raise ValueError(f"dt_s must be a time above 0 s, got {dt_s!r}")
        F, Q = self._model(dt_s)
        return predict(state.mean, state.covariance, F, Q)

    def _check(self, seen: tuple[Detections, ...]) -> None:
        if len(seen) != len(self.cameras):
            raise ValueError(
                f"the tracker has {len(self.cameras)} cameras but got detections of "
                f"{len(seen)} views; give one record a view, Detections.none(missing=True) "
                "for a picture that is missing"
            )

    def _judge(
        self,
        before: TrackState,
        mean: Floats,
        covariance: Floats,
        association: Association,
        dt_s: float,
    ) -> TrackState:
        """Status of each target: found in two views, claimed by a merged blob, or not seen."""
        p = self.parameters
        claimed = association.present & (1.0 - association.beta_0 >= p.found_mass)
        needed = min(2, len(self.cameras))
        found = (claimed & ~association.merged).sum(axis=1) >= needed
        # A target inside a merged blob is not lost, only not located: its clock stands still.
        inside = (claimed | association.merged & association.present).sum(axis=1) >= needed
        unseen_s = np.where(found, 0.0, before.unseen_s + np.where(inside, 0.0, dt_s))
        P = covariance[:, :3, :3]
        wide = np.trace(P, axis1=1, axis2=2) > p.lost_sd_m**2  # no eigenvalue exceeds the trace
        if wide.any():
            wide = np.linalg.eigvalsh(P)[:, -1] > p.lost_sd_m**2
        # 1e-9: three steps of 1/3 s are 1 s.
        lost = wide | (unseen_s >= p.lost_after_s - 1e-9) & ~found
        status = tuple(
            "lost" if gone else "tracked" if here else "coasting"
            for gone, here in zip(lost.tolist(), found.tolist(), strict=True)
        )
        return TrackState(mean, covariance, unseen_s, status)


def _estimates(mean: Floats, P: Floats, status: tuple[str, ...]) -> Estimates:
    return Estimates(mean[:, :3], P[:, :3, :3], mean[:, 3:], status)


# A measurement that a target holds with this weight is no merged blob: else a lost target, whose
# gate covers everything, would keep all others from their measurements.
CERTAIN = 0.9


def _shared_measurement(gated: Bools, beta: Floats) -> Bools:
    """The rule as printed: a measurement lies in two targets' gates; (m, T) -> (T,)."""
    return np.asarray(gated[gated.sum(axis=1) > 1].any(axis=0))


def _fewer_measurements(gated: Bools, beta: Floats) -> Bools:
    """A cluster of gates with fewer measurements than targets, certain pairs apart; -> (T,)."""
    merged = np.zeros(gated.shape[1], dtype=bool)
    if gated.sum(axis=1).max() > 1:
        certain = beta >= CERTAIN
        doubtful = gated & ~certain.any(axis=0) & ~certain.any(axis=1, keepdims=True)
        for targets, measurements in clusters(doubtful):
            merged[targets] = 0 < len(measurements) < len(targets)
    return merged


def _never(gated: Bools, beta: Floats) -> Bools:
    return np.zeros(gated.shape[1], dtype=bool)


OCCLUSIONS: dict[str, Callable[[Bools, Floats], Bools]] = {
    "shared_measurement": _shared_measurement,
    "fewer_measurements": _fewer_measurements,
    "none": _never,
}


class Stacked(NamedTuple):
    """All views of each target under one another (Eq. 3.39-3.40), views left out as zero rows.

    innovation (T, N r); H (T, N r, 6); R (T, N r, N r).
    """

    innovation: Floats
    H: Floats
    R: Floats


def stack(prior: Prior, innovation: Floats, R: Floats, used: Bools) -> Stacked:
    """Views to one measurement vector (Eq. 3.19, 3.22, 3.39-3.40).

    innovation (T, N, r); R (T, N, r, r) or (r, r); used (T, N). R = infinity (Eq. 3.23) is done by
    leaving the view out: with a zero row in H its columns of K are 0, the limit of that rule.
    """
    T, N, r = innovation.shape
    H = np.where(used[:, :, None, None], prior.H, 0.0).reshape(T, N * r, 6)
    return Stacked(
        np.where(used[:, :, None], innovation, 0.0).reshape(T, N * r), H, block_diagonal(R, T, N)
    )


def block_diagonal(blocks: Floats, T: int, N: int) -> Floats:
    """Blocks (T, N, r, r) or (r, r) along the diagonal: (T, N r, N r) (Eq. 3.22, 3.43-3.44)."""
    r = blocks.shape[-1]
    full = np.zeros((T, N, r, N, r))
    views = np.arange(N)
    full[:, views, :, views, :] = blocks.swapaxes(0, 1) if blocks.ndim == 4 else blocks
    return full.reshape(T, N * r, N * r)


def probabilistic_update(
    mean: Floats, P: Floats, views: Stacked, beta_0: Floats, spread: Floats
) -> tuple[Floats, Floats]:
    """State and covariance with uncertain origins (Eq. 3.10, 3.12, 3.41).

    beta_0 (T,); spread (T, N r, N r) = Theta - Lambda. Eq. 3.41 takes (1 - beta_0) K S K^T from P:
    for beta_0 <= 1 that is beta_0 P + (1 - beta_0) (I - K H) P, with Joseph's form for the latter;
    beta_0 > 1 (the printed sum of Eq. 3.42) adds to P instead.
    """
    S = innovation_covariance(views.H, P, views.R)
    K = gain(P, views.H, S)
    moved = mean + (K @ views.innovation[..., None])[..., 0]
    share = 1.0 - beta_0[:, None, None]
    KT = K.swapaxes(-1, -2)
    kept = (1.0 - share) * P + share * joseph(P, K, views.H, views.R)
    if share.min() < 0.0:
        kept = np.where(share < 0.0, P - share * (K @ S @ KT), kept)
    return moved, symmetric(kept + K @ spread @ KT)


def _spread(innovation: Floats, theta: Floats, used: Bools) -> Floats:
    """Theta - Lambda of each view (Eq. 3.43-3.44), 0 where a view is left out."""
    outer = innovation[..., :, None] * innovation[..., None, :]
    return np.where(used[..., None, None], theta - outer, 0.0)


def _stacked(
    parameters: TrackerParameters, prior: Prior, seen: Association
) -> tuple[Floats, Floats]:
    """Eq. 3.39-3.44. A view without a detection counts as an innovation of 0 at full gain."""
    used = seen.present & ~seen.merged
    if parameters.update == "stacked_detected":
        used = used & ~seen.empty
    T, N = used.shape
    if parameters.beta_0 == "sum":
        beta_0 = np.where(seen.present, seen.beta_0, 0.0).sum(axis=1)
    else:
        beta_0 = np.where(used, seen.beta_0, 1.0).prod(axis=1)
    views = stack(prior, seen.innovation, prior.R, used)
    spread = block_diagonal(_spread(seen.innovation, seen.theta, used), T, N)
    return probabilistic_update(prior.mean, prior.P, views, beta_0, spread)


def _stacked_weighted(
    parameters: TrackerParameters, prior: Prior, seen: Association
) -> tuple[Floats, Floats]:
    """One Kalman update in which view n has the noise (R + spread) / (1 - beta_0n).

    The mean of a view's measurements given that one of them is right is z / (1 - beta_0n); how
    far they lie apart, Theta / (1 - beta_0n) minus its square, is part of its noise.
    """
    mass = 1.0 - seen.beta_0
    used = seen.present & ~seen.merged & (mass > 1e-6)
    weight = np.where(used, mass, 1.0)
    centre = seen.innovation / weight[..., None]
    spread = _spread(centre, seen.theta / weight[..., None, None], used)
    R = (prior.R + spread) / weight[..., None, None]
    views = stack(prior, centre, symmetric(R), used)
    return update(prior.mean, prior.P, views.innovation, views.H, views.R)


def _sequential(
    parameters: TrackerParameters, prior: Prior, seen: Association
) -> tuple[Floats, Floats]:
    """Each view's own PDA update in turn, all linearised and associated at the prediction."""
    mean, P = prior.mean, prior.P
    used = (seen.present & ~seen.merged).astype(float)  # 0 makes a view do nothing
    all_H = prior.H * used[:, :, None, None]
    masses = (1.0 - seen.beta_0) * used
    R = np.repeat(prior.R[None], len(mean), axis=0)
    for n in range(used.shape[1]):
        H, mass = all_H[:, n], masses[:, n, None]
        innovation = seen.innovation[:, n] * used[:, n, None]
        theta = seen.theta[:, n] * used[:, n, None, None]
        if n:  # from the prediction to what the views before made of it
            shift = (H @ (mean - prior.mean)[..., None])[..., 0]
            cross = shift[:, :, None] * innovation[:, None, :]
            again = (mass * shift)[:, :, None] * shift[:, None, :]
            theta = theta - cross - cross.swapaxes(1, 2) + again
            innovation = innovation - mass * shift
        spread = theta - innovation[:, :, None] * innovation[:, None, :]
        views = Stacked(innovation, H, R)
        mean, P = probabilistic_update(mean, P, views, 1.0 - mass[:, 0], spread)
    return mean, P


def _fused(parameters: TrackerParameters, prior: Prior, seen: Association) -> tuple[Floats, Floats]:
    """Each view's own PDA update of the prediction (Eq. 3.41), their information added up.

    P^-1 = P0^-1 + sum_n (P_n^-1 - P0^-1), P0 the prediction's, and the same for P^-1 x: exact where
    origins are certain, and the order of the views does not matter. A view whose doubt leaves P_n
    above P0 in some direction adds nothing there instead of taking information away, so P stays
    positive. Worked in coordinates in which P0 is the identity.
    """
    used = seen.present & ~seen.merged
    root = np.linalg.cholesky(prior.P)  # P0 = root root^T
    z = np.where(used[..., None], seen.innovation, 0.0)
    H = prior.H @ root[:, None]  # (T, N, r, 6)
    HT = H.swapaxes(-1, -2)
    K = HT @ np.linalg.inv(H @ HT + prior.R)
    detected = np.where(used, 1.0 - seen.beta_0, 0.0)[..., None, None]
    one = np.eye(H.shape[-1])
    P = one - detected * (K @ H) + K @ _spread(z, seen.theta, used) @ K.swapaxes(-1, -2)
    variances, axes = np.linalg.eigh(P)  # reads one triangle
    information = (axes * np.maximum(1.0 / variances, 1.0)[..., None, :]) @ axes.swapaxes(-1, -2)
    pulled = (information @ (K @ z[..., None])).sum(axis=1)
    P = root @ np.linalg.inv(one + (information - one).sum(axis=1))
    return prior.mean + (P @ pulled)[..., 0], symmetric(P @ root.swapaxes(-1, -2))


def _most_probable(
    parameters: TrackerParameters, prior: Prior, seen: Association
) -> tuple[Floats, Floats]:
    """The likeliest measurement of each view taken as certain (Eq. 3.10-3.12)."""
    used = seen.present & ~seen.merged & (seen.beta_best >= parameters.found_mass)
    views = stack(prior, seen.best, prior.R, used)
    return update(prior.mean, prior.P, views.innovation, views.H, views.R)


UPDATES: dict[str, Callable[[TrackerParameters, Prior, Association], tuple[Floats, Floats]]] = {
    "stacked": _stacked,
    "stacked_detected": _stacked,
    "stacked_weighted": _stacked_weighted,
    "sequential": _sequential,
    "fused": _fused,
    "most_probable": _most_probable,
}
