"""The numbers of a sequence are those of its records."""

import json

import numpy as np

from pjpdaf.targets import TARGETS
from reports.dataset.sequence_data import sequence_data
from sim.dataset.labels.records import KEYPOINTS
from sim.scene.world import CAMERAS


def test_numbers_are_those_of_the_records(shown):
    for clip in shown:
        data = sequence_data(clip)
        json.dumps(data, allow_nan=False)
        for index, truth in enumerate(clip.sequence.truths):
            places = np.array(data["positions"][index]) * 1e-4
            np.testing.assert_allclose(places, truth.centres_m, atol=0.51e-4)
            speeds = np.array(data["speeds"][index]) * 1e-3
            wanted = np.linalg.norm(truth.velocities_mps, axis=1)
            np.testing.assert_allclose(speeds, wanted, atol=0.51e-3)
            for v in range(len(CAMERAS)):
                for t in range(len(TARGETS)):
                    box = data["boxes"][index][v][t]
                    wanted = truth.views[v].boxes_px[t]
                    assert box == (None if np.isnan(wanted[0]) else wanted.astype(int).tolist())
                assert sum(map(len, data["keypoints"][index][v])) == len(KEYPOINTS)
        frames = [frame for frame, _ in clip.sequence.frames()]
        assert data["arrived"] == [[int(p is not None) for p in f.pictures] for f in frames]
