"""BVH: kinematics, rigs and units of all kinds give one motion; faults are one line with their place."""

# ruff: noqa: E501 - messages are spelled out on one line, as the user sees them

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from pjpdaf.errors import BenchError
from sim.clips.bvh import UNITS_M, clip_of_bvh
from sim.clips.bvh_skeleton import read_bvh
from sim.clips.clip_files import load_clip

HZ = 30.0
# name, parent, offset [m] in a T-pose: x to the person's left, y up, z forward.
BONES = (
    ("Hips", None, (0.0, 0.95, 0.0)),
    ("Spine", "Hips", (0.0, 0.20, 0.0)),
    ("Neck", "Spine", (0.0, 0.30, 0.0)),
    ("Head", "Neck", (0.0, 0.12, 0.0)),
    ("LeftShoulder", "Spine", (0.05, 0.25, 0.0)),
    ("LeftArm", "LeftShoulder", (0.13, 0.0, 0.0)),
    ("LeftForeArm", "LeftArm", (0.28, 0.0, 0.0)),
    ("LeftHand", "LeftForeArm", (0.26, 0.0, 0.0)),
    ("LeftHandThumb1", "LeftHand", (0.03, 0.0, 0.03)),
    ("LeftHandMiddle1", "LeftHand", (0.10, 0.0, 0.0)),
    ("RightShoulder", "Spine", (-0.05, 0.25, 0.0)),
    ("RightArm", "RightShoulder", (-0.13, 0.0, 0.0)),
    ("RightForeArm", "RightArm", (-0.28, 0.0, 0.0)),
    ("RightHand", "RightForeArm", (-0.26, 0.0, 0.0)),
    ("RightHandThumb1", "RightHand", (-0.03, 0.0, 0.03)),
    ("RightHandMiddle1", "RightHand", (-0.10, 0.0, 0.0)),
)
FINGERS = ("LeftHandThumb1", "LeftHandMiddle1", "RightHandThumb1", "RightHandMiddle1")
ENDS = {"Head": (0.0, 0.20, 0.0)}


def angles(n=60):
    """Rotations by joint, (n, 3) rotation vectors: both arms hang forward and gesture."""
    t = np.arange(n) / HZ
    zero = 0.0 * t
    swing = 0.4 * np.sin(2 * np.pi * 0.7 * t)
    return {
        "Spine": np.column_stack([zero, 0.2 * swing, zero]),
        "LeftArm": np.column_stack([0.3 + swing, zero, zero - 1.1]),
        "LeftForeArm": np.column_stack([zero, zero - 1.0 - swing, zero]),
        "LeftHand": np.column_stack([zero, swing, zero]),
        "RightArm": np.column_stack([0.2 - swing, zero, zero + 1.1]),
        "RightForeArm": np.column_stack([zero, zero + 1.2 + 0.5 * swing, zero]),
    }


def bvh(
    bones=BONES,
    ends=ENDS,
    order="ZXY",
    unit_m=1.0,
    rename=str,
    n=60,
    walk=None,
    turned=None,
    spot="",
    given=None,
):
    """A BVH text. walk (n, 3) [m]: of the hips; turned (n,) [rad]: about the vertical."""
    turns = {k: v[:n] for k, v in (angles(n) if given is None else given).items()}
    if turned is not None:
        turns["Hips"] = np.column_stack([0 * turned, turned, 0 * turned])
    lines, columns = ["HIERARCHY"], []

    def offset(xyz):
        return "OFFSET " + " ".join(f"{v / unit_m:.9f}" for v in xyz)

    def write(name, depth):
        pad = "\t" * depth
        _, parent, at = next(b for b in bones if b[0] == name)
        lines.append(f"{pad}{'JOINT' if parent else 'ROOT'} {rename(name)}")
        lines.extend([pad + "{", f"{pad}\t{offset(at)}"])
        kinds = [] if parent else [f"{a}position" for a in "XYZ"]
        kinds += [f"{axis}rotation" for axis in order]
        lines.append(f"{pad}\tCHANNELS {len(kinds)} {' '.join(kinds)}")
        if not parent:
            columns.append(
                (np.array(at) + (0 if walk is None else walk) + np.zeros((n, 3))) / unit_m
            )
        euler = Rotation.from_rotvec(turns.get(name, np.zeros((n, 3)))).as_euler(
            order, degrees=True
        )
        columns.append(euler)
        for child in [b[0] for b in bones if b[1] == name]:
            write(child, depth + 1)
        if name in ends:
            lines.extend(
                [
                    f"{pad}\tEnd {spot or 'Site'}",
                    pad + "\t{",
                    f"{pad}\t\t{offset(ends[name])}",
                    pad + "\t}",
                ]
            )
        lines.append(pad + "}")

    write("Hips", 0)
    lines += ["MOTION", f"Frames: {n}", f"Frame Time: {1 / HZ:.8f}"]
    lines += [" ".join(f"{v:.7f}" for v in row) for row in np.hstack(columns)]
    return "\n".join(lines) + "\n"


