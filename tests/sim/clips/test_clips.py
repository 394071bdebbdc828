"""Clips: what NPZ and CSV files say, and one clear line for each fault."""

# ruff: noqa: E501 - messages are spelled out on one line, as the user sees them

from __future__ import annotations

import io
import json
import pickle
import time
import zipfile
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pjpdaf.errors import BenchError
from sim.clips.clip_files import MAX_BYTES, SHORT, clip_of_csv, load_clip
from sim.clips.clips import ARM_JOINTS, BRIDGED_S, HANDS, JOINTS, clip_of, mirrored

HZ = 30.0
PLAIN = ("head", "left_hand", "right_hand")


def gesture(n=90, joints=JOINTS):
    """Times and places of a person who circles with both hands, (n,), (n, k, 3)."""
    t = np.arange(n) / HZ
    xyz = np.zeros((n, len(joints), 3))
    for k, joint in enumerate(joints):
        side, _, part = joint.partition("_")
        out = {"left": 0.2, "right": -0.2}.get(side, 0.0)
        along = ("", *ARM_JOINTS).index(part) * 0.1
        turn = 2 * np.pi * 0.5 * t + k
        xyz[:, k] = np.column_stack(
            [along + 0.05 * np.cos(turn), out + 0.05 * np.sin(turn), 0.0 * t]
        )
    return t, xyz


def csv_text(t, xyz, joints=PLAIN, time="time_s", comment=""):
    columns = [time, *(f"{joint}_{axis}" for joint in joints for axis in "xyz")]
    rows = [
        ",".join([f"{at:.4f}", *("" if np.isnan(v) else f"{v:.5f}" for v in places.ravel())])
        for at, places in zip(t, xyz, strict=True)
    ]
    return comment + "\n".join([",".join(columns), *rows]) + "\n"


def fault_of(text):
    with pytest.raises(BenchError) as fault:
        clip_of_csv(text, "clip.csv")
    said = str(fault.value)
    assert "\n" not in said
    return said


def save(path, **arrays):
    np.savez_compressed(path, **arrays)
    return path


def npz_arrays(n=90):
    t, xyz = gesture(n)
    short = {long: name for name, long in SHORT.items()}
    names = np.array([short[joint] for joint in JOINTS])
    return {"t": t.astype(np.float32), "joints": names, "xyz": xyz.astype(np.float32)}


def test_npz_and_both_csv_styles_say_the_same(tmp_path):
    t, xyz = gesture()
    arrays = npz_arrays()
    meta = np.array(json.dumps({"name": "mine"}))
    saved = load_clip(save(tmp_path / "a.npz", **arrays, fps=np.float64(HZ), meta=meta))
    bare = load_clip(save(tmp_path / "b.npz", **arrays))
    (tmp_path / "c.csv").write_text(csv_text(t, xyz, JOINTS))
    short = [str(name) for name in arrays["joints"]]
    (tmp_path / "d.CSV").write_text(csv_text(t, xyz, short, "t", '# {"fps": 30}\n'), "utf-8-sig")
    clips = [saved, bare, load_clip(tmp_path / "c.csv"), load_clip(str(tmp_path / "d.CSV"))]
    for clip in clips:
        assert clip.joints == JOINTS
        assert clip.gaps == clip.notes == ()
        np.testing.assert_allclose(clip.times_s, t, atol=1e-4)  # 4 decimals of seconds
        np.testing.assert_allclose(clip.xyz, xyz, atol=1e-5)
    assert clips[0].duration_s == pytest.approx(89 / HZ, abs=1e-4)


def test_head_and_hands_are_enough_and_other_columns_are_not_read():
    t, xyz = gesture(joints=PLAIN)
    text = csv_text(t, xyz)
    lines = text.splitlines()
    wider = "\n".join([lines[0] + ",phase", *(line + ",hold" for line in lines[1:]), ""])
    for given_text in (text, wider, text.replace("\n", "\r\n")):
        clip = clip_of_csv(given_text, "clip.csv")
        assert clip.joints == PLAIN or set(clip.joints) == set(PLAIN)
        np.testing.assert_allclose(clip.path("right_hand"), xyz[:, 2], atol=1e-5)


def test_joints_that_are_never_recorded_are_left_out():
    t, xyz = gesture()
    for joint in ("left_shoulder", "left_elbow", "right_shoulder", "right_elbow"):
        xyz[:, JOINTS.index(joint)] = np.nan
    clip = clip_of("clip", t, JOINTS, xyz)
    assert not clip.has("left_elbow")
    assert clip.has("left_wrist", "right_wrist", *HANDS)


