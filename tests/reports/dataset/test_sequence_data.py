"""The numbers of a sequence are those of its records."""

import json
import shutil
from dataclasses import replace

import numpy as np

from pjpdaf.targets import TARGETS
from reports.dataset.sequence_data import sequence_data
from sim.dataset.labels.records import KEYPOINTS
from sim.scene.world import CAMERAS


def assert_skeletons(data, sequence, index, v):
    """Joints to 0.1 px, and a line for each bone of COCO's."""
    rows = sequence.skeletons.iloc[3 * index : 3 * index + 3]
    for k, (_, row) in enumerate(rows.iterrows()):
        points = data["skeletons"][index][v][k]
        assert [p[2] for p in points] == list(row[f"point_status_{CAMERAS[v]}"])
        wanted = np.array([list(p) for p in row[f"points_{CAMERAS[v]}_px"]], float)
        known = np.isfinite(wanted).all(axis=1)
        own = np.array([p[:2] for p in points], float)
        np.testing.assert_allclose(own[known] / 10, wanted[known], atol=0.051)
        ends = {end for bone in data["bones"][k] for end in bone}
        assert ends == set(range(len(points)))


def test_a_data_set_without_skeletons_has_none_to_draw(shown, tmp_path):
    sequence = shown[1].sequence
    shutil.copytree(sequence.folder, tmp_path / sequence.name)
    (tmp_path / sequence.name / "skeletons.parquet").unlink()
    older = replace(shown[1], sequence=replace(sequence, folder=tmp_path / sequence.name))
    assert sequence_data(older)["skeletons"] == [[[], []]] * shown[1].frames


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
                assert_skeletons(data, clip.sequence, index, v)
        frames = [frame for frame, _ in clip.sequence.frames()]
        assert data["arrived"] == [[int(p is not None) for p in f.pictures] for f in frames]
