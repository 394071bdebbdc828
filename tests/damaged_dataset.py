"""A data set of three small sequences, and damage to copies of it."""

import json
import re
import shutil

import cv2
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from shared import copied, shared

from scenarios.play.recipe import sized
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.dataset.export import coco, mot
from sim.dataset.files import encode
from sim.dataset.files.checksums import sha256_of, text_of
from sim.dataset.files.conventions import conventions
from sim.dataset.files.layout import CHECKSUMS, LABELS, sequence_name
from sim.dataset.files.manifest import SequenceEntry, manifest_record, write_manifest
from sim.dataset.files.tables import TRUTH_SCHEMA
from sim.dataset.reader import open_dataset
from sim.dataset.verify import verify
from sim.dataset.writer import write_sequence
from sim.sequence import Simulation

SIZE_PX = (192, 144)
# A dark sequence of a face that is touched, near skin all around; a converging rig with lenses,
# lost pictures and a wrong calibration; shutter skew.
SEQUENCES = (
    (
        "touch_face",
        116,
        {"frames": 5, "fps": 1, "noise_sd": 12, "exposure": -1.5, "near_skin": "all"},
    ),
    (
        "pass_object",
        132,
        {
            "frames": 5,
            "fps": 1,
            "lens_k1": -0.15,
            "lens_k2": 0.03,
            "vergence": 0.06,
            "baseline": 0.15,
            "dropped": 10,
            "jitter": 20,
            "calibration_rot_y": 0.5,
            "jpeg_quality": 60,
        },
    ),
    ("clap", 133, {"frames": 5, "fps": 1, "shutter_skew": 30, "exposure_time": 20}),
)
SEQ = "seq_000000"
PLAIN = ("depth", "seg")  # layers of `plain`


def make(root):
    """`trio`: three sequences; `single`: the first, with exports; `plain`: few layers of that."""
    trio, single = root / "trio", root / "single"
    entries = []
    for number, (name, seed, overrides) in enumerate(SEQUENCES):
        scenario = load_scenario(name)
        target = trio / sequence_name(number)
        target.mkdir(parents=True)
        scene = sized(perform(scenario, seed, {"background_frames": 1, **overrides}), SIZE_PX)
        with Simulation(scene) as simulation:
            write_sequence(simulation, target, tuple(LABELS), {"test": name})
        entries.append(
            SequenceEntry(
                target.name, name, name, scenario.group, seed, "", "", scene.frames, scene.fps
            )
        )
    finish(trio, entries)
    shutil.copytree(trio / SEQ, single / SEQ)
    finish(single, entries[:1])
    dataset = open_dataset(single)
    coco.export(dataset, single)
    mot.export(dataset, single)
    resum(single)
    layers = [name for label in LABELS if label not in PLAIN for name in LABELS[label]]
    shutil.copytree(single, root / "plain", ignore=shutil.ignore_patterns(*layers))
    edit_json(
        root / "plain" / "manifest.json",
        lambda record: record["settings"].update(labels=list(PLAIN)),
    )
    resum(root / "plain")


@pytest.fixture(scope="session")
def trio(tmp_path_factory):
    """Three sequences with checksums at both levels; read only."""
    return shared(tmp_path_factory, "damaged", make) / "trio"


@pytest.fixture(scope="session")
def single(tmp_path_factory):
    """The first sequence alone, with exports; read only."""
    return shared(tmp_path_factory, "damaged", make) / "single"


@pytest.fixture(scope="session")
def plain(tmp_path_factory):
    """`single` without most layers, whose check takes most of the time; read only."""
    return shared(tmp_path_factory, "damaged", make) / "plain"


plain_copy = copied("plain")
copy = copied("single")
copies = copied("trio")


def finish(folder, entries):
    record = manifest_record(entries, {"labels": list(LABELS)}, {}, complete=True)
    write_manifest(folder, record)
    (folder / "conventions.json").write_text(json.dumps(conventions()))
    resum(folder)


def resum(root):
    """Checksums of what is there now."""
    for folder in (*sorted(root.glob("seq_*")), root):
        (folder / CHECKSUMS).unlink(missing_ok=True)
        files = [path for path in folder.rglob("*") if path.is_file()]
        sums = {path.relative_to(folder).as_posix(): sha256_of(path) for path in files}
        (folder / CHECKSUMS).write_text(text_of(sums))


def faults_of(root):
    """Faults of a data set whose checksums are right again."""
    resum(root)
    return verify(root)


def files(faults):
    return sorted({fault.file for fault in faults})


def edit_png(path, change):
    picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    path.write_bytes(encode.png(change(picture)))


def edit_rows(root, change, name="truth.parquet", schema=TRUTH_SCHEMA):
    path = root / SEQ / name
    rows = pq.read_table(path).to_pylist()
    for row in rows:
        change(row)
    pq.write_table(pa.Table.from_pylist(rows, schema=schema), path)


def edit_json(path, change):
    record = json.loads(path.read_text())
    change(record)
    path.write_text(json.dumps(record))


def exchange(first, second):
    between = first.with_name("between")
    first.rename(between)
    second.rename(first)
    between.rename(second)


def edit_yml(path, key, number, by):
    """Add to one number of a matrix in an OpenCV file."""

    def change(match):
        words = match[2].split(",")
        words[number] = f" {float(words[number]) + by!r}"
        return f"{match[1]}{','.join(words)}]"

    text, count = re.subn(
        rf"(?s)(\n{key}:.*?data: \[)([^\]]*)\]", change, path.read_text(), count=1
    )
    assert count == 1
    path.write_text(text)
