"""Episodes of points, not pictures: truth, detections and a real tracker that follows them."""

import numpy as np
from strategies import PointWorld, minimum_jerk, rig

from pjpdaf.camera import project
from pjpdaf.interfaces import Estimates
from pjpdaf.plugins.registry import make_tracker
from reports.score.records import Episode, FrameOutcome
from scenarios.play.oracle import Oracle, track_again
from sim.truth import Truth, ViewTruth

FPS = 3.0
CAMERAS = rig().cameras
HEAD = np.array([0.0, 0.0, 1.2])


def tracker_of(preset="thesis"):
    return make_tracker(preset, CAMERAS, {})


def truth_of(index, motion):
    t = index / FPS
    centres = motion(t)
    velocities = (motion(t + 1e-3) - motion(t - 1e-3)) / 2e-3
    views = tuple(
        ViewTruth(
            centroids_px=(pixels := project(camera, centres)),
            visible_px=np.array([4000, 1500, 1500]),
            amodal_px=np.array([4000, 1500, 1500]),
            boxes_px=np.column_stack([pixels - 20, np.full((3, 2), 40.0)]),
            merged=np.zeros((3, 3), dtype=bool),
        )
        for camera in CAMERAS
    )
    return Truth(index, t, centres, velocities, centres, views)


def episode_of(motion, see, frames=40, tracker=None):
    """What a tracker makes of what `see(index, truth)` lets it see."""
    tracker = tracker or tracker_of()
    blank = Episode(
        "points",
        "test",
        0,
        FPS,
        CAMERAS,
        tuple(
            FrameOutcome(truth := truth_of(i, motion), Estimates.waiting(), see(i, truth))
            for i in range(frames)
        ),
    )
    return track_again(blank, CAMERAS, tracker, Oracle())


def all_seen(index, truth):
    return PointWorld(noise_px=0.3, miss=0, clutter=0).see(
        CAMERAS, truth.centres_m, np.random.default_rng(index)
    )


def apart(t):
    return np.array([HEAD, [0.3, -0.2, 0.85], [0.3, 0.2, 0.85]])


def crossing(t):
    """The hands pass each other, 8 cm apart in depth, in about a second."""
    u = minimum_jerk((t - 4.0) / 1.6)
    return np.array([HEAD, [0.34, -0.2 + 0.4 * u, 0.85], [0.26, 0.2 - 0.4 * u, 0.86]])


def merging(index, truth):
    """One blob for two hands nearer than 60 px, as a camera sees it."""
    return PointWorld(noise_px=0.3, miss=0, clutter=0, merge_px=60).see(
        CAMERAS, truth.centres_m, np.random.default_rng(index)
    )


class Frozen:
    """A tracker of somebody else's that never starts to estimate."""

    def start(self, seen):
        return 0

    def estimates(self, state):
        return Estimates.waiting()

    def predict(self, state, dt_s):
        return Estimates.waiting()

    def step(self, state, seen, dt_s):
        return state, Estimates.waiting()
