"""The reader: what was simulated comes back bit for bit; every fault is a line with its file."""

import dataclasses
import io
import json
import pickle
import shutil
import struct
import zipfile
import zlib

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from small_dataset import SEQUENCES, simulation_of

import sim.dataset
from pjpdaf.errors import BenchError
from sim.dataset.files.layout import LABELS
from sim.dataset.files.tables import TRUTH_SCHEMA

FIRST = "seq_000000"


@pytest.fixture
def copied(dataset_made, tmp_path):
    """The data set to be damaged: of the first sequence what is read here, the others empty."""
    folder = tmp_path / "copy"
    labels = shutil.ignore_patterns(*(f"{kind}_*" for kind in LABELS), "occlusion_*", "calib")
    shutil.copytree(dataset_made / FIRST, folder / FIRST, ignore=labels)
    shutil.copy(dataset_made / "manifest.json", folder)
    for name in ("seq_000001", "seq_000002"):
        (folder / name).mkdir()
    (folder / FIRST / "float_left").mkdir()
    shutil.copy(dataset_made / FIRST / "float_left/000001.npz", folder / FIRST / "float_left")
    return folder


def same(one, other):
    """Every field of two records, arrays with NaN, type and shape."""
    if dataclasses.is_dataclass(one):
        assert type(one) is type(other)
        for field in dataclasses.fields(one):
            same(getattr(one, field.name), getattr(other, field.name))
    elif isinstance(one, np.ndarray):
        assert (one.dtype, one.shape) == (other.dtype, other.shape)
        np.testing.assert_array_equal(one, other)
    elif isinstance(one, tuple | list):
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            same(a, b)
    else:
        assert one == other
        assert type(one) is type(other)


@pytest.mark.sample(1)
@pytest.mark.parametrize("number", range(len(SEQUENCES)))
def test_it_gives_the_records_of_the_live_simulation(dataset_made, number):
    sequence = sim.dataset.open(dataset_made).sequences[number]
    with simulation_of(number) as live:
        same(live.background(), sequence.background())
        for now, then in zip(live.frames(), sequence.frames(), strict=True):
            same(now, then)
        for view in ("rig", "calibration"):
            for one, other in zip(
                getattr(live, view).cameras, getattr(sequence, view).cameras, strict=True
            ):
                same(one, other)
        for number_of in ("fps", "frame_count", "redrawn"):
            assert getattr(live, number_of) == getattr(sequence, number_of)


def test_a_frame_can_be_had_in_any_order(dataset_made):
    sequence = sim.dataset.open(dataset_made).sequences[1]
    for index in (3, 0, 2):
        same(sequence.frame(index), list(sequence.frames())[index][0])


def test_a_lost_picture_is_none_and_has_no_file(dataset_made):
    sequence = sim.dataset.open(dataset_made).sequences[1]
    lost = [
        (frame.index, view)
        for frame, _ in sequence.frames()
        for view, picture in zip(("left", "right"), frame.pictures, strict=True)
        if picture is None
    ]
    files = {
        (i, v)
        for v in ("left", "right")
        for i in range(sequence.frame_count)
        if not (sequence.folder / v / f"{i + 1:06d}.png").exists()
    }
    assert set(lost) == files


# --- damage --------------------------------------------------------------------------------------


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def bomb(width, height):
    """A PNG of 60 bytes that claims a size."""
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"".join(
        (
            b"\x89PNG\r\n\x1a\n",
            chunk(b"IHDR", header),
            chunk(b"IDAT", zlib.compress(b"\0" * 9)),
            chunk(b"IEND", b""),
        )
    )


def rewritten(path, change):
    pq.write_table(change(pq.read_table(path)), path)


def json_changed(path, change):
    record = json.loads(path.read_text())
    change(record)
    path.write_text(json.dumps(record))


def replaced(column, index, value):
    def change(table):
        rows = table.column(column).to_pylist()
        rows[index] = value
        field = TRUTH_SCHEMA.field(column)
        place = table.schema.get_field_index(column)
        return table.set_column(place, field, pa.array(rows, field.type))

    return change


def flipped(path, at):
    data = bytearray(path.read_bytes())
    data[at] ^= 0xFF
    path.write_bytes(data)


def whole(sequence):
    assert sequence.calibration is not None
    sequence.background()
    list(sequence.frames())


PICTURE = "left/000002.png"


