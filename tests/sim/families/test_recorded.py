"""The scenario `recorded`, and parameters that are files."""

# ruff: noqa: E501 - messages are spelled out on one line, as the user sees them

from __future__ import annotations

import importlib.util
import json
import math
import pickle
import shutil
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import scenarios
from pjpdaf.errors import BenchError
from scenarios.play.job import Job, System, digest_of
from scenarios.play.plan import PlanRequest, plan
from scenarios.spec.draw import concrete, in_si, perform
from scenarios.spec.loader import load_scenario_file, load_suite_file
from scenarios.spec.names import load_scenario
from scenarios.spec.parameters.file import File, FileText
from scenarios.spec.scenario import Scenario, digest
from scenarios.spec.schema import json_schema
from scenarios.spec.suite import suite_digest
from sim.clips.clip_files import load_clip
from sim.contact.contact import ALLOWED_PENETRATION_M
from sim.motion.measure import overlaps_of
from sim.motion.stage import STILL_S

CATALOG = Path(scenarios.__file__).parent / "catalog"
SEEDS = range(100, 104)


@cache
def shipped():
    return load_scenario("recorded")


@cache
def performance(seed=100, mirror="no", slow=1, **more):
    return perform(shipped(), seed, {"mirror": mirror, "slow": slow, **more})


def clock_of(played):
    return played.script.plan.hands[0].clock


def palms(played, times):
    return np.array([[arm.palm_m for arm in played.script.body(t).arms] for t in times])