def test_a_palm_is_put_ahead_of_its_wrist_where_the_clip_ends_there():
    t, xyz = gesture()
    joints = tuple(j for j in JOINTS if j != "left_hand")
    clip = clip_of("clip", t, joints, np.delete(xyz, JOINTS.index("left_hand"), axis=1))
    forearm = clip.path("left_wrist") - clip.path("left_elbow")
    ahead = clip.path("left_hand") - clip.path("left_wrist")
    np.testing.assert_allclose(ahead, 0.045 / 0.1545 * forearm, atol=1e-12)
    assert clip.notes == ("left_hand taken 0.29 of the forearm beyond the wrist",)


def test_a_mirrored_clip_exchanges_the_sides_and_twice_mirrored_is_itself():
    t, xyz = gesture()
    clip = clip_of("clip", t, JOINTS, xyz)
    other = mirrored(clip)
    for axis, sign in enumerate((1, -1, 1)):
        np.testing.assert_array_equal(
            other.path("right_hand")[:, axis], sign * clip.path("left_hand")[:, axis]
        )
    assert other.has(*JOINTS)
    again = mirrored(other)
    for joint in JOINTS:
        np.testing.assert_array_equal(again.path(joint), clip.path(joint))


@pytest.mark.parametrize("missing_s", [0.2, 0.5, 1.5])
def test_short_gaps_are_bridged_without_jumps_and_reported(missing_s):
    t, xyz = gesture(150, PLAIN)
    k = int(missing_s * HZ)
    true = xyz.copy()
    xyz[60 : 60 + k, 1] = np.nan
    clip = clip_of("clip", t, PLAIN, xyz)
    (gap,) = clip.gaps
    assert gap.joint == "left_hand"
    assert gap.from_s == pytest.approx(t[59])
    assert gap.to_s == pytest.approx(t[60 + k])
    path = clip.path("left_hand")
    # Never further from the truth than the circle that the hand goes round, and no faster.
    assert np.abs(path - true[:, 1]).max() < 0.1
    assert clip.speeds("left_hand").max() < 1.6 * np.pi * 0.05
    shared = np.ones(150, dtype=bool)
    shared[60 : 60 + k] = False
    np.testing.assert_array_equal(path[shared], true[shared, 1])


def test_the_clip_is_cut_to_where_both_hands_are():
    t, xyz = gesture(120, PLAIN)
    xyz[:15, 1] = np.nan
    xyz[100:, 2] = np.nan
    clip = clip_of("clip", t, PLAIN, xyz)
    assert len(clip.times_s) == 85
    assert clip.times_s[0] == 0.0
    assert clip.gaps == ()
    assert clip.notes == ("1.17 s without both hands at the ends are left out",)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t, x: x[40:, 1].__setitem__((slice(None), 0), 0.9), "left_hand jumps by 0."),
        (lambda t, x: t.__setitem__(5, t[4]), "times must increase, but frame 5 is at 0.1333 s after 0.1333 s"),
        (lambda t, x: t.__setitem__(7, np.nan), "the time of frame 7 is not a number"),
        (lambda t, x: x[9, 2].__setitem__(1, np.inf), "right_hand at 0.300 s (frame 9): y is inf m, more than 3 m from the shoulders; are the units metres?"),
        (lambda t, x: x.__imul__(1000), "head at 0.000 s (frame 0): x is 50 m, more than 3 m from the shoulders; are the units metres?"),
        (lambda t, x: x[9, 2].__setitem__(1, np.nan), "right_hand at 0.300 s (frame 9): y is not recorded, but the others are"),
        (lambda t, x: x[:, 2].fill(np.nan), "right_hand is never recorded; the clip has: head, left_hand"),
        (lambda t, x: (x[1:, 2].fill(np.nan), x[:1, 1].fill(np.nan)), "both hands are recorded together in 0 frames; 2 are needed"),
        (lambda t, x: x[2:, 2].fill(np.nan), "both hands are recorded for 0.033 s; 0.1 s are needed"),
    ],
)  # fmt: skip
def test_impossible_numbers_are_named(change, said):
    t, xyz = gesture(150, PLAIN)
    change(t, xyz)
    with pytest.raises(BenchError) as fault:
        clip_of("clip.npz", t, PLAIN, xyz)
    assert str(fault.value).startswith(f"clip.npz: {said}")


