"""PJPDAF, thesis 3.5: projective joint probabilistic data association filter."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import final

import numpy as np

from pjpdaf.arrays import Floats, readonly
from pjpdaf.camera import Camera
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.known_targets import KnownTargets
from pjpdaf.tracker.association import Association, assign, associate
from pjpdaf.tracker.measurement import Projection, linearise
from pjpdaf.tracker.parameters import TrackerParameters
from pjpdaf.tracker.process import process_noise, transition
from pjpdaf.tracker.projective import bounded, predict
from pjpdaf.tracker.start import Starter, find_head_and_hands, start_covariance
from pjpdaf.tracker.state import Prior, TrackState
from pjpdaf.tracker.status import judge


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
        self.parameters = p = parameters if parameters is not None else TrackerParameters()
        self.starter = starter
        self._projection = Projection.of(self.cameras, p.measurement.measurement)
        self._R = p.measurement.R
        reading, clutter = p.association.clutter_reading, p.association.clutter
        self._clutter = [reading.level(clutter, camera) for camera in self.cameras]
        self._model = lru_cache(maxsize=8)(
            lambda dt_s: (transition(dt_s), process_noise(p.process, dt_s))
        )
        # The detector's prediction is the next step's.
        self._ahead = lru_cache(maxsize=1)(self._predicted)

    def start(self, detections: tuple[Detections, ...]) -> TrackState | None:
        """Return the first state, or None where the views do not agree yet (section 3.6)."""
        self._check(detections)
        positions = self.starter(self.cameras, detections, self.parameters.start)
        return None if positions is None else self.start_at(positions)

    def start_at(self, positions_w: Floats) -> TrackState:
        """Return a state from labelled positions (T, 3) [m], at rest, with P_0 of Table 4.1."""
        positions = readonly(positions_w, (None, 3), "start positions")
        if len(positions) == 0 or not np.all(np.isfinite(positions)):
            raise ValueError("start positions must be finite and at least one")
        T = len(positions)
        mean = np.concatenate([positions, np.zeros((T, 3))], axis=1)
        covariance = np.tile(start_covariance(self.parameters.start), (T, 1, 1))
        return TrackState(mean, covariance, np.zeros(T), ("tracked",) * T)

    def step(
        self, state: TrackState, detections: tuple[Detections, ...], dt_s: float
    ) -> tuple[TrackState, Estimates]:
        """Predict, associate in each view, update (section 3.5); detections: a record a view."""
        self._check(detections)
        prior, association = self.associate(state, detections, dt_s)
        return self._update(state, prior, association, dt_s)

    def step_associated(
        self,
        state: TrackState,
        detections: tuple[Detections, ...],
        known: KnownTargets,
        dt_s: float,
    ) -> tuple[TrackState, Estimates]:
        """Step with measurements whose origin is known: no association."""
        self._check(detections)
        prior = self._prior(state, dt_s)
        association = assign(self.parameters.association, prior, known.pixels(detections))
        return self._update(state, prior, association, dt_s)

    def expecting(self, state: TrackState, known: KnownTargets, dt_s: float) -> TrackState:
        """Return the state on the line that leads to the known targets; the covariance stays."""
        before = known.positions_m - dt_s * known.velocities_mps
        return replace(state, mean=np.concatenate([before, known.velocities_mps], axis=1))

    def estimates(self, state: TrackState) -> Estimates:
        """Return positions, velocities and status of a state."""
        return _estimates(state.mean, state.covariance, state.status)

    def predict(self, state: TrackState, dt_s: float) -> Estimates:
        """Return the prediction dt_s after `state` (Eq. 3.35-3.36)."""
        return _estimates(*self._ahead(state, dt_s), state.status)

    def associate(
        self, state: TrackState, detections: tuple[Detections, ...], dt_s: float
    ) -> tuple[Prior, Association]:
        """Return the first two stages of a step: prediction and per-view JPDA."""
        p = self.parameters
        prior = self._prior(state, dt_s)
        return prior, associate(p.association, p.occlusion, self._clutter, prior, detections)

    def _update(
        self, before: TrackState, prior: Prior, association: Association, dt_s: float
    ) -> tuple[TrackState, Estimates]:
        fusion = self.parameters.fusion
        mean, covariance = fusion.update(prior, association, fusion.beta_0)
        covariance = bounded(covariance)
        after = judge(self.parameters.status, before, mean, covariance, association, dt_s)
        return after, self.estimates(after)

    def _prior(self, state: TrackState, dt_s: float) -> Prior:
        mean, P = self._ahead(state, dt_s)
        z, H, _ = linearise(self._projection, mean[:, :3], third_row=len(self._R) == 3)
        H[np.isnan(z[..., 0])] = 0.0
        return Prior(mean, P, H.swapaxes(0, 1), self._R, z)

    def _predicted(self, state: TrackState, dt_s: float) -> tuple[Floats, Floats]:
        if not 0.0 < dt_s < math.inf:
            raise ValueError(f"dt_s must be a time above 0 s, got {dt_s!r}")
        F, Q = self._model(dt_s)
        return predict(state.mean, state.covariance, F, Q)

    def _check(self, detections: tuple[Detections, ...]) -> None:
        if len(detections) != len(self.cameras):
            raise ValueError(
                f"the tracker has {len(self.cameras)} cameras but got detections of "
                f"{len(detections)} views; give one record a view, Detections.none(missing=True) "
                "for a picture that is missing"
            )


def _estimates(mean: Floats, P: Floats, status: tuple[str, ...]) -> Estimates:
    return Estimates(mean[:, :3], P[:, :3, :3], mean[:, 3:], status)
