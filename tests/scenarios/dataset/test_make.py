"""`dataset make`: whole or not at all, resumed, and the same bytes whoever makes them."""

import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from shared import shared

from pjpdaf.errors import BenchError
from scenarios.dataset.make import make_dataset as make
from scenarios.dataset.remake import remake_sequence
from scenarios.dataset.sequence_plan import MakeRequest
from scenarios.play.job import Job
from scenarios.play.ladder import RUNGS
from scenarios.play.recipe import Recipe, SequenceSettings, parse_labels, parse_size, read_recipe
from scenarios.spec.scenario import digest
from sim.dataset.files.checksums import read_sums, sha256_of
from sim.dataset.files.reading import read_json
from sim.dataset.reader import open_dataset

SMALL = SequenceSettings(("depth", "seg"), (96, 72))
WORDS = ["cross", "recorded", "--seeds", "2", "--first-seed", "100", "--size", "96x72"]
WORDS += ["--set", "frames=4", "--set", "background_frames=1", "--labels", "depth,seg"]
WORDS += ["--export", "none"]


def request(out, **changes):
    words = {
        "targets": ("cross", "recorded"),
        "seeds": 1,
        "first_seed": 100,
        "settings": ("frames=3", "background_frames=1"),
        "labels": SMALL,
        "jobs": 1,
    }
    return MakeRequest(out=out, **(words | changes))


def command(out, jobs=2, words=WORDS):
    verb = [sys.executable, "-m", "scenarios", "dataset", "make"]
    return [*verb, *words, "--out", str(out), "--jobs", str(jobs)]


def contents(folder):
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(Path(folder).rglob("*"))
        if path.is_file()
    }


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """An undisturbed data set of four sequences, made by one worker."""

    def make_it(folder):
        subprocess.run(command(folder / "set", jobs=1), check=True, capture_output=True)

    return shared(tmp_path_factory, "made", make_it) / "set"


@pytest.mark.parametrize("jobs", [pytest.param(2, marks=pytest.mark.long), 4])
def test_any_number_of_workers_makes_the_same_bytes(made, tmp_path, jobs):
    subprocess.run(command(tmp_path / "set", jobs), check=True, capture_output=True)
    assert contents(tmp_path / "set") == contents(made)


def test_its_checksums_are_those_of_its_files_and_of_all_of_them(made):
    sums = read_sums(made / "SHA256SUMS")
    assert sums == {k: v for k, v in contents(made).items() if k != "SHA256SUMS"}
    done = subprocess.run(
        ["sha256sum", "-c", "--strict", "--quiet", "SHA256SUMS"], cwd=made, check=False
    )
    assert done.returncode == 0


def test_nothing_in_it_names_this_machine(made):
    for path in made.rglob("*"):
        if path.suffix in (".json", ".md", ".yml", ".txt"):
            text = path.read_text()
            assert str(made.parent) not in text, path
            assert str(Path.cwd()) not in text, path


def assert_whole(out, made):
    """Every sequence that can be seen is the undisturbed one."""
    for folder in out.glob("seq_*"):
        assert contents(folder) == contents(made / folder.name)


def kill_and_go_on(out, made, rng, most_kills):
    """Start, kill parent or a worker at a random moment, look, start again; until undisturbed."""
    kills, said = 0, out.with_name("said.txt")
    while kills < most_kills:
        with said.open("w") as stream:
            process = subprocess.Popen(command(out), stdout=subprocess.DEVNULL, stderr=stream)
        try:
            process.wait(rng.uniform(0.2, 4.0))
        except subprocess.TimeoutExpired:
            workers = children(process.pid)
            victim = rng.choice([process.pid, *workers]) if workers else process.pid
            try:
                os.kill(victim, signal.SIGKILL)
            except ProcessLookupError:
                continue
            kills += 1
            if victim != process.pid:
                # The parent replaces it. A worker that is killed in its start is one of three.
                assert process.wait(120) == 0, said.read_text()
        assert_whole(out, made)
        if process.wait() == 0:
            assert contents(out) == contents(made)
            shutil.rmtree(out)
    subprocess.run(command(out), check=True, capture_output=True)
    assert contents(out) == contents(made)


def children(pid):
    """Process ids of the workers (not of Python's own resource tracker)."""
    found = []
    for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
        words = Path(f"/proc/{child}/cmdline").read_bytes().split(b"\0")
        if any(b"spawn_main" in word for word in words):
            found.append(int(child))
    return found


def test_killed_at_any_moment_it_goes_on_to_the_same_bytes(made, tmp_path):
    kill_and_go_on(tmp_path / "set", made, random.Random(1), most_kills=2)


@pytest.mark.long
def test_killed_fifty_times_it_goes_on_to_the_same_bytes(made, tmp_path):
    kill_and_go_on(tmp_path / "set", made, random.Random(2), most_kills=50)