# --- the motion ----------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_hands_are_still_and_apart_first_then_play_the_clip_to_its_end(seed):
    played = performance(seed)
    clock = clock_of(played)
    first = palms(played, np.linspace(0.0, STILL_S, 8))
    assert np.ptp(first, axis=0).max() < 1e-9
    assert np.linalg.norm(first[0, 0] - first[0, 1]) > 0.25
    assert clock.over_s < played.frames / played.fps  # as shipped, the whole clip is seen
    last = palms(played, [clock.over_s, clock.over_s + 0.5])
    np.testing.assert_allclose(last[0], last[1], atol=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("seed", SEEDS)
def test_the_whole_clip_is_posable_and_nothing_is_in_anything(seed):
    played = performance(seed, fps=15, frames=225)
    assert played.redrawn == 0
    performer = played.script
    for t in np.arange(0.0, 15.0, 0.25).tolist():
        overlap = overlaps_of(performer, performer.body(t), ())
        assert overlap.worst_m <= ALLOWED_PENETRATION_M, overlap.worst


@pytest.mark.long
@pytest.mark.parametrize("slow", [1, 2, 4, 8])
def test_speeds_are_those_of_the_clip_slowed(slow):
    frames = int(13.5 * slow * 3 + 10)
    played = performance(101, slow=slow, frames=frames)
    clip, clock = load_clip(CATALOG / "clips" / "story.csv"), clock_of(played)
    scale = played.script.plan.hands[0].body.fit.scale
    moments = np.arange(0.5, clip.duration_s - 0.5, 0.1)
    starts = [clock.when(t) for t in moments.tolist()]
    dt_s = slow / 30
    before, after = palms(played, starts), palms(played, [t + dt_s for t in starts])
    speeds = np.linalg.norm(after - before, axis=2) / dt_s * slow
    for side, name in enumerate(("right_hand", "left_hand")):
        path = clip.path(name)
        theirs = [
            np.linalg.norm(
                [np.interp(t + 1 / 30, clip.times_s, path[:, k]) - np.interp(t, clip.times_s, path[:, k]) for k in range(3)]
            ) * 30 * scale
            for t in moments.tolist()
        ]  # fmt: skip
        for share in (0.5, 0.9, 0.98):
            wanted = np.quantile(theirs, share)
            assert np.quantile(speeds[:, side], share) == pytest.approx(wanted, rel=0.05, abs=0.01)


@pytest.mark.long
@pytest.mark.parametrize("seed", [100, 103])
def test_motion_is_smooth_everywhere_also_where_the_clip_begins_and_ends(seed):
    played = performance(seed)
    clock = clock_of(played)
    times = [*np.arange(0.0, 15.0, 0.37), clock.from_s, clock.over_s, clock.from_s + clock.ramp_s]
    for t in times:
        a, b, c, d = palms(played, [t - 2e-3, t - 1e-3, t + 1e-3, t + 2e-3])
        jump = np.linalg.norm((d - c) - (b - a), axis=1) / 1e-3
        assert jump.max() < 0.1  # m/s: 30 m/s^2 over 3 ms
    heads = [played.script.body(t).head.position_m for t in np.arange(0.0, 15.0, 0.01)]
    assert np.linalg.norm(np.diff(heads, axis=0), axis=1).max() < 0.004


def test_poses_are_the_same_at_any_frame_rate():
    slow, fast = performance(fps=1, frames=15), performance(fps=30, frames=450)
    for t in (0.0, 2.0, 7.0, 14.0):
        a, b = slow.script.pose(t), fast.script.pose(t)
        for one, other in zip(a.hands + a.forearms, b.hands + b.forearms, strict=True):
            np.testing.assert_array_equal(one.position_m, other.position_m)
            np.testing.assert_array_equal(one.rotation, other.rotation)


def test_events_say_when_the_clip_plays_and_when_it_is_over():
    played = performance()
    clock = clock_of(played)
    assert "clip" not in played.script.events(clock.from_s - 0.01)
    assert "clip" in played.script.events(clock.from_s + 0.01)
    assert played.script.events(clock.over_s + 0.01) == ("clip:over",)


def test_bridged_gaps_are_events(tmp_path):
    lines = (CATALOG / "clips" / "story.csv").read_text().splitlines()
    header = lines[2].split(",")
    for k in range(3 + 150, 3 + 180):
        cells = lines[k].split(",")
        for name in ("left_hand_x", "left_hand_y", "left_hand_z"):
            cells[header.index(name)] = ""
        lines[k] = ",".join(cells)
    file = tmp_path / "gap.csv"
    file.write_text("\n".join(lines))
    played = performance(clip=str(file))
    named = {cue.name: cue for cue in played.script.plan.cues}
    gap = named["clip:bridged:left_hand"]
    assert gap.to_s - gap.from_s == pytest.approx(31 / 30, abs=1e-3)
    assert gap.from_s == pytest.approx(clock_of(played).when(149 / 30), abs=1e-3)


def test_a_mirrored_clip_is_its_mirror_image():
    plain, other = performance(100), performance(100, "yes")
    t = clock_of(plain).from_s + 5.0
    right, left = palms(plain, [t])[0]
    body = other.script.plan.hands[0].body
    flip = [1.0, -1.0, 1.0]
    mirrored_right, mirrored_left = palms(
        other, [t - clock_of(plain).from_s + clock_of(other).from_s]
    )[0]
    np.testing.assert_allclose(mirrored_left, right * flip, atol=0.002)
    np.testing.assert_allclose(mirrored_right, left * flip, atol=0.002)
    assert body.fit.scale == pytest.approx(plain.script.plan.hands[0].body.fit.scale)


def test_it_can_begin_anywhere_in_the_clip_but_not_behind_it():
    late = performance(100, clip_start=6)
    body, clock = late.script.plan.hands[0].body, clock_of(late)
    np.testing.assert_allclose(palms(late, [clock.from_s])[0], body.palms(6.0), atol=0.003)
    with pytest.raises(BenchError) as fault:
        perform(shipped(), 100, {"clip_start": 13})
    assert str(fault.value) == "clip_start: 13 s is not before the clip's end at 12.40 s"


def test_the_example_makes_the_shipped_clip():
    file = Path(scenarios.__file__).parent.parent / "examples" / "make_clip.py"
    spec = importlib.util.spec_from_file_location("make_clip", file)
    module = importlib.util.module_from_spec(spec)
    sys.modules["make_clip"] = module
    spec.loader.exec_module(module)
    made = module.story().splitlines()
    there = (CATALOG / "clips" / "story.csv").read_text().splitlines()
    assert made[:3] == there[:3]
    ours, theirs = (
        np.array([r.split(",") for r in rows[3:]], dtype=float) for rows in (made, there)
    )
    assert np.abs(ours - theirs).max() < 0.01  # the body may be refined; the story stays
    assert (CATALOG / "clips" / "story.csv").stat().st_size < 60_000


# --- the file parameter --------------------------------------------------------------------------


def copied(tmp_path, clip="clips/story.csv", text=None):
    """The shipped scenario with its clip, in a folder of its own: its file."""
    folder = tmp_path / "mine"
    (folder / "clips").mkdir(parents=True)
    shutil.copy(CATALOG / "clips" / "story.csv", folder / "clips" / "story.csv")
    yaml = (text or (CATALOG / "recorded.yaml").read_text()).replace("clips/story.csv", clip)
    (folder / "recorded.yaml").write_text(yaml)
    return folder / "recorded.yaml"


def changed(file):
    lines = file.read_text().splitlines()
    file.write_text("\n".join(lines[:-1]) + "\n")


def test_the_digest_is_of_the_content_not_of_the_place_or_name(tmp_path):
    file = copied(tmp_path)
    scenario = load_scenario_file(file)
    assert digest(scenario) == digest(shipped())
    (file.parent / "clips" / "story.csv").rename(file.parent / "other.csv")
    file.write_text(file.read_text().replace("clips/story.csv", "other.csv"))
    assert digest(load_scenario_file(file)) == digest(shipped())
    changed(file.parent / "other.csv")
    assert digest(load_scenario_file(file)) != digest(shipped())


def test_scenarios_with_files_travel_and_are_validated_again():
    scenario = shipped()
    for again in (
        pickle.loads(pickle.dumps(scenario)),
        Scenario.model_validate(scenario.model_dump()),
    ):
        assert digest(again) == digest(scenario)
        clip = again.parameters["clip"]
        assert isinstance(clip, File)
        assert isinstance(clip.file, FileText)
        assert clip.file.path == CATALOG / "clips" / "story.csv"


def test_results_show_the_name_as_given_and_the_family_gets_the_path(tmp_path):
    values = concrete(shipped(), 100)
    assert values["clip"] == "clips/story.csv"
    assert json.loads(json.dumps(values))["clip"] == "clips/story.csv"
    assert in_si(shipped(), values)["clip"] == str(CATALOG / "clips" / "story.csv")


@pytest.mark.parametrize(
    ("clip", "said"),
    [
        ("/etc/passwd.csv", "must lie in the folder of this file or below, got '/etc/passwd.csv'"),
        ("../outside.csv", "must lie in the folder of this file or below, got '../outside.csv'"),
        ("clips/../../outside.csv", "must lie in the folder of this file or below, got 'clips/../../outside.csv'"),
        ("link.csv", "must lie in the folder of this file or below, got 'link.csv'"),
        ("C:/clip.csv", "must lie in the folder of this file or below, got 'C:/clip.csv'"),
        ("~/clip.csv", "must lie in the folder of this file or below, got '~/clip.csv'"),
        ("clips/none.csv", "no such file: {folder}/clips/none.csv"),
        ("folder.csv", "is not a file: {folder}/folder.csv"),
        ("clips/story.txt", "must end in .npz, .csv, .bvh, got 'clips/story.txt'"),
    ],
)  # fmt: skip
def test_a_file_outside_the_scenario_s_folder_is_refused_at_its_line(tmp_path, clip, said):
    (tmp_path / "outside.csv").write_text("x")
    file = copied(tmp_path, clip)
    (file.parent / "link.csv").symlink_to(tmp_path / "outside.csv")
    (file.parent / "folder.csv").mkdir()
    with pytest.raises(BenchError) as fault:
        load_scenario_file(file)
    said = said.format(folder=file.parent)
    assert str(fault.value) == f"{file}:13:10: parameters.clip.file: {said}"


def test_links_within_the_folder_are_followed(tmp_path):
    file = copied(tmp_path, "linked.csv")
    (file.parent / "linked.csv").symlink_to(file.parent / "clips" / "story.csv")
    assert digest(load_scenario_file(file)) == digest(shipped())


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("file: clips", "flie: clips", "13:10: parameters.clip.flie: no such field"),
        ("meaning: \"the motion", "meaningg: \"the motion", "13:33: parameters.clip.meaningg: no such field; did you mean meaning?"),
        ("{file: clips/story.csv,", "{file: 3,", "13:10: parameters.clip.file: must be text, got 3"),
        ("  slow:", "  stature: {file: clips/story.csv}\n  slow:", "14:13: parameters.stature.file: cannot be a file"),
    ],
)  # fmt: skip
def test_faults_of_the_parameter_itself_are_at_their_place(tmp_path, old, new, said):
    text = (CATALOG / "recorded.yaml").read_text()
    assert old in text
    file = copied(tmp_path, text=text.replace(old, new, 1))
    with pytest.raises(BenchError) as fault:
        load_scenario_file(file)
    assert str(fault.value).startswith(f"{file}:{said}")


