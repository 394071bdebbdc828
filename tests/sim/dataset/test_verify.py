"""Every kind of damage is found and named with its file; an undamaged data set has no fault.

The semantic checks are tested with checksums that were written again after the damage: they must
find it by themselves.
"""

import json
import multiprocessing
import re
import shutil

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from pjpdaf.calibration import write_rig
from pjpdaf.errors import BenchError
from scenarios.play.recipe import sized
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.dataset.check.exports.run_lengths import run_lengths
from sim.dataset.check.fault import Fault
from sim.dataset.check.frame.mask_geometry import measured, merged
from sim.dataset.export import coco, mot
from sim.dataset.files import encode
from sim.dataset.files.checksums import sha256_of, text_of
from sim.dataset.files.conventions import conventions
from sim.dataset.files.layout import CHECKSUMS, LABELS
from sim.dataset.files.manifest import SequenceEntry, manifest_record, write_manifest
from sim.dataset.files.tables import OBJECTS_SCHEMA, TRUTH_SCHEMA
from sim.dataset.reader import open_dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.dataset.verify import verify
from sim.dataset.writer import write_sequence
from sim.labels import merged as drawn_merged
from sim.sequence import Simulation

# A dark one of a face that is touched; one through a converging rig with lenses, with lost pictures
# and a wrong calibration; one with shutter skew.
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


@pytest.fixture(scope="module")
def trio(tmp_path_factory):
    """Small pictures, checksums at both levels."""
    folder = tmp_path_factory.mktemp("verify") / "set"
    folder.mkdir()
    entries = []
    for number, (name, seed, overrides) in enumerate(SEQUENCES):
        scenario = load_scenario(name)
        target = folder / f"seq_{number:06d}"
        target.mkdir()
        scene = sized(perform(scenario, seed, {"background_frames": 1, **overrides}), (240, 180))
        with Simulation(scene) as simulation:
            write_sequence(simulation, target, tuple(LABELS), {"test": name})
        entries.append(
            SequenceEntry(
                target.name, name, name, scenario.group, seed, "", "", scene.frames, scene.fps
            )
        )
    finish(folder, entries)
    return folder


@pytest.fixture(scope="module")
def single(trio, tmp_path_factory):
    """Its first sequence alone, with exports."""
    folder = tmp_path_factory.mktemp("verify") / "set"
    shutil.copytree(trio / SEQ, folder / SEQ)
    finish(
        folder, [SequenceEntry(**json.loads((trio / "manifest.json").read_text())["sequences"][0])]
    )
    dataset = open_dataset(folder)
    coco.export(dataset, folder)
    mot.export(dataset, folder)
    resum(folder)
    return folder


def finish(folder, entries):
    record = manifest_record(entries, {"labels": list(LABELS)}, {}, complete=True)
    write_manifest(folder, record)
    (folder / "conventions.json").write_text(json.dumps(conventions()))
    resum(folder)


@pytest.fixture
def copy(single, tmp_path):
    shutil.copytree(single, tmp_path / "copy")
    return tmp_path / "copy"


@pytest.fixture
def copies(trio, tmp_path):
    shutil.copytree(trio, tmp_path / "copy")
    return tmp_path / "copy"


def resum(root):
    """Checksums of what is there now."""
    for folder in (*sorted(root.glob("seq_*")), root):
        (folder / CHECKSUMS).unlink(missing_ok=True)
        files = [path for path in folder.rglob("*") if path.is_file()]
        sums = {path.relative_to(folder).as_posix(): sha256_of(path) for path in files}
        (folder / CHECKSUMS).write_text(text_of(sums))


def found(root):
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


def test_an_undamaged_data_set_has_no_fault(trio, single):
    names = []
    assert verify(single) == []
    assert verify(trio, on_sequence=names.append) == []
    assert names == ["seq_000000", "seq_000001", "seq_000002"]


def test_worker_processes_find_the_same(copies):
    (copies / SEQ / "right" / "000003.png").unlink()
    assert verify(copies, jobs=2, sums=False) == verify(copies, sums=False)