def test_interrupted_it_keeps_what_is_finished_and_says_so(made, tmp_path):
    out = tmp_path / "set"
    process = subprocess.Popen(
        command(out, 1), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    while not (out / "seq_000001").is_dir():
        assert process.poll() is None
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert "sequences are in" in said
    assert said.strip().splitlines()[-1].startswith("pjpdaf-bench: interrupted: ")
    assert not json.loads((out / "manifest.json").read_text())["complete"]
    assert not list(out.glob(".part-*"))
    assert_whole(out, made)
    assert len(open_dataset(out).sequences) >= 2
    subprocess.run(command(out), check=True, capture_output=True)
    assert contents(out) == contents(made)


def test_a_second_maker_is_refused(tmp_path):
    out = tmp_path / "set"
    quiet = subprocess.DEVNULL
    process = subprocess.Popen(command(out, 1), stdout=quiet, stderr=quiet)
    try:
        while not (out / "manifest.json").exists():
            assert process.poll() is None
            time.sleep(0.02)
        with pytest.raises(BenchError, match="another process is making this data set"):
            make(request(out))
    finally:
        process.kill()
        process.wait()


OTHERS = (
    (
        {"labels": SequenceSettings(("depth",), (96, 72))},
        r"other settings: labels \['depth', 'seg'\]",
    ),
    (
        {"labels": SequenceSettings(("depth", "seg"), (64, 48))},
        r"other settings: size_px \[96, 72\]",
    ),
    ({"seeds": 2}, r"other scenarios or seeds \(2 sequences, asked for 4\)"),
    ({"settings": ("frames=2", "background_frames=1")}, "other scenarios or seeds"),
    ({"ladder": True}, "other settings: ladder False, asked for True"),
)


def test_a_data_set_of_other_settings_is_left_alone(tmp_path):
    out = tmp_path / "set"
    make(request(out))
    before = contents(out)
    for changes, said in OTHERS:
        with pytest.raises(BenchError, match=said):
            make(request(out, **changes))
    assert contents(out) == before


def test_a_folder_with_something_else_in_it_is_left_alone(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(BenchError, match=r"is not empty \(mine.txt\) and not a data set"):
        make(request(tmp_path))
    (tmp_path / "file").write_text("")
    with pytest.raises(BenchError, match="file"):
        make(request(tmp_path / "file"))


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written_is_one_line(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(BenchError, match="cannot write the data set: Permission denied"):
        make(request(tmp_path / "set"))


def in_a_small_disk(script, size="3m"):
    words = ["unshare", "-Urm", "sh", "-c", f"mount -t tmpfs -o size={size} none /mnt && {script}"]
    return subprocess.run(words, capture_output=True, text=True, check=False)


@pytest.mark.skipif(in_a_small_disk("true").returncode != 0, reason="cannot mount here")
def test_a_full_disk_is_one_line_and_what_is_finished_stays(made):
    words = " ".join(command("/mnt/set", 1))
    done = in_a_small_disk(f"{{ {words}; echo rc $?; ls -A /mnt/set; }}", "500k")
    assert "rc 5" in done.stdout, done.stdout + done.stderr
    assert done.stderr.strip().count("\n") == 0
    assert "No space left on device. Free some space there" in done.stderr
    assert "seq_000000" in done.stdout
    assert ".part" not in done.stdout


def test_a_recipe_makes_a_sequence_and_a_frame_of_it_again(made, tmp_path):
    for number in (1, 2):  # of a pair of twins; with a clip, which lies beside it
        folder = made / f"seq_{number:06d}"
        said = remake_sequence(folder / "recipe.json", tmp_path / f"again{number}")
        assert said == f"sequence: {tmp_path / f'again{number}'}"
        assert contents(tmp_path / f"again{number}") == contents(folder)
        remake_sequence(folder / "recipe.json", tmp_path / f"one{number}", frame=2)
        pictures = {k: v for k, v in contents(tmp_path / f"one{number}").items() if "/" in k}
        assert set(pictures) == {
            f"{kind}_{side}/000003.png".lstrip("_")
            for kind in ("", "depth", "seg")
            for side in ("left", "right")
        }
        assert pictures.items() <= contents(folder).items()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"seed": -1}, "seed must be a whole number"),
        ({"seed": 5}, "its digest is not that of its scenario"),
        ({"overrides": {"speed": "1"}}, "has no parameter 'speed'"),
        ({"kind": "x"}, "is not a recipe of version 1"),
        ({"settings": {"labels": ["x"], "size_px": None}}, "settings.labels x: must be of clean"),
        ({"settings": {"labels": [], "size_px": [1, 10**9]}}, "both must be from 32 to 4096"),
        ({"files": {"clip": {"name": "../../x.csv", "sha256": ""}}}, "must lie in the folder"),
        (
            {"files": {}, "overrides": {"clip": "/etc/hosts.csv"}},
            "overrides.clip: its file is not among files",
        ),
        ({"overrides": {"clip": "/etc/hosts.csv"}}, "its digest is not that"),
    ],
)
def test_a_recipe_that_was_edited_is_one_line(made, tmp_path, change, said):
    folder = tmp_path / "seq"
    shutil.copytree(made / "seq_000002", folder)
    record = json.loads((folder / "recipe.json").read_text())
    record |= change
    with pytest.raises(BenchError, match=r"recipe\.json") as caught:
        read_recipe(record, folder)
    assert "\n" not in str(caught.value)
    assert said in str(caught.value)