def places_by_hand(turns, n=60):
    """Joint -> (n, 3), by walking up the chain of each joint with scipy's rotations."""
    offsets = {name: (parent, np.array(at)) for name, parent, at in BONES}
    found = {}
    for name in offsets:
        place, joint = np.zeros((n, 3)), name
        while joint is not None:
            parent, at = offsets[joint]
            place = place + at
            if parent is not None:
                place = Rotation.from_rotvec(turns.get(parent, np.zeros((n, 3)))).apply(place)
            joint = parent
        found[name] = place
    return found


@pytest.mark.parametrize("order", ["ZXY", "XYZ", "YXZ", "ZYX"])
def test_kinematics_are_those_of_a_slow_walk_up_the_chain_in_any_channel_order(order):
    # Offsets are in a parent's frame, so a joint's own turn moves only what hangs below it.
    skeleton = read_bvh(bvh(order=order), "clip.bvh")
    positions, _ = skeleton.places()
    slow = places_by_hand(angles())
    for index, node in enumerate(skeleton.nodes):
        np.testing.assert_allclose(positions[:, index], slow[node.name], atol=1e-6)


def test_the_clip_is_in_the_torso_s_frame():
    clip = clip_of_bvh(bvh(), "clip.bvh")
    assert (clip.path("left_shoulder")[:, 1] > 0.15).all()
    assert (clip.path("right_shoulder")[:, 1] < -0.15).all()
    assert (clip.path("head")[:, 2] > 0.2).all()
    middle = 0.5 * (clip.path("left_shoulder") + clip.path("right_shoulder"))
    np.testing.assert_allclose(middle.mean(axis=0), 0.0, atol=2e-3)
    slow = places_by_hand(angles())
    # File x is the person's left, y up, z forward.
    across = slow["LeftHand"] - slow["RightHand"]
    ours = clip.path("left_wrist") - clip.path("right_wrist")
    # The mean heading of a torso that sways is not quite straight ahead.
    np.testing.assert_allclose(ours, across[:, [2, 0, 1]], atol=0.03)
    palm = slow["LeftHand"] + 0.8 * (slow["LeftHandMiddle1"] - slow["LeftHand"])
    assert np.linalg.norm(palm - slow["LeftHand"], axis=1) == pytest.approx(
        np.linalg.norm(clip.path("left_hand") - clip.path("left_wrist"), axis=1)
    )


def same(text, rel=1e-5):
    first, second = clip_of_bvh(bvh(), "a.bvh"), clip_of_bvh(text, "b.bvh")
    assert first.joints == second.joints
    np.testing.assert_allclose(second.xyz, first.xyz, atol=rel)


@pytest.mark.parametrize("unit", UNITS_M)
def test_the_unit_is_told_by_the_arm_and_said(unit):
    text = bvh(unit_m=UNITS_M[unit])
    same(text)
    said = clip_of_bvh(text, "clip.bvh").notes[0]
    assert said.startswith(f"unit taken to be {unit}: the arm is ")


def test_a_unit_that_is_given_is_used():
    clip = clip_of_bvh(bvh(unit_m=0.01), "clip.bvh", unit_m=0.011)
    assert clip.notes[0] == "unit 0.011 m, as given"
    np.testing.assert_allclose(clip.xyz, 1.1 * clip_of_bvh(bvh(), "clip.bvh").xyz, atol=1e-5)