def test_workers_that_are_killed_are_replaced_and_the_verdict_is_complete(copies):
    (copies / SEQ / "right" / "000003.png").unlink()
    wanted = verify(copies, sums=False)
    others, names, killed = set(multiprocessing.active_children()), [], []

    def kill_all_once(name):
        """While the other worker is checking another sequence."""
        names.append(name)
        if not killed:
            killed.extend(set(multiprocessing.active_children()) - others)
            for worker in killed:
                worker.kill()

    assert verify(copies, jobs=2, sums=False, on_sequence=kill_all_once) == wanted
    assert len(killed) == 2
    assert names == ["seq_000000", "seq_000001", "seq_000002"]


def test_a_flipped_byte_is_named(copy):
    path = copy / SEQ / "left" / "000002.png"
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    faults = verify(copy)
    assert files(faults) == [f"{SEQ}/left/000002.png"]
    assert any("SHA-256" in fault.text for fault in faults)


def test_a_damaged_picture_is_named_without_its_checksum(copy):
    path = copy / SEQ / "seg_left" / "000002.png"
    path.write_bytes(path.read_bytes()[:100])
    assert files(found(copy)) == [f"{SEQ}/seg_left/000002.png"]


def test_a_missing_picture_is_one_line(copy):
    (copy / SEQ / "right" / "000003.png").unlink()
    expected = [Fault(f"{SEQ}/right/000003.png", "missing")]
    assert verify(copy) == expected
    assert found(copy) == expected
    assert str(expected[0]) == "seq_000000/right/000003.png: missing"


def test_any_missing_file_is_named(copy):
    names = [
        "amodal_right/000001.png",
        "background_left/000001.png",
        "calib/error_free/intrinsics.yml",
        "calib/extrinsics.yml",
        "correspondence_left/000005.png",
        "events.json",
        "objects.parquet",
        "occlusion_right/000004.png",
        "recipe.json",
    ]
    for name in names:
        (copy / SEQ / name).unlink()
    expected = [Fault(f"{SEQ}/{name}", "missing") for name in names]
    assert found(copy) == expected
    for name in ("truth.parquet", "rig.json"):
        (copy / SEQ / name).unlink()
        assert Fault(f"{SEQ}/{name}", "missing") in found(copy)


def test_a_missing_sequence_is_named(copies):
    shutil.rmtree(copies / "seq_000001")
    assert found(copies) == [Fault("seq_000001", "missing")]


def test_a_file_that_nobody_lists_is_named(copy):
    (copy / SEQ / "left" / "stray.txt").write_text("?")
    assert files(verify(copy)) == [f"{SEQ}/left/stray.txt"]
    (copy / "stray.bin").write_text("?")
    assert "stray.bin" in files(verify(copy))


def test_a_picture_of_no_frame_is_named(copy):
    shutil.copy(copy / SEQ / "left" / "000001.png", copy / SEQ / "left" / "000009.png")
    assert files(found(copy)) == [f"{SEQ}/left/000009.png"]


def test_a_picture_of_another_frame_byte_for_byte_is_named(copy):
    shutil.copy(copy / SEQ / "left" / "000001.png", copy / SEQ / "left" / "000005.png")
    assert files(found(copy)) == [f"{SEQ}/left/000005.png"]


def test_a_link_is_named_and_not_followed(copy, tmp_path):
    outside = tmp_path / "outside.png"
    path = copy / SEQ / "left" / "000001.png"
    shutil.move(path, outside)
    path.symlink_to(outside)
    faults = verify(copy)
    assert files(faults) == [f"{SEQ}/left/000001.png"]
    assert any("link" in fault.text for fault in faults)


def test_exchanged_eyes_are_named(copies):
    """Dark and near skin, through a lens, with shutter skew; lost pictures need not be."""
    expected = set()
    for sequence in open_dataset(copies).sequences:
        exchange(sequence.folder / "left", sequence.folder / "right")
        rows = sequence.truth.iloc[::3]
        for index in rows[rows.arrived_left & rows.arrived_right].frame_index:
            expected |= {f"{sequence.name}/{c}/{index + 1:06d}.png" for c in ("left", "right")}
    assert len(expected) > 16
    assert expected <= set(files(found(copies)))