@pytest.mark.parametrize(
    ("file", "damage", "said"),
    [
        (PICTURE, lambda f: f.unlink(), "is missing"),
        (PICTURE, lambda f: f.write_bytes(b""), "is not a PNG"),
        (PICTURE, lambda f: f.write_bytes(f.read_bytes()[:-20]), "damaged"),
        (PICTURE, lambda f: f.write_bytes(f.read_bytes()[:5000]), "damaged"),
        (PICTURE, lambda f: flipped(f, 5000), "damaged"),
        (PICTURE, lambda f: f.write_bytes(bomb(60_000, 60_000)), "60000x60000"),
        (PICTURE, lambda f: f.write_bytes(bomb(0, 60_000)), "0x60000"),
        (PICTURE, lambda f: cv2.imwrite(str(f), np.zeros((48, 64, 3), np.uint8)), "is 64x48"),
        (PICTURE, lambda f: cv2.imwrite(str(f), np.zeros((480, 640), np.uint8)), "3 channels"),
        ("background_right/000001.png", lambda f: f.unlink(), "is missing"),
        ("truth.parquet", lambda f: f.unlink(), "is missing"),
        ("truth.parquet", lambda f: f.write_bytes(f.read_bytes()[:900]), "Parquet"),
        ("truth.parquet", lambda f: f.write_text("frame_index\n0\n"), "Parquet"),
        (
            "truth.parquet",
            lambda f: rewritten(f, lambda t: t.drop_columns(["vx_mps", "merged_with_left"])),
            "lacks the columns merged_with_left, vx_mps",
        ),
        ("truth.parquet", lambda f: rewritten(f, lambda t: t.take([1, 0, 2, *range(3, 18)])), "0"),
        (
            "truth.parquet",
            lambda f: rewritten(f, lambda t: t.take([3, 4, 5, 0, 1, 2, *range(6, 18)])),
            "frame 0: frames must be in order, from 0",
        ),
        ("truth.parquet", lambda f: rewritten(f, lambda t: t.slice(0, 17)), "must have 18 rows"),
        ("truth.parquet", lambda f: rewritten(f, replaced("x_m", 4, None)), "frame 1: times"),
        ("truth.parquet", lambda f: rewritten(f, replaced("stamp_s", 3, None)), "frame 1"),
        ("truth.parquet", lambda f: rewritten(f, replaced("visible_left_px", 7, None)), "frame 2"),
        ("truth.parquet", lambda f: rewritten(f, replaced("events", 0, None)), "frame 0"),
        ("rig.json", lambda f: f.unlink(), "is missing"),
        ("rig.json", lambda f: f.write_text("[" * 100_000 + "]" * 100_000), "is not JSON"),
        ("rig.json", lambda f: f.write_bytes(b'{"fps": "\xff"}'), "is not JSON"),
        ("rig.json", lambda f: f.write_text("[]"), "is not a JSON object"),
        (
            "rig.json",
            lambda f: json_changed(f, lambda r: r.pop("frames")),
            "frames must be a number",
        ),
        ("rig.json", lambda f: json_changed(f, lambda r: r.update(fps=float("nan"))), "fps must"),
        ("rig.json", lambda f: json_changed(f, lambda r: r.update(frames=10**400)), "frames must"),
        (
            "rig.json",
            lambda f: json_changed(f, lambda r: r["cameras"]["left"]["K"][0].__setitem__(0, 1e999)),
            "cameras: the numbers of a camera must be finite",
        ),
        (
            "rig.json",
            lambda f: json_changed(f, lambda r: r["cameras"]["left"].update(R_cw=[[1, 2, 3]] * 3)),
            "R_cw must be a rotation",
        ),
        (
            "rig.json",
            lambda f: json_changed(f, lambda r: r["cameras"]["left"].update(width_px=1e999)),
            "cameras: ",
        ),
        (
            "rig.json",
            lambda f: json_changed(f, lambda r: r["calibration"].pop("right")),
            "calibration: lacks 'right'",
        ),
    ],
)
def test_damage_is_one_line_that_names_the_file(copied, file, damage, said, capfd):
    path = copied / FIRST / file
    damage(path)
    sequence = sim.dataset.open(copied).sequences[0]
    with pytest.raises(BenchError) as caught:
        whole(sequence)
    line = str(caught.value)
    assert line.startswith(f"{path}: ")
    assert said in line
    assert "\n" not in line
    assert not "".join(capfd.readouterr()), "libraries must keep quiet"


@pytest.mark.parametrize("file", ["left/000001.png", "truth.parquet", "rig.json"])
def test_no_link_leads_out(copied, tmp_path, file):
    path = copied / FIRST / file
    elsewhere = path.rename(tmp_path / "elsewhere")
    path.symlink_to(elsewhere)
    with pytest.raises(BenchError, match=r"leads out of the data set.*cp -rL") as caught:
        whole(sim.dataset.open(copied).sequences[0])
    assert str(path) in str(caught.value)


def test_a_link_within_the_data_set_is_followed(copied):
    path = copied / FIRST / "left/000001.png"
    path.rename(path.with_name("moved.png"))
    path.symlink_to("moved.png")
    whole(sim.dataset.open(copied).sequences[0])