def test_a_recipe_of_a_scenario_of_ones_own_needs_nothing_else(made, tmp_path):
    """As if its catalogue had changed since: the scenario in the recipe counts."""
    folder = tmp_path / "seq"
    shutil.copytree(made / "seq_000002", folder)
    record = json.loads((folder / "recipe.json").read_text())
    known = read_recipe(record, folder).job
    scenario = known.scenario.model_copy(update={"summary": "One's own."})
    own = Recipe(Job(scenario, known.seed, known.overrides, known.system), SMALL)
    written = json.loads(json.dumps(own.record(0)))
    assert digest(read_recipe(written, folder).job.scenario) == digest(scenario)
    shutil.rmtree(folder / "files")
    with pytest.raises(BenchError, match=r"files\.clip: no such file"):
        read_recipe(written, folder)
    with pytest.raises(BenchError, match=r"scenario\.parameters\.clip"):
        read_recipe(written | {"files": {}}, folder)
    written["scenario"]["summary"] = "Edited."
    with pytest.raises(BenchError, match=r"files\.clip|its scenario is not the one"):
        read_recipe(written, folder)


def test_the_ladder_has_the_same_poses_on_every_rung(tmp_path):
    out = tmp_path / "set"
    larger = SequenceSettings(("depth", "seg"), (320, 240))  # so that something moves by pixels
    words = ("frames=3", "fps=1", "background_frames=1")
    make(request(out, targets=("cross",), ladder=True, settings=words, labels=larger))
    dataset = open_dataset(out)
    assert [s.entry["rung"] for s in dataset.sequences] == list(RUNGS)
    by_rung = dict(zip(RUNGS, dataset.sequences, strict=True))
    clean = by_rung["clean"]
    labels = [k for k in contents(clean.folder) if k.startswith(("seg", "depth"))]
    assert len(labels) == 3 * 4
    for rung, sequence in by_rung.items():
        for ours, theirs in zip(sequence.truths, clean.truths, strict=True):
            assert (ours.centres_m == theirs.centres_m).all()
            assert (ours.velocities_mps == theirs.velocities_mps).all()
        same = {k: sha256_of(sequence.folder / k) for k in labels}
        of = by_rung["lens" if rung in ("lens", "shift") else "clean"]
        assert same == {k: sha256_of(of.folder / k) for k in labels}, rung
    films = {
        tuple(sha256_of(path) for path in sorted((sequence.folder / "left").iterdir()))
        for sequence in by_rung.values()
    }
    assert len(films) == len(RUNGS)
    with pytest.raises(BenchError, match="the ladder sets noise_sd"):
        make(request(tmp_path / "other", ladder=True, settings=("noise_sd=2",)))


def test_a_size_changes_the_pictures_and_not_what_is_seen(made, tmp_path):
    out = tmp_path / "set"
    make(request(out, targets=("cross",), labels=SequenceSettings(("seg",), (192, 144))))
    large, small = open_dataset(out).sequences[0], open_dataset(made).sequences[0]
    assert large.seg(0, 0).shape == (144, 192)
    assert large.rig.left.K[0, 0] == pytest.approx(2 * small.rig.left.K[0, 0])
    share = [(s.seg(0, 0) == 1).mean() for s in (large, small)]
    assert share[0] == pytest.approx(share[1], rel=0.1)


@pytest.mark.parametrize("words", ["12", "0x5", "axb", "64x", "64x5000", "-64x64", "1e3x64"])
def test_a_size_that_is_none_is_one_line(words):
    with pytest.raises(BenchError, match="--size"):
        parse_size(words)


def test_the_size_that_scenarios_have_is_no_change():
    assert parse_size("640x480") is None
    assert parse_size("320x240") == (320, 240)


def test_labels_are_named_in_any_order():
    assert parse_labels("seg,depth") == ("depth", "seg")
    assert parse_labels("none") == ()
    assert "float" in parse_labels("all")
    with pytest.raises(BenchError, match="--labels masks: must be of clean, depth"):
        parse_labels("masks")


def test_a_tracker_is_not_part_of_a_data_set(tmp_path):
    with pytest.raises(BenchError, match="a data set has no tracker"):
        make(request(tmp_path / "set", settings=("tracker.gate=4",)))


def test_a_data_set_of_another_renderer_is_not_gone_on_with(made, tmp_path):
    out = tmp_path / "set"
    shutil.copytree(made, out)
    shutil.rmtree(out / "seq_000001")
    record = read_json(out / "manifest.json")
    record["made_with"]["renderer"] = "another"
    (out / "manifest.json").write_text(json.dumps(record | {"complete": False}))
    done = subprocess.run(command(out), capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "was begun with another OpenGL library or other versions" in done.stderr
    assert not (out / "seq_000001").exists()
