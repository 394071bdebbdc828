"""The card: what the Hub reads, the same bytes every time, code that runs, nothing of a machine."""

import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
from ruamel.yaml import YAML

from pjpdaf.errors import BenchError
from reports.dataset.card import card_text, write_card
from reports.dataset.card_prose import without_paths
from reports.dataset.card_sample import sample_jpeg
from reports.dataset.card_tables import TASKS
from sim.dataset.export.registry import EXPORTS
from sim.dataset.files.conventions import conventions
from sim.dataset.files.layout import LABELS
from sim.dataset.histograms import BINS
from sim.dataset.raytruth import RayFigures, lines_of
from sim.dataset.reader import open_dataset
from sim.dataset.statistics import statistics_of


@pytest.fixture(scope="module")
def dataset(dataset_made):
    return open_dataset(dataset_made)


@pytest.fixture(scope="module")
def statistics(dataset):
    return statistics_of(dataset)


@pytest.fixture(scope="module")
def text(dataset, statistics):
    return card_text(dataset, statistics)


def front_matter(text):
    assert text.startswith("---\n")
    return YAML(typ="safe").load(text.split("---\n")[1])


def test_front_matter_is_what_the_hub_reads(text, dataset):
    head = front_matter(text)
    assert head["license"] == "cc-by-4.0"
    assert head["task_categories"] == list(TASKS)
    assert head["size_categories"] == ["n<1K"]
    for config in head["configs"]:
        files = sorted(dataset.folder.glob(config["data_files"]))
        assert len(files) == 3, config
    assert [c.get("default", False) for c in head["configs"]] == [True, False, False]


def test_every_format_that_is_there_is_listed(statistics, dataset_copy):
    assert "Beside them" not in card_text(open_dataset(dataset_copy), statistics)
    for export in EXPORTS.values():
        (dataset_copy / export.folder).mkdir()
    (line,) = re.findall(
        r"^Beside them: (.*)$", card_text(open_dataset(dataset_copy), statistics), re.M
    )
    listed = re.findall(r"`([^`]+)/`", line)
    assert listed == [export.folder for export in EXPORTS.values()]


def test_tables_can_be_loaded_by_the_hubs_library(dataset, statistics):
    # It reads by row groups: an empty one is a fault to it, and a table without any row as well.
    for name in ("truth", "skeletons", "objects"):
        for sequence in dataset.sequences:
            meta = pq.read_metadata(sequence.folder / f"{name}.parquet")
            groups = [meta.row_group(i).num_rows for i in range(meta.num_row_groups)]
            assert 0 not in groups, sequence.name
    assert statistics.object_rows == 4  # one object in one sequence
    bare = card_text(dataset, replace(statistics, object_rows=0))
    assert [c["config_name"] for c in front_matter(bare)["configs"]] == ["truth", "skeletons"]


def test_size_is_of_the_rows(dataset, statistics):
    for frames, size in ((333, "n<1K"), (334, "1K<n<10K"), (40_000, "100K<n<1M"), (10**8, "n>10M")):
        head = front_matter(card_text(dataset, replace(statistics, frames=frames)))
        assert head["size_categories"] == [size]


def test_a_card_is_written_twice_with_the_same_bytes(dataset_copy):
    dataset = open_dataset(dataset_copy)
    statistics = statistics_of(dataset)

    def written():
        text = write_card(dataset, statistics)
        assert (dataset_copy / "README.md").read_text() == text
        folder = dataset_copy / "pictures"
        return text, {p.name: p.read_bytes() for p in folder.iterdir()}

    first = written()
    assert written() == first
    assert first[1].keys() == {"sample.jpg", *(f"{name}.svg" for name in BINS)}
    for path in re.findall(r"pictures/[\w.]+", first[0]):
        assert (dataset_copy / path).is_file()


def test_no_word_of_the_machine(dataset, statistics, text):
    assert str(dataset.folder) not in text
    assert str(Path.home()) not in text
    words = ["dataset", "make", "cross", "--out", "/home/me/set", "--jobs", "4", "--seeds", "2"]
    assert without_paths(words) == ["dataset", "make", "cross", "--out", "set", "--seeds", "2"]
    assert without_paths(["x", "--jobs=4", "--out=/a/b", "--set", "a.b=1/2"]) == [
        "x", "--out=b", "--set", "a.b=1/2",
    ]  # fmt: skip
    made = card_text(dataset, statistics, command=words)
    assert "pjpdaf-bench dataset make cross --out set --seeds 2" in made
    assert "/home/me" not in made


def test_every_sequence_or_every_scenario_is_named(dataset, statistics, text):
    for sequence in dataset.sequences:
        assert f"| {sequence.name} |" in text
    many = replace(dataset, sequences=dataset.sequences * 10)
    assert "| cross | 1 | 6 |" in card_text(many, statistics)
    assert "seq_000001 |" not in card_text(many, statistics)


def test_all_conventions_and_labels_are_there(text, dataset):
    for key in conventions():
        assert f"**{key.replace('_', ' ')}**" in text
    for label in dataset.labels:
        assert f"`{LABELS[label][0]}/`" in text


def test_figures_of_rays_are_said_or_that_there_are_none(dataset, statistics, text):
    assert "dataset verify" in text
    figures = RayFigures(
        rays=300,
        pixels=20_000,
        wrong=14.0,
        target_pixels=np.array([400, 100, 100]),
        target_wrong=np.array([1.0, 0.0, 2.0]),
        class_wrong=3.0,
        depths_m=np.full(9, 3.2e-5, np.float32),
        most_m=0.01,
    )
    said = card_text(dataset, statistics, figures)
    assert "20000 pixels" in said
    assert "dataset verify" not in said
    for line in lines_of(figures):
        assert f"\n- {line}\n" in said


@pytest.mark.parametrize("number", [0, 1])
def test_code_of_the_card_runs(text, dataset, number):
    code = re.findall(r"```python\n(.*?)```", text, re.S)[number]
    checks = ("assert right_hand_m.shape == (3,)", "assert 0.3 < depth_m[hand].mean() < 3")
    root = Path(__file__).parents[3]
    subprocess.run(
        [sys.executable, "-W", "error", "-c", f"{code}\n{checks[number]}"],
        check=True,
        cwd=dataset.folder,
        env={**os.environ, "PYTHONPATH": str(root)},
        timeout=60,
    )


def test_the_sample_shows_frames_and_labels(dataset):
    jpeg = sample_jpeg(dataset)
    assert jpeg == sample_jpeg(dataset)
    sheet = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    tile = sheet[40:200, 10:250]
    assert tile.std() > 20  # a scene, no plain tile
    with pytest.raises(BenchError, match="no finished sequence"):
        sample_jpeg(replace(dataset, sequences=()))


def test_names_of_a_stranger_are_words(dataset, statistics):
    entry = {"label": "a|b\n# <script>x", "scenario": "`", "seed": 1}
    one = replace(dataset.sequences[0], entry=entry)
    text = card_text(replace(dataset, sequences=(one,)), statistics)
    assert "| a\\|b \\# \\<script\\>x | \\` |" in text
