"""The statistics of a data set: every number against a second, slow count of the same files."""

import json
import math
import shutil

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from sim.dataset.files.tables import TRUTH_SCHEMA
from sim.dataset.histograms import BINS, counted
from sim.dataset.labels.records import KEYPOINTS
from sim.dataset.reader import open_dataset
from sim.dataset.statistics import HANDS, skin_ita_deg, statistics_of
from sim.scene.world import CAMERAS


@pytest.fixture(scope="module")
def dataset(dataset_made, tmp_path_factory):
    """Merges in both views, and a hand out of view, in a sequence that has none of its own."""
    folder = tmp_path_factory.mktemp("busy") / "set"
    shutil.copytree(dataset_made, folder)
    path = folder / "seq_000001" / "truth.parquet"
    rows = pq.read_table(path).to_pylist()
    for frame, a, b, views in ((0, 0, 1, "left"), (1, 1, 2, "left right"), (3, 1, 2, "right")):
        for view in views.split():
            rows[3 * frame + a][f"merged_with_{view}"] = [TARGETS[b]]
            rows[3 * frame + b][f"merged_with_{view}"] = [TARGETS[a]]
    rows[4] |= {"amodal_left_px": 0, "visible_left_px": 0, "visible_fraction_left": 0.0}
    rows[4]["keypoint_status_left"] = [0] * 7
    pq.write_table(pa.Table.from_pylist(rows, schema=TRUTH_SCHEMA), path)
    return open_dataset(folder)


@pytest.fixture(scope="module")
def statistics(dataset):
    return statistics_of(dataset)


def slow_count(values, edges):
    counts = [0] * (len(edges) - 1)
    for value in values:
        if not math.isfinite(value):
            continue
        value = min(max(value, edges[0]), edges[-1])
        place = max(i for i in range(len(edges) - 1) if edges[i] <= value)
        counts[place] += 1
    return tuple(counts)


@pytest.mark.parametrize("seed", range(5))
def test_every_value_is_in_one_bin_or_missing(seed):
    rng = np.random.default_rng(seed)
    for bins in BINS.values():
        low, high = bins.edges[0], bins.edges[-1]
        values = rng.uniform(low - 1, high + 1, 200)
        values[::7] = rng.choice([np.nan, np.inf, *bins.edges], len(values[::7]))
        counts, missing = counted(values, bins.edges)
        assert counts.sum() + missing == 200
        assert tuple(counts.tolist()) == slow_count(values, bins.edges)


def test_frames_and_scenarios_are_those_on_disk(dataset, statistics):
    assert statistics.sequences == 3
    assert statistics.frames == 15
    assert statistics.scenarios == {"cross": (1, 6), "drink": (1, 4), "leave_view": (1, 5)}
    assert statistics.seconds == pytest.approx(
        sum(s.frame_count / s.fps for s in dataset.sequences)
    )
    lost = [
        sum(f.pictures[v] is None for s in dataset.sequences for f, _ in s.frames()) for v in (0, 1)
    ]
    assert list(statistics.lost_pictures.values()) == lost


def test_histograms_are_those_of_the_truths(dataset, statistics):
    shown = {f"{t}, {v}": [] for t in TARGETS for v in CAMERAS}
    distances = {t: [] for t in TARGETS}
    motions = {t: [] for t in TARGETS}
    speeds = {TARGETS[t]: [] for t in HANDS}
    for sequence in dataset.sequences:
        before = None
        for truth in sequence.truths:
            for t, target in enumerate(TARGETS):
                for v, view in enumerate(CAMERAS):
                    seen = truth.views[v]
                    share = seen.visible_px[t] / seen.amodal_px[t] if seen.amodal_px[t] else np.nan
                    shown[f"{target}, {view}"].append(share)
                gap = truth.centres_m[t] - sequence.rig.left.centre_w
                distances[target].append(math.sqrt(float(gap @ gap)))
                if before is not None:
                    step = truth.centres_m[t] - before[t]
                    motions[target].append(1e3 * math.sqrt(float(step @ step)))
                if target in speeds:
                    speeds[target].append(float(np.linalg.norm(truth.velocities_mps[t])))
            before = truth.centres_m
    for name, wanted in (
        ("visible_fraction", shown),
        ("distance", distances),
        ("motion", motions),
        ("hand_speed", speeds),
    ):
        found = statistics.histograms[name]
        edges = found.bins.edges
        assert found.counts == {series: slow_count(v, edges) for series, v in wanted.items()}
    missing = sum(not math.isfinite(v) for values in shown.values() for v in values)
    assert statistics.histograms["visible_fraction"].missing == missing > 0


def test_merged_frames_and_keypoints_are_those_of_the_records(dataset, statistics):
    merged = dict.fromkeys(statistics.merged, 0)
    anywhere = ambiguous = 0
    states = np.zeros((len(KEYPOINTS), 3), int)
    for sequence in dataset.sequences:
        for truth in sequence.truths:
            for v, view in enumerate(CAMERAS):
                for a in range(3):
                    for b in range(a + 1, 3):
                        name = f"{TARGETS[a]} + {TARGETS[b]}, {view}"
                        merged[name] += bool(truth.views[v].merged[a, b])
            anywhere += any(view.merged.any() for view in truth.views)
            ambiguous += all(view.merged[HANDS] for view in truth.views)
        for view in CAMERAS:
            rows = sequence.truth[f"keypoint_status_{view}"]
            for first in range(0, len(rows), 3):
                for k, state in enumerate(np.concatenate(list(rows[first : first + 3]))):
                    states[k, state] += 1
    assert statistics.merged == merged
    assert statistics.merged_frames == anywhere == 3
    assert statistics.ambiguous_frames == ambiguous == 1
    assert [list(n) for n in statistics.keypoints.values()] == states.tolist()


def test_skin_tone_is_the_recipes(dataset_copy):
    for number, value in enumerate((-45.0, 58, "light")):
        recipe = {"values": {"skin_ita": value}}
        (dataset_copy / f"seq_00000{number}" / "recipe.json").write_text(json.dumps(recipe))
    found = statistics_of(open_dataset(dataset_copy)).histograms["skin_tone"]
    assert found.counts == {"sequences": (1, 0, 0, 0, 0, 1)}
    assert found.missing == 1
    for recipe in ({}, {"values": 3}, {"values": {"skin_ita": True}}):
        assert math.isnan(skin_ita_deg(recipe))


def test_the_record_is_json_and_the_same_again(dataset, statistics):
    text = json.dumps(statistics.record(), allow_nan=False)
    assert text == json.dumps(statistics_of(dataset).record())
    assert json.loads(text)["histograms"]["truncation"]["counts"].keys() == {
        f"{target}, {view}" for target in TARGETS for view in CAMERAS
    }


def test_tables_are_not_kept(dataset, statistics):
    fresh = open_dataset(dataset.folder)
    statistics_of(fresh)
    assert all("truth" not in vars(sequence) for sequence in fresh.sequences)


def test_a_damaged_table_is_named(dataset_copy):
    path = dataset_copy / "seq_000001" / "truth.parquet"
    rows = pd.read_parquet(path)
    rows.iloc[[1, 0, *range(2, len(rows))]].to_parquet(path)
    with pytest.raises(BenchError, match=r"seq_000001/truth\.parquet: must have a row for each"):
        statistics_of(open_dataset(dataset_copy))
    rows["keypoint_status_left"] = [[7]] * len(rows)
    rows.to_parquet(path)
    with pytest.raises(BenchError, match=r"truth\.parquet: keypoint_status_left of head must be 2"):
        statistics_of(open_dataset(dataset_copy))