POSER = {"Hand": "Hand", "ForeArm": "ForeArm", "Shoulder": "Collar", "Arm": "Shldr"}


def poser(name):
    for side, letter in (("Left", "l"), ("Right", "r")):
        if name.startswith(side):
            rest = name.removeprefix(side)
            return letter + POSER.get(rest, rest)
    return name.lower()


def max_style(name):
    for side in ("Left", "Right"):
        if name.startswith(side):
            return f"Bip01 {side[0]} {name.removeprefix(side)}"
    return f"Bip01 {name}"


def suffix(name):
    for side in ("Left", "Right"):
        if name.startswith(side):
            return f"{name.removeprefix(side).lower()}_{side[0].lower()}"
    return name.lower()


def wrists(name):
    return {"LeftHand": "LeftWrist", "RightHand": "RightWrist", "LeftForeArm": "LeftElbow"}.get(
        name, name
    )


@pytest.mark.parametrize(
    "rename",
    [lambda n: f"mixamorig:{n}", lambda n: f"mixamorig{n}", poser, max_style, suffix, wrists,
     lambda n: suffix(n).replace("_", "."), lambda n: n.upper()],
)  # fmt: skip
def test_rigs_of_any_naming_give_the_same_clip(rename):
    same(bvh(rename=rename))


def test_twist_joints_within_the_forearm_are_not_elbows():
    split = []
    for name, parent, at in BONES:
        if name.endswith("Hand") and parent:
            side = name.removesuffix("Hand")
            split.append((f"{side}ForeArmRoll", f"{side}ForeArm", tuple(0.5 * v for v in at)))
            split.append((name, f"{side}ForeArmRoll", tuple(0.5 * v for v in at)))
        else:
            split.append((name, parent, at))
    same(bvh(bones=tuple(split)))


def test_without_fingers_palms_are_put_ahead_of_the_wrists():
    bones = tuple(bone for bone in BONES if bone[0] not in FINGERS)
    clip = clip_of_bvh(bvh(bones=bones), "clip.bvh")
    assert any("no fingers: left palm put 0.29 of the forearm ahead" in note for note in clip.notes)
    for side in ("left", "right"):
        ahead = clip.path(f"{side}_hand") - clip.path(f"{side}_wrist")
        forearm = clip.path(f"{side}_wrist") - clip.path(f"{side}_elbow")
        np.testing.assert_allclose(ahead, 0.2913 * forearm, atol=1e-4)
    # An End Site turns with the hand, which the forearm does not.
    ends = {**ENDS, "LeftHand": (0.18, 0.0, 0.0), "RightHand": (-0.18, 0.0, 0.0)}
    turned = clip_of_bvh(bvh(bones=bones, ends=ends, spot="site"), "clip.bvh")
    full = clip_of_bvh(bvh(), "clip.bvh")
    np.testing.assert_allclose(turned.path("left_hand"), full.path("left_hand"), atol=0.005)


def test_walking_and_turning_about_does_not_move_the_gesture():
    n = 600
    t = np.arange(n) / HZ
    given = {k: np.tile(v, (10, 1)) for k, v in angles(60).items()}
    given |= angles(n)
    still = clip_of_bvh(bvh(n=n, given=given), "a.bvh")
    walk = np.column_stack([0.2 * t, 0 * t, -0.1 * t])
    moved = clip_of_bvh(bvh(n=n, given=given, walk=walk, turned=0.12 * t), "b.bvh")
    for joint in ("left_hand", "right_hand", "head"):
        off = np.linalg.norm(moved.path(joint) - still.path(joint), axis=1)[100:-100]
        assert off.max() < 0.02


@pytest.mark.parametrize("up", ["y", "z"])
def test_up_is_where_the_shoulders_are(up):
    text = bvh()
    if up == "z":
        quarter = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])  # y -> z, z -> -y
        bones = tuple((n, p, tuple(quarter @ np.array(at))) for n, p, at in BONES)
        ends = {k: tuple(quarter @ np.array(v)) for k, v in ENDS.items()}
        text = bvh(bones=bones, ends=ends, given={k: v @ quarter.T for k, v in angles().items()})
    same(text)