def test_one_exchanged_pair_is_named(copy):
    exchange(copy / SEQ / "left" / "000004.png", copy / SEQ / "right" / "000004.png")
    faults = found(copy)
    assert files(faults) == [f"{SEQ}/left/000004.png", f"{SEQ}/right/000004.png"]
    assert faults[0].text == "is a picture of the right camera"


def test_exchanged_backgrounds_are_named(copy):
    exchange(copy / SEQ / "background_left", copy / SEQ / "background_right")
    assert files(found(copy)) == [f"{SEQ}/background_{c}/000001.png" for c in ("left", "right")]


def test_exchanged_clean_pictures_are_named(copy):
    exchange(copy / SEQ / "clean_left" / "000002.png", copy / SEQ / "clean_right" / "000002.png")
    assert files(found(copy)) == [f"{SEQ}/clean_{c}/000002.png" for c in ("left", "right")]


def test_a_lone_picture_of_the_wrong_eye_is_named(copy):
    """Its other eye is lost, so that only the background tells."""
    folder = copy / SEQ
    shutil.move(folder / "right" / "000002.png", folder / "left" / "000002.png")

    def lose(row):
        row["arrived_right"] &= row["frame_index"] != 1

    edit_rows(copy, lose)
    assert f"{SEQ}/left/000002.png" in files(found(copy))


@pytest.mark.parametrize("kind", ["depth", "seg", "amodal", "disparity", "correspondence", "float"])
def test_exchanged_labels_are_named(copy, kind):
    exchange(copy / SEQ / f"{kind}_left", copy / SEQ / f"{kind}_right")
    suffix = "npz" if kind == "float" else "png"
    named = files(found(copy))
    for frame in range(1, 6):
        assert any(f"/{kind}_" in file and file.endswith(f"{frame:06d}.{suffix}") for file in named)


@pytest.mark.parametrize("folder", ["calib", "calib/error_free"])
def test_a_wrong_baseline_in_the_calibration_is_named(copy, folder):
    path = copy / SEQ / folder / "extrinsics.yml"
    edit_yml(path, "T", 0, 1e-4)
    faults = found(copy)
    assert files(faults) == [f"{SEQ}/{folder}/extrinsics.yml"]
    assert any(fault.text.startswith("T differs from") for fault in faults)


@pytest.mark.parametrize(
    ("key", "file"),
    [("R", "extrinsics"), ("P2", "extrinsics"), ("Q", "extrinsics"), ("D1", "intrinsics")],
)
def test_a_wrong_matrix_of_the_calibration_is_named(copy, key, file):
    path = copy / SEQ / "calib" / f"{file}.yml"
    edit_yml(path, key, 1, 1e-3)
    assert f"{SEQ}/calib/{file}.yml" in files(found(copy))


def test_a_wrong_baseline_of_the_rig_is_named(copies):
    """In the calibration's files as well, so that they agree with it."""

    def longer(record):
        for key in ("cameras", "calibration"):
            record[key]["right"]["t_cw"][0] *= 1.02

    names = ["seq_000000", "seq_000001", "seq_000002"]
    for name in names:
        edit_json(copies / name / "rig.json", longer)
        sequence = StoredSequence(copies / name, {})
        write_rig(sequence.calibration, copies / name / "calib")
        write_rig(sequence.rig, copies / name / "calib" / "error_free")
    faults = found(copies)
    assert [f"{name}/rig.json" for name in names[:2]] == files(faults)[:2]
    assert all("px off" in fault.text for fault in faults if fault.file.endswith("rig.json"))
    # With shutter skew it cannot be told by keypoints; the disparity does not fit the depth then.
    assert any(file.startswith(names[2]) for file in files(faults))


@pytest.mark.parametrize("place", ["rig.json", "calib/intrinsics.yml"])
def test_a_shifted_principal_point_is_named(copy, place):
    path = copy / SEQ / place
    if place == "rig.json":

        def shift(record):
            for key in ("cameras", "calibration"):
                record[key]["left"]["K"][0][2] += 0.5

        edit_json(path, shift)
    else:
        edit_yml(path, "M1", 2, 0.5)
    assert f"{SEQ}/{place}" in files(found(copy))