def suite_file(tmp_path, clip):
    copied(tmp_path)
    file = tmp_path / "mine" / "suite.yaml"
    entry = f"  - {{scenario: recorded, label: own, overrides: {{slow: 2, clip: {clip}}}}}\n"
    file.write_text(f"name: mine\nsummary: One.\nscenarios:\n{entry}")
    return file


def test_a_suite_s_files_lie_below_it_and_count_in_its_digest(tmp_path):
    file = suite_file(tmp_path, "clips/story.csv")
    suite = load_suite_file(file)
    given = suite.scenarios[0].overrides["clip"]
    assert given == "clips/story.csv"
    assert given.path == file.parent / "clips" / "story.csv"
    (job, *_) = plan(request(str(file)))
    assert digest_of(job) == digest_of(Job(shipped(), 0, {"slow": 2.0, "clip": given}, System()))
    first = suite_digest(suite, {"recorded": shipped()})
    changed(file.parent / "clips" / "story.csv")
    assert suite_digest(load_suite_file(file), {"recorded": shipped()}) != first


@pytest.mark.parametrize("clip", ["/etc/clip.csv", "../clip.csv"])
def test_a_suite_s_files_are_refused_outside_its_folder(tmp_path, clip):
    (tmp_path / "clip.csv").write_text("x")
    file = suite_file(tmp_path, clip)
    with pytest.raises(BenchError) as fault:
        load_suite_file(file)
    said = f"scenarios.0.overrides.clip: must lie in the folder of this file or below, got '{clip}'"
    assert str(fault.value) == f"{file}:4:59: {said}"