def test_a_bind_pose_at_the_start_is_left_out():
    given = {k: np.vstack([np.zeros((1, 3)), v]) for k, v in angles().items()}
    clip = clip_of_bvh(bvh(n=61, given=given), "clip.bvh")
    assert len(clip.times_s) == 60
    assert POSE_NOTE in clip.notes
    same(bvh(n=61, given=given))


POSE_NOTE = "the first frame is a pose of its own (bind or T pose) and is left out"


def test_a_t_pose_at_the_start_is_left_out_though_its_angles_are_not_zero():
    given = {}
    for joint, turns in angles().items():
        at_first = {"Spine": (0.03, 0.0, 0.01), "LeftArm": (0.0, 0.1, 0.0)}.get(
            joint, (0.0, 0.0, 0.0)
        )
        given[joint] = np.vstack([[at_first], turns])
    clip = clip_of_bvh(bvh(n=61, given=given), "clip.bvh")
    assert POSE_NOTE in clip.notes
    assert len(clip.times_s) == 60
    # A first frame like all others stays.
    assert POSE_NOTE not in clip_of_bvh(bvh(), "clip.bvh").notes


@pytest.mark.parametrize("frame_time", ["1e-300", "1e-7", "0.0009", "-1", "inf", "nan"])
def test_frame_times_of_no_camera_are_refused_at_once(frame_time):
    text = bvh().replace("Frame Time: 0.03333333", f"Frame Time: {frame_time}")
    assert "Frame Time must be from 0.001 to 10 s" in fault_of(text)


ROKOKO = {"LeftForeArm": "LeftForearm", "RightForeArm": "RightForearm"}
NEURON = {
    "LeftHandMiddle1": "LeftInHandMiddle", "RightHandMiddle1": "RightInHandMiddle",
    "LeftHandThumb1": "LeftHandThumb1", "RightHandThumb1": "RightHandThumb1",
}  # fmt: skip
CMU = {
    "Hips": "root", "Spine": "lowerback", "Neck": "upperneck", "Head": "head",
    **{
        f"{side}{ours}": f"{side[0].lower()}{theirs}"
        for side in ("Left", "Right")
        for ours, theirs in (
            ("Shoulder", "clavicle"), ("Arm", "humerus"), ("ForeArm", "radius"), ("Hand", "wrist"),
            ("HandMiddle1", "fingers"), ("HandThumb1", "thumb"),
        )
    },
}  # fmt: skip


@pytest.mark.parametrize(
    "names",
    [ROKOKO, NEURON, CMU, {"Hips": "hip", "LeftHand": "Robot_LeftHand", "RightHand": "Robot_RightHand"}],
    ids=["rokoko", "perception neuron", "cmu asf", "prefixed"],
)  # fmt: skip
def test_joints_as_the_exports_of_motion_capture_name_them(names):
    same(bvh(rename=lambda name: names.get(name, name)))


def test_a_clip_is_judged_only_where_it_is_played():
    given = {k: v.copy() for k, v in angles(120).items()}
    given["LeftArm"][100:] += 1.5  # the actor steps out of the suit
    text = bvh(n=120, given=given)
    assert "jumps by" in fault_of(text)
    clip = clip_of_bvh(text, "clip.bvh", judged_s=(0.0, 2.0))
    assert clip.duration_s == pytest.approx(119 / HZ, abs=0.05)
    with pytest.raises(BenchError, match="jumps by"):
        clip_of_bvh(text, "clip.bvh", judged_s=(2.0, 3.5))


def test_a_unit_of_nobody_is_guessed_by_the_stature_and_said():
    clip = clip_of_bvh(bvh(unit_m=0.2), "clip.bvh")
    assert clip.notes[0] == (
        "unit guessed to be 0.2 m, by which the person has a stature of 1.70 m: upper arm and "
        "forearm are 2.7 long, in none of mm, cm, m, inch, 1/0.45 inch a person's"
    )


def test_a_file_is_read_by_its_suffix(tmp_path):
    (tmp_path / "clip.bvh").write_text(bvh().replace("\n", "\r\n"))
    assert load_clip(tmp_path / "clip.bvh").has("left_hand", "right_hand", "head")


# --- faults --------------------------------------------------------------------------------------