def test_boxes_that_count_from_1_are_named(copy):
    def move(row):
        for axis in "xy":
            for camera in ("left", "right"):
                row[f"box_{axis}_{camera}_px"] += 1

    edit_rows(copy, move)
    faults = [fault for fault in found(copy) if fault.file == f"{SEQ}/truth.parquet"]
    assert any("box of right_hand, left view" in fault.text for fault in faults)
    assert all("in 4 more frames" in fault.text for fault in faults)


def test_coco_boxes_that_count_from_1_are_named(copy):
    path = copy / "annotations" / "instances_right.json"

    def move(record):
        for one in record["annotations"]:
            one["bbox"][0] += 1

    edit_json(path, move)
    faults = found(copy)
    assert files(faults) == ["annotations/instances_right.json"]
    assert all(fault.text.startswith("bbox") for fault in faults)


@pytest.mark.parametrize("kind", ["area", "segmentation", "visible_fraction", "lost"])
def test_damaged_coco_annotations_are_named(copy, kind):
    path = copy / "annotations" / "instances_left.json"

    def change(record):
        first, second = record["annotations"][:2]
        if kind == "lost":
            del record["annotations"][0]
        elif kind == "segmentation":
            first[kind], second[kind] = second[kind], first[kind]
        else:
            first[kind] += 1

    edit_json(path, change)
    assert files(found(copy)) == ["annotations/instances_left.json"]


def test_mot_boxes_that_count_from_0_are_named(copy):
    path = copy / "mot" / f"{SEQ}-left" / "gt" / "gt.txt"
    lines = [line.split(",") for line in path.read_text().splitlines()]
    path.write_text("".join(f"{f},{i},{int(x) - 1},{','.join(r)}\n" for f, i, x, *r in lines))
    faults = found(copy)
    assert files(faults) == [f"mot/{SEQ}-left/gt/gt.txt"]
    assert "counted from 1" in faults[0].text


@pytest.mark.parametrize("name", ["gt/gt.txt", "gt/gt_3d.txt", "seqinfo.ini"])
def test_damaged_mot_files_are_named(copy, name):
    path = copy / "mot" / f"{SEQ}-right" / name
    path.write_text(path.read_text().replace("1", "2", 1))
    assert files(found(copy)) == [f"mot/{SEQ}-right/{name}"]