def test_a_jump_is_named_with_joint_time_and_size():
    t, xyz = gesture(150, PLAIN)
    xyz[40:, 2, 2] = 0.6
    with pytest.raises(BenchError) as fault:
        clip_of("clip", t, PLAIN, xyz)
    assert str(fault.value) == (
        "clip: right_hand jumps by 0.60 m within 33 ms at 1.300 s (frame 39), 18 m/s; "
        "at most 12 m/s can be played"
    )


def test_long_gaps_of_hands_are_refused_with_their_list_and_of_others_bridged():
    t, xyz = gesture(400, PLAIN)
    xyz[30:100, 1] = np.nan
    xyz[200:300, 1] = np.nan
    xyz[50:55, 2] = np.nan
    with pytest.raises(BenchError) as fault:
        clip_of("clip", t, PLAIN, xyz)
    assert str(fault.value) == (
        "clip: not recorded: left_hand 0.97-3.33 s, left_hand 6.63-10.00 s; "
        "gaps of up to 2 s are bridged: cut the clip there"
    )
    t, xyz = gesture(400, PLAIN)
    xyz[30:300, 0] = np.nan
    assert clip_of("clip", t, PLAIN, xyz).gaps[0].to_s - t[30] > BRIDGED_S


@pytest.mark.parametrize("n", [0, 1])
def test_a_clip_of_one_frame_is_no_motion(n):
    t, xyz = gesture(n, PLAIN)
    with pytest.raises(BenchError, match=f"clip: has {n} frames; a motion needs at least 2"):
        clip_of("clip", t, PLAIN, xyz)


# --- CSV -----------------------------------------------------------------------------------------


def test_csv_faults_name_line_and_column():
    t, xyz = gesture(30, PLAIN)
    lines = csv_text(t, xyz, comment="# made by hand\n").splitlines()

    def with_line(number, text):
        return "\n".join([*lines[: number - 1], text, *lines[number:]]) + "\n"

    assert fault_of(with_line(5, "1,2,3")) == "clip.csv:5: has 3 cells, the header 10"
    assert fault_of(with_line(5, lines[4] + ",9")) == "clip.csv:5: has 11 cells, the header 10"
    cells = lines[6].split(",")
    wrong = ",".join([*cells[:4], "O.2", *cells[5:]])
    assert fault_of(with_line(7, wrong)) == "clip.csv:7: left_hand_x: must be a number, got 'O.2'"
    twice = lines[1].replace("head_y", "head_x")
    assert fault_of(with_line(2, twice)) == "clip.csv:2: column head_x is there twice"
    short = lines[1].replace("left_hand_y", "lefthand_y").replace("time_s", "time")
    assert fault_of(with_line(2, short)) == "clip.csv:2: columns are missing: time_s, left_hand_y"
    part = lines[1].replace("head_x", "left_elbow_x")
    assert fault_of(with_line(2, part)) == (
        "clip.csv:2: columns are missing: head_x, left_elbow_y, left_elbow_z"
    )
    assert fault_of(with_line(4, 'a"b,"c"d')).startswith("clip.csv:4: is not CSV: ")
    assert fault_of("").startswith(
        "clip.csv:1: columns are missing: time_s, head_x, head_y, head_z"
    )
    assert fault_of(lines[1]) == "clip.csv: has 0 frames; a motion needs at least 2"


@settings(max_examples=150, deadline=None)
@given(text=st.text(alphabet="time_shandlrxyz,.0123456789-#\n\"' ", max_size=120))
def test_no_text_is_read_or_breaks_but_with_one_line(text):
    fault_of(text)


def test_files_that_cannot_be_clips(tmp_path):
    (tmp_path / "bytes.csv").write_bytes(b"time_s,head_x\n\xff\xfe")
    (tmp_path / "folder.csv").mkdir()
    with (tmp_path / "huge.csv").open("wb") as stream:
        stream.truncate(MAX_BYTES + 1)
    for name, said in {
        "bytes.csv": "is not UTF-8 text (byte 14)",
        "folder.csv": "is not a file",
        "absent.csv": "no such file",
        "huge.csv": "is larger than 64 MiB",
        "clip.txt": "a clip must end in .npz, .csv, .bvh",
    }.items():
        with pytest.raises(BenchError) as fault:
            load_clip(tmp_path / name)
        assert str(fault.value) == f"{tmp_path / name}: {said}"