NESTED = "[" * 100_000


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda f: f.write_text('{"a": ' + NESTED), "is not JSON"),
        (lambda f: json_changed(f, lambda r: r.update(kind="other")), "not the manifest"),
        (lambda f: json_changed(f, lambda r: r.update(schema=99)), "is of version 99"),
        (lambda f: json_changed(f, lambda r: r.update(sequences=None)), "no list of sequences"),
        (lambda f: json_changed(f, lambda r: r.update(settings={})), "settings.labels"),
        (
            lambda f: json_changed(f, lambda r: r["sequences"][0].update(folder="../seq_000000")),
            "sequences.0: its folder must be named seq_NNNNNN",
        ),
        (
            lambda f: json_changed(f, lambda r: r["sequences"][1].update(folder="/tmp")),
            "sequences.1: its folder",
        ),
        (
            lambda f: json_changed(f, lambda r: r["sequences"][1].update(folder=FIRST)),
            "sequences.1: names seq_000000 a second time",
        ),
    ],
)
def test_a_faulty_manifest_is_one_line(copied, change, said):
    path = copied / "manifest.json"
    change(path)
    with pytest.raises(BenchError) as caught:
        sim.dataset.open(copied)
    assert str(caught.value).startswith(f"{path}: ")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_linked_sequence_is_refused(copied, tmp_path):
    (copied / FIRST).rename(tmp_path / FIRST)
    (copied / FIRST).symlink_to(tmp_path / FIRST)
    with pytest.raises(BenchError, match="seq_000000: is a link"):
        sim.dataset.open(copied)


def test_a_missing_sequence_is_named_but_for_an_unfinished_data_set(copied):
    (copied / "seq_000001").rename(copied / "away")
    with pytest.raises(BenchError, match="seq_000001: is missing"):
        sim.dataset.open(copied)
    json_changed(copied / "manifest.json", lambda r: r.update(complete=False))
    assert [s.name for s in sim.dataset.open(copied).sequences] == [FIRST, "seq_000002"]


def test_what_is_no_data_set_says_so(tmp_path):
    with pytest.raises(BenchError, match=r"is not a data set: has no manifest.json"):
        sim.dataset.open(tmp_path)
    (tmp_path / "rooms").mkdir()
    near = tmp_path / "rooms"
    with pytest.raises(BenchError, match=rf"no such data set; did you mean {near}\?$"):
        sim.dataset.open(tmp_path / "room")


# --- labels in floats ----------------------------------------------------------------------------


class Touched:
    """Unpickling it would leave a mark."""

    def __reduce__(self):
        return print, ("unpickled",)


def npy(array):
    buffer = io.BytesIO()
    np.save(buffer, array, allow_pickle=True)
    return buffer.getvalue()


def zipped(**files):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as held:
        for name, data in files.items():
            held.writestr(f"{name}.npy", data)
    return buffer.getvalue()


def claiming(shape):
    buffer = io.BytesIO()
    header = {"descr": "<f4", "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(buffer, header)
    return buffer.getvalue() + b"\0" * 100


def test_floats_come_back(dataset_made):
    sequence = sim.dataset.open(dataset_made).sequences[0]
    found = sequence.floats(0, 0)
    depth = found["depth_m"]
    assert depth.dtype == np.float32
    known = np.isfinite(depth) & (depth < 6)
    np.testing.assert_allclose(depth[known], sequence.depth_m(0, 0)[known], atol=6e-5)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"PK\x03\x04 nothing more",
        pickle.dumps(Touched()),
        npy(np.zeros((480, 640), np.float32)),
        zipped(depth_m=npy(np.array([[Touched()]], dtype=object))),
        zipped(depth_m=npy(np.zeros((480, 640)))),
        zipped(depth_m=claiming((480_000, 640_000))),
        zipped(depth_m=claiming((480, 640))),
        zipped(depth_m=b"no array"),
        zipped(other=npy(np.zeros((480, 640), np.float32))),
    ],
    ids=["empty", "cut", "pickle", "npy", "objects", "doubles", "bomb", "short", "text", "other"],
)
def test_a_faulty_npz_is_one_line_and_nothing_is_unpickled(copied, data, capfd):
    path = copied / FIRST / "float_left/000001.npz"
    path.write_bytes(data)
    with pytest.raises(BenchError) as caught:
        sim.dataset.open(copied).sequences[0].floats(0, 0)
    assert str(caught.value).startswith(f"{path}: is a damaged NPZ file")
    assert "\n" not in str(caught.value)
    assert not "".join(capfd.readouterr())


def test_an_npz_that_is_cut_short_is_one_line(copied):
    path = copied / FIRST / "float_left/000001.npz"
    data = path.read_bytes()
    for size in (10, len(data) // 2, len(data) - 3):
        path.write_bytes(data[:size])
        with pytest.raises(BenchError, match="damaged NPZ"):
            sim.dataset.open(copied).sequences[0].floats(0, 0)
