"""A tracker in forty lines: each target is where the blobs nearest to its last place cross."""

import numpy as np

from pjpdaf.camera import project, triangulate
from pjpdaf.interfaces import Estimates
from pjpdaf.tracker.start import StartParameters, find_head_and_hands


class NearestBlob:
    def __init__(self, cameras, reach_px=80.0):
        self.cameras, self.reach_px = cameras, reach_px

    def start(self, detections):
        places = find_head_and_hands(self.cameras, detections, StartParameters())
        return None if places is None else (places, ("tracked",) * 3)

    def step(self, state, detections, dt_s):
        places, status = state[0].copy(), ["coasting"] * 3
        for target in range(3):
            pixels = []
            for camera, view in zip(self.cameras, detections, strict=True):
                away = np.linalg.norm(view.centres_px - project(camera, places[target]), axis=1)
                if len(away) and away.min() < self.reach_px:
                    pixels.append(view.centres_px[away.argmin()])
            found = triangulate(self.cameras, np.array(pixels)) if len(pixels) == 2 else np.nan
            if np.isfinite(found).all():
                places[target], status[target] = found, "tracked"
        return (places, tuple(status)), self.estimates((places, tuple(status)))

    def estimates(self, state):
        spread_m2 = np.tile(0.03**2 * np.eye(3), (3, 1, 1))
        return Estimates(state[0], spread_m2, np.zeros((3, 3)), state[1])

    def predict(self, state, dt_s):
        return self.estimates(state)