def test_a_file_that_is_written_again_is_read_again(tmp_path):
    t, xyz = gesture(60, PLAIN)
    file = tmp_path / "clip.csv"
    file.write_text(csv_text(t, xyz))
    first = load_clip(file)
    file.write_text(csv_text(t[:50], xyz[:50]))
    assert len(load_clip(file).times_s) == 50 < len(first.times_s)


# --- NPZ -----------------------------------------------------------------------------------------


def npz_fault(path):
    with pytest.raises(BenchError) as fault:
        load_clip(path)
    said = str(fault.value)
    assert "\n" not in said
    return said.removeprefix(f"{path}: ")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"t": None}, "has no array t; it has: joints, xyz"),
        ({"t": np.zeros((90, 2))}, "t must be (frames,) and xyz (frames, 9 joints, 3), got (90, 2) and (90, 9, 3)"),
        ({"t": np.zeros(80)}, "t must be (frames,) and xyz (frames, 9 joints, 3), got (80,) and (90, 9, 3)"),
        ({"t": np.array(3.0)}, "t must be (frames,) and xyz (frames, 9 joints, 3), got () and (90, 9, 3)"),
        ({"t": np.array(["a"] * 90)}, "t must hold numbers, got <U1 (90,)"),
        ({"joints": np.arange(9)}, "joints must be a list of names, got int64 (9,)"),
        ({"joints": np.array(["tail"] * 9)}, "joints: 'tail' is none of head, lsho, lelb, lwri, lhand, rsho, relb, rwri, rhand"),
        ({"joints": np.array(["head"] * 9)}, "joints: 'head' is there twice"),
        ({"xyz": np.array([{"a": 1}])}, "holds pickled Python objects, which could run code and are not read; save plain arrays"),
    ],
)  # fmt: skip
def test_npz_faults_are_named(tmp_path, change, said):
    arrays = {k: v for k, v in {**npz_arrays(), **change}.items() if v is not None}
    assert npz_fault(save(tmp_path / "clip.npz", **arrays)) == said


def test_damaged_npz_files_are_one_line(tmp_path):
    good = save(tmp_path / "good.npz", **npz_arrays()).read_bytes()
    file = tmp_path / "bad.npz"
    rng = np.random.default_rng(1)
    for cut in (0, 3, 40, len(good) // 2, len(good) - 5):
        file.write_bytes(good[:cut])
        assert "damaged" in npz_fault(file)
    read = 0
    for _ in range(60):
        data = bytearray(good)
        for at in rng.integers(0, len(good), 3):
            data[at] ^= 1 << int(rng.integers(8))
        file.write_bytes(data)
        said = outcome(file)
        read += said == "read"  # bits of a time stamp or the like
        assert "\n" not in said
    assert read < 40


def outcome(path):
    try:
        load_clip(path)
    except BenchError as fault:
        return str(fault)
    return "read"


def test_a_pickle_that_calls_itself_npz_is_not_run(tmp_path):
    class Trap:
        def __reduce__(self):
            return (exec, ("raise SystemExit('the pickle ran')",))

    file = tmp_path / "trap.npz"
    file.write_bytes(pickle.dumps(Trap()))
    assert "damaged" in npz_fault(file)


def test_an_npz_that_unpacks_to_gigabytes_is_refused_unread(tmp_path):
    file = tmp_path / "bomb.npz"
    zeros = io.BytesIO()
    np.save(zeros, np.zeros(1 << 22))
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for k in range(9):
            archive.writestr(f"a{k}.npy", zeros.getvalue())
    assert file.stat().st_size < 1 << 20
    assert npz_fault(file) == "is larger than 256 MiB unpacked"


def test_speeds_are_steps_over_time():
    t, xyz = gesture(90, PLAIN)
    clip = clip_of("clip", t, PLAIN, xyz)
    slow = [np.linalg.norm(b - a) * HZ for a, b in pairwise(xyz[:, 1])]
    np.testing.assert_allclose(clip.speeds("left_hand"), slow)


def test_a_csv_of_sixty_thousand_columns_is_refused_at_once(tmp_path):
    names = ["t", *(f"{j}_{a}" for j in ("head", "lhand", "rhand") for a in "xyz")]
    names += [f"column{k}" for k in range(60_000)]
    file = tmp_path / "wide.csv"
    file.write_text(",".join(names) + "\n" + ",".join("0" * len(names)) + "\n")
    start = time.process_time()
    with pytest.raises(BenchError, match=r"wide\.csv:1: has more than 10000 columns"):
        load_clip(file)
    assert time.process_time() - start < 5.0  # comparing each with each took minutes