def fault_of(text):
    with pytest.raises(BenchError) as fault:
        clip_of_bvh(text, "clip.bvh")
    said = str(fault.value)
    assert "\n" not in said
    return said


HANDLESS = tuple(b for b in BONES if "Hand" not in b[0])


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("HIERARCHY", "HIERARCHIE", "clip.bvh:1: must be HIERARCHY, got 'HIERARCHIE'"),
        ("OFFSET 0.0", "OFFSET O.0", "clip.bvh:4: must be a number, got 'O.000000000'"),
        ("OFFSET 0.0", "OFFSET nan 0.0", "clip.bvh:4: must be finite, got 'nan'"),
        ("CHANNELS 6", "CHANNELS 9", "clip.bvh:5: must be a whole number up to 6, got '9'"),
        ("Xposition Y", "Xposition X", "clip.bvh:5: Hips: a channel is given twice"),
        ("Xposition", "Wposition", "clip.bvh:5: must be Xposition or Yposition or Zposition or Xrotation or Yrotation or Zrotation, got 'Wposition'"),
        ("JOINT Spine\n", "JOINT Spine\n}\n", "clip.bvh:7: a joint's name must be followed by {{"),
        ("MOTION\n", "", "clip.bvh: has no line MOTION"),
        ("Frames: 60", "Frames: 61", "clip.bvh:{frames}: Frames: 61, but 60 lines of motion follow"),
        ("Frames: 60", "Frames: many", "clip.bvh:{frames}: MOTION needs the lines Frames: N and Frame Time: S"),
        ("Frame Time: 0.03333333", "Frame Time: 0", "clip.bvh:{time}: Frame Time must be from 0.001 to 10 s, got 0"),
        ("Frame Time: 0.03333333\n", "Frame Time: 0.03333333\n1 2 3\n", "clip.bvh:{frames}: Frames: 60, but 61 lines"),
    ],
)  # fmt: skip
def test_each_fault_names_its_line(old, new, said):
    text = bvh()
    assert old in text
    at = 1 + text.splitlines().index("MOTION")
    said = said.format(frames=at + 1, time=at + 2)
    assert fault_of(text.replace(old, new, 1)).startswith(said)


def test_faults_of_the_numbers_name_their_line():
    lines = bvh().splitlines()
    first = lines.index("Frame Time: 0.03333333") + 1
    for row, change, said in (
        (first + 2, "1 2 3", "has 3 numbers, the skeleton 51 channels"),
        (first + 3, lines[first + 3].replace("0.95", "o.95"), "must be numbers: could not convert"),
        (first + 4, lines[first + 4].replace("0.95", "inf 0.95", 1).rsplit(" ", 1)[0], "holds a number that is not finite"),
    ):  # fmt: skip
        wrong = "\n".join([*lines[:row], change, *lines[row + 1 :]])
        assert fault_of(wrong).startswith(f"clip.bvh:{row + 1}: {said}")


def test_what_is_no_person_is_named():
    assert fault_of(bvh(bones=HANDLESS)) == (
        "clip.bvh: has no left hand: needed is a joint named like LeftHand, lHand or hand_l; it has "
        "Hips, Spine, Neck, Head, LeftShoulder, LeftArm, LeftForeArm, RightShoulder, RightArm, RightForeArm"
    )
    assert fault_of(bvh(n=1)) == "clip.bvh: has 1 frames; a motion needs at least 2"
    top = (
        ("Hips", None, (0.0, 1.0, 0.0)),
        ("LeftHand", "Hips", (0.3, 0.0, 0.0)),
        ("RightHand", "Hips", (-0.3, 0.0, 0.0)),
    )
    assert (
        fault_of(bvh(bones=top, ends={})) == "clip.bvh: LeftHand has no elbow and shoulder above it"
    )


@settings(max_examples=60, deadline=None)
@given(cut=st.integers(0, 12_000), junk=st.text(alphabet="{}JOINT OFFSET 0.1\n", max_size=12))
def test_a_damaged_file_is_one_line_or_still_a_clip(cut, junk):
    text = bvh()
    try:
        clip_of_bvh(text[:cut] + junk + text[cut + 3 :], "clip.bvh")
    except BenchError as fault:
        said = str(fault)
        assert "\n" not in said