def request(target, *settings):
    return PlanRequest((target,), 1, settings=settings)


def test_set_takes_a_file_from_anywhere_and_its_content_counts(tmp_path, monkeypatch):
    (tmp_path / "deep").mkdir()
    own = tmp_path / "deep" / "own.csv"
    shutil.copy(CATALOG / "clips" / "story.csv", own)
    monkeypatch.chdir(tmp_path / "deep")
    (here,) = plan(request("recorded", "clip=own.csv"))
    (there,) = plan(request("recorded", f"clip={own}"))
    assert here.overrides["clip"] == "own.csv"
    assert digest_of(here) == digest_of(there)
    monkeypatch.chdir(tmp_path)  # wherever it is played
    assert perform(here.scenario, 0, pickle.loads(pickle.dumps(here)).overrides).frames == 48
    changed(own)
    with pytest.raises(
        BenchError, match=r"^own\.csv: has changed since it was named; start again$"
    ):
        perform(here.scenario, 0, here.overrides)
    (again,) = plan(request("recorded", f"clip={own}"))
    assert digest_of(again) != digest_of(there)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("absent.csv", "clip: no such file: {cwd}/absent.csv"),
        ("story", "clip: must end in .npz, .csv, .bvh, got 'story'"),
        ("", "clip: must be the name of a file"),
        ("bad.csv", "{cwd}/bad.csv:1: columns are missing: time_s, head_x, head_y, head_z, left_hand_x, left_hand_y, left_hand_z, right_hand_x, right_hand_y ..."),
        ("far.csv", "{cwd}/far.csv: head at 0.000 s (frame 0): x is 60 m, more than 3 m from the shoulders; are the units metres?"),
    ],
)  # fmt: skip
def test_a_wrong_file_on_the_command_line_is_one_line(tmp_path, monkeypatch, given, said):
    monkeypatch.chdir(tmp_path)
    Path("bad.csv").write_text("a,b\n1,2\n")
    columns = [f"{j}_{a}" for j in ("head", "left_hand", "right_hand") for a in "xyz"]
    rows = [",".join([str(k / 30), *["60"] * 9]) for k in range(30)]
    Path("far.csv").write_text("\n".join([",".join(["time_s", *columns]), *rows]))
    with pytest.raises(BenchError) as fault:
        plan(request("recorded", f"clip={given}"))
    assert str(fault.value) == said.format(cwd=tmp_path)
    assert fault.value.exit_code == 2


def test_the_json_schema_knows_file_parameters():
    definitions = json_schema()["$defs"]
    assert set(definitions["File"]["properties"]) == {"file", "meaning"}
    assert definitions["File"]["required"] == ["file"]
    assert "#/$defs/File" in json.dumps(
        definitions | {"p": json_schema()["properties"]["parameters"]}
    )


def test_clips_of_the_same_motion_in_other_files_play_alike(tmp_path):
    clip = load_clip(CATALOG / "clips" / "story.csv")
    short = {"head": "head"} | {
        f"{s[0]}{j[:3]}": f"{s}_{j}" for s in ("left", "right") for j in ("elbow", "wrist")
    }
    short |= {
        "lsho": "left_shoulder",
        "rsho": "right_shoulder",
        "lhand": "left_hand",
        "rhand": "right_hand",
    }
    short = {k.replace("elb", "elb"): v for k, v in short.items()}
    names = [next(k for k, v in short.items() if v == joint) for joint in clip.joints]
    np.savez(tmp_path / "clip.npz", t=clip.times_s, joints=np.array(names), xyz=clip.xyz)
    theirs = performance(clip=str(tmp_path / "clip.npz"))
    ours = performance()
    for t in (0.5, 3.0, 8.0):
        np.testing.assert_allclose(palms(ours, [t]), palms(theirs, [t]), atol=1e-6)
    assert math.isclose(clock_of(ours).over_s, clock_of(theirs).over_s)