@pytest.mark.parametrize("frames", [(1, 2, 3, 4, 5), (3,)], ids=["all", "one"])
def test_a_wrong_unit_of_depth_is_named(copy, frames):
    paths = [copy / SEQ / "depth_right" / f"{frame:06d}.png" for frame in frames]
    for path in paths:
        edit_png(path, lambda z: (z // 10).astype(np.uint16))
    assert files(found(copy)) == [path.relative_to(copy).as_posix() for path in paths]


def test_a_slightly_wrong_depth_is_named(copy):
    """By 0.2 %: 2 to 3 mm."""
    edit_png(
        copy / SEQ / "depth_left" / "000002.png", lambda z: np.rint(z * 1.002).astype(np.uint16)
    )
    assert files(found(copy)) == [f"{SEQ}/depth_left/000002.png"]


def test_the_mask_of_another_frame_is_named(copy):
    shutil.copy(copy / SEQ / "seg_left" / "000001.png", copy / SEQ / "seg_left" / "000004.png")
    assert files(found(copy)) == [f"{SEQ}/seg_left/000004.png"]


@pytest.mark.parametrize("kind", ["depth", "amodal", "disparity"])
def test_a_label_of_another_frame_is_named(copy, kind):
    folder = copy / SEQ / f"{kind}_right"
    shutil.copy(folder / "000001.png", folder / "000005.png")
    assert f"{SEQ}/{kind}_right/000005.png" in files(found(copy))


def test_values_that_no_label_has_are_named(copy):
    def spoil(picture):
        picture[100:104, 100:104] = 77
        return picture

    for kind in ("seg", "amodal", "occlusion"):
        edit_png(copy / SEQ / f"{kind}_left" / "000003.png", spoil)
    expected = [f"{SEQ}/{kind}_left/000003.png" for kind in ("amodal", "occlusion", "seg")]
    named = files(found(copy))
    assert set(expected) - set(named) <= {f"{SEQ}/amodal_left/000003.png"}


def test_a_disparity_of_another_scale_is_named(copies):
    """Of a rig that is not parallel, whose rectified pair has pixels of its own."""
    edit_png(copies / "seq_000001" / "disparity_left" / "000002.png", lambda d: d // 2)
    named = files(found(copies))
    assert "seq_000001/disparity_left/000002.png" in named
    assert not any("depth" in file for file in named)


@pytest.mark.parametrize(
    ("column", "change"),
    [
        ("visible_fraction_left", lambda v: v * 0.99),
        ("amodal_right_px", lambda v: v + 1),
        ("u_left_px", lambda v: v + 0.5),
        ("surface_x_m", lambda v: v + 0.005),
        ("x_m", lambda v: v + 0.001),
        ("qw", lambda v: v + 0.01),
        ("time_s", lambda v: v * 3),
        ("truncation_left", lambda v: 0.5),
        ("amodal_box_width_left_px", lambda v: v + 1),
        ("keypoints_left_px", lambda v: [[x + 1, y] for x, y in v]),
        ("merged_with_left", lambda v: ["head", "right_hand", "left_hand"]),
        ("occluded_by_right", lambda v: [{"instance": "table", "pixels": 900}]),
    ],
)
def test_a_damaged_column_is_named(copy, column, change):
    def damage(row):
        row[column] = change(row[column])

    edit_rows(copy, damage)
    faults = found(copy)
    named = files(faults)
    if (
        column == "surface_x_m"
    ):  # against it stand two depth pictures: it cannot tell which is right
        assert any("truth.parquet" in str(fault) for fault in faults)
    else:
        assert f"{SEQ}/truth.parquet" in named


def test_a_table_without_a_column_or_with_nothing_in_it_is_named(copy):
    path = copy / SEQ / "truth.parquet"
    table = pq.read_table(path)
    pq.write_table(table.drop_columns(["qx"]), path)
    assert files(found(copy)) == [f"{SEQ}/truth.parquet"]
    pq.write_table(table.slice(0, 3), path)
    assert files(found(copy)) == [f"{SEQ}/truth.parquet"]
    path.write_bytes(b"PAR1")
    assert files(found(copy)) == [f"{SEQ}/truth.parquet"]


def test_a_wrong_count_of_an_object_is_named(copies):
    sequence = copies / "seq_000001"
    path = sequence / "objects.parquet"
    rows = pq.read_table(path).to_pylist()
    assert rows
    rows[0]["visible_left_px"] += 7
    pq.write_table(pa.Table.from_pylist(rows, schema=OBJECTS_SCHEMA), path)
    assert files(found(copies)) == ["seq_000001/objects.parquet"]


def test_events_that_did_not_happen_or_are_missing_are_named(copy):
    def damage(record):
        record["merges"] = [
            {"view": "left", "targets": ["head", "left_hand"], "first_frame": 1, "last_frame": 2}
        ]
        assert record["script"]
        record["script"] = []
        record["ambiguous"] = [{"first_frame": 0, "last_frame": 0}]

    edit_json(copy / SEQ / "events.json", damage)
    faults = found(copy)
    assert files(faults) == [f"{SEQ}/events.json"]
    kinds = {fault.text.partition(":")[0] for fault in faults}
    assert kinds == {"merges", "ambiguous", "script"}


@pytest.mark.parametrize(
    "change",
    [
        lambda m: m.update(total_frames=7),
        lambda m: m.update(complete=False),
        lambda m: m["sequences"].append(m["sequences"][0]),
        lambda m: m["settings"].update(labels="depth"),
        lambda m: m.update(sequences=3),
    ],
)
def test_a_damaged_manifest_is_named(copy, change):
    edit_json(copy / "manifest.json", change)
    assert "manifest.json" in files(found(copy))


def test_without_a_manifest_the_rest_is_still_checked(copy):
    (copy / "manifest.json").write_text("{")
    (copy / SEQ / "right" / "000003.png").unlink()
    named = files(found(copy))
    assert "manifest.json" in named
    assert f"{SEQ}/right/000003.png" in named
    (copy / "manifest.json").unlink()
    assert Fault("manifest.json", "missing") in found(copy)


def test_another_scale_in_the_conventions_is_named(copy):
    edit_json(copy / "conventions.json", lambda c: c["depth"].update(unit_m=1e-3))
    assert files(found(copy)) == ["conventions.json"]


@pytest.mark.parametrize(
    "change",
    [
        lambda r: r["cameras"]["left"].update(K=[[0, 0, 0]] * 3),
        lambda r: r["cameras"]["right"].update(R_cw=[[2, 0, 0], [0, 1, 0], [0, 0, 1]]),
        lambda r: r["cameras"]["right"].update(distortion=[9.0, 9.0, 9.0, 9.0]),
        lambda r: r["cameras"].update(right=r["cameras"]["left"]),
        lambda r: r.update(frames=10_000_000),
        lambda r: r.update(fps=None),
        lambda r: r.update(cameras=[]),
        lambda r: r.update(instances=[{"id": "x"}]),
        lambda r: r.pop("skew_s"),
    ],
)
def test_a_damaged_rig_is_named_and_nothing_is_raised(copy, change):
    edit_json(copy / SEQ / "rig.json", change)
    named = files(verify(copy, sums=False))
    assert f"{SEQ}/rig.json" in named or f"{SEQ}/truth.parquet" in named


def test_no_damage_to_any_file_is_raised(copy):
    """Files of each kind, cut or full of noise in turn."""
    rng = np.random.default_rng(140)
    inside = ("rig.json", "recipe.json", "events.json", "truth.parquet", "objects.parquet")
    deeper = (CHECKSUMS, "calib/extrinsics.yml", "correspondence_left/000001.png")
    npz = "float_left/000002.npz"
    chosen = [copy / SEQ / name for name in (*inside, *deeper, npz)]
    chosen += [copy / "mot" / f"{SEQ}-left" / "gt" / "gt.txt", copy / "conventions.json"]
    chosen += [copy / "annotations" / "instances_left.json"]
    for number, path in enumerate(chosen):
        data = path.read_bytes()
        spoilt = bytearray(data)
        for at in rng.integers(0, len(data), 20):
            spoilt[at] = int(rng.integers(0, 256))
        path.write_bytes(bytes(spoilt) if number % 2 else data[: len(data) // 2])
        assert verify(copy)
        path.write_bytes(data)
    assert verify(copy) == []


def test_a_folder_that_is_no_data_set_is_refused(tmp_path):
    with pytest.raises(BenchError, match="is not a data set"):
        verify(tmp_path)
    with pytest.raises(BenchError, match="not a folder"):
        verify(tmp_path / "nothing")


def test_faults_are_one_printable_line():
    text = str(Fault("a\x1b[31m\nb", "what\x07"))
    assert text.isprintable()


def test_masks_within_the_touch_are_merged_as_the_simulation_has_it():
    rng = np.random.default_rng(141)
    for _ in range(200):
        seg = np.zeros((40, 50), np.uint8)
        for target in (1, 2, 3):
            x, y = rng.integers(0, 40), rng.integers(0, 30)
            seg[y : y + rng.integers(1, 10), x : x + rng.integers(1, 10)] = target
        boxes = np.array([measured(seg == target)[2] for target in (1, 2, 3)])
        wanted = drawn_merged(seg.astype(np.int8) - 1, boxes)
        np.testing.assert_array_equal(merged(seg, boxes), wanted)


def test_run_lengths_are_those_of_pycocotools():
    mask = pytest.importorskip("pycocotools.mask")
    rng = np.random.default_rng(142)
    for share in (0.0, 0.001, 0.3, 0.9, 1.0):
        picture = rng.random((37, 53)) < share
        coded = mask.encode(np.asfortranarray(picture.astype(np.uint8)))
        record = {"size": coded["size"], "counts": coded["counts"].decode()}
        area, centroid, box = run_lengths(record, (53, 37))
        count, middle, wanted = measured(picture)
        assert area == count
        np.testing.assert_allclose(centroid, middle)
        np.testing.assert_array_equal(box, wanted)
