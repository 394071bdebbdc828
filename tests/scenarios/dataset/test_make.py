"""`dataset make`: whole or not at all, resumed, and the same bytes whoever makes them."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from commands import messages, wait_until, worker_pids
from made_dataset import contents, made_dataset, request
from small_disk import in_a_small_disk, needs_small_disk

from pjpdaf.errors import BenchError
from scenarios.dataset.make import make_dataset as make
from scenarios.dataset.remake import remake_sequence
from scenarios.play.ladder import RUNGS
from scenarios.play.recipe import SequenceSettings
from sim.dataset.files.checksums import read_sums, sha256_of
from sim.dataset.files.reading import read_json
from sim.dataset.reader import open_dataset

WORDS = ["cross", "recorded", "--seeds", "2", "--first-seed", "100", "--size", "96x72"]
WORDS += ["--set", "frames=4", "--set", "background_frames=2", "--labels", "depth,seg"]
WORDS += ["--export", "none"]


def command(out, jobs=2, words=WORDS):
    verb = [sys.executable, "-m", "scenarios", "dataset", "make"]
    return [*verb, *words, "--out", str(out), "--jobs", str(jobs)]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return made_dataset(tmp_path_factory)


@pytest.mark.parametrize("jobs", [2, pytest.param(4, marks=pytest.mark.long)])
def test_any_number_of_workers_makes_the_same_bytes(made, tmp_path, jobs, executor):
    make(request(tmp_path / "set", jobs=jobs), executor if jobs == 2 else None)
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


def kill_and_go_on(out, made, rng, most_kills, jobs, executor):
    """Start, kill parent or a worker at a random moment, look, start again; until undisturbed."""
    kills, errors, finished = 0, out.with_name("errors.txt"), False
    while kills < most_kills:
        with errors.open("w") as stream:
            process = subprocess.Popen(command(out, jobs), stdout=subprocess.DEVNULL, stderr=stream)
        try:
            process.wait(rng.uniform(0.2, 4.0))
        except subprocess.TimeoutExpired:
            workers = worker_pids(process.pid)
            victim = rng.choice([process.pid, *workers]) if workers else process.pid
            try:
                os.kill(victim, signal.SIGKILL)
            except ProcessLookupError:
                continue
            kills += 1
            if victim != process.pid:
                # The parent replaces it. A worker that is killed in its start is one of three.
                assert process.wait(120) == 0, errors.read_text()
        assert_whole(out, made)
        if finished := process.wait() == 0:
            assert contents(out) == contents(made)
            shutil.rmtree(out)
    if not finished:
        make(request(out), executor)
        assert contents(out) == contents(made)


@pytest.mark.long
def test_killed_at_any_moment_it_goes_on_to_the_same_bytes(made, tmp_path, executor):
    kill_and_go_on(tmp_path / "set", made, random.Random(1), 2, 1, executor)


@pytest.mark.long
def test_killed_fifty_times_it_goes_on_to_the_same_bytes(made, tmp_path, executor):
    kill_and_go_on(tmp_path / "set", made, random.Random(2), 50, 2, executor)


def state_of(pid):
    """State of a process by proc(5): R running, T stopped, Z ended; Z where it is gone."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().split(") ")[1][0]
    except OSError:
        return "Z"


def stop(process):
    """Stop a process and its workers until SIGCONT, and wait until they stand still."""
    pids = [process.pid, *worker_pids(process.pid)]
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGSTOP)
    for pid in pids:
        wait_until(lambda pid=pid: state_of(pid) in "TZ")
    return [pid for pid in pids if state_of(pid) == "T"]


def stopped_in_the_middle(folder, sequences):
    """A maker that stands still with some of its sequences finished, its folder, its processes.

    On a busy machine it may end before it is stopped; then another is started.
    """
    attempt = 0
    while True:
        attempt += 1
        out = folder / f"set{attempt}"
        process = subprocess.Popen(
            command(out, 1), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        )
        wait_until((out / "seq_000001").is_dir, process)
        stopped = stop(process)
        if process.pid in stopped and len(list(out.glob("seq_*"))) < sequences:
            return process, out, stopped
        for pid in stopped:
            os.kill(pid, signal.SIGCONT)
        process.communicate()


@pytest.mark.long
def test_interrupted_it_keeps_what_is_finished_and_a_second_maker_is_refused(
    made, tmp_path, executor
):
    process, out, stopped = stopped_in_the_middle(tmp_path, len(list(made.glob("seq_*"))))
    with pytest.raises(BenchError, match="another process is making this data set"):
        make(request(out), executor)
    process.send_signal(signal.SIGINT)
    for pid in stopped:
        os.kill(pid, signal.SIGCONT)
    output = process.communicate(timeout=600)[1]
    assert process.returncode == 130
    assert "sequences are in" in output
    assert output.strip().splitlines()[-1].startswith("pjpdaf-bench: interrupted: ")
    assert not json.loads((out / "manifest.json").read_text())["complete"]
    assert not list(out.glob(".part-*"))
    assert_whole(out, made)
    assert len(open_dataset(out).sequences) >= 2
    make(request(out), executor)
    assert contents(out) == contents(made)


OTHERS = (
    (
        {"labels": SequenceSettings(("depth",), (96, 72))},
        r"other settings: labels \['depth', 'seg'\]",
    ),
    (
        {"labels": SequenceSettings(("depth", "seg"), (64, 48))},
        r"other settings: size_px \[96, 72\]",
    ),
    ({"seeds": 1}, r"other scenarios or seeds \(4 sequences, asked for 2\)"),
    ({"settings": ("frames=2", "background_frames=1")}, "other scenarios or seeds"),
    ({"ladder": True}, "other settings: ladder False, asked for True"),
)


def test_a_data_set_of_other_settings_is_left_alone(made, tmp_path):
    out = tmp_path / "set"
    shutil.copytree(made, out)
    before = contents(out)
    for changes, message in OTHERS:
        with pytest.raises(BenchError, match=message):
            make(request(out, **changes))
    assert contents(out) == before


def test_a_format_whose_library_is_missing_is_refused_before_anything_is_made(
    tmp_path, monkeypatch
):
    monkeypatch.setitem(sys.modules, "h5py", None)  # as where it is not installed
    with pytest.raises(BenchError, match="the HDF5 files need h5py, which is not installed"):
        make(request(tmp_path / "set", exports=("mot", "hdf5")))
    assert not (tmp_path / "set").exists()


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


@pytest.mark.long
@needs_small_disk
def test_a_full_disk_is_one_line_and_what_is_finished_stays(made):
    words = " ".join(command("/mnt/set", 1))
    done = in_a_small_disk(f"{{ {words}; echo rc $?; ls -A /mnt/set; }}", "500k")
    assert "rc 5" in done.stdout, done.stdout + done.stderr
    assert len(messages(done)) == 1
    assert "No space left on device. Free some space there" in done.stderr
    assert "seq_000000" in done.stdout
    assert ".part" not in done.stdout


@pytest.mark.long
def test_the_ladder_has_the_same_poses_on_every_rung(tmp_path, executor):
    out = tmp_path / "set"
    larger = SequenceSettings(("depth", "seg"), (240, 180))  # so that something moves by pixels
    settings = ("frames=3", "fps=1", "background_frames=1")
    changes = {"targets": ("cross",), "seeds": 1, "settings": settings, "labels": larger}
    make(request(out, ladder=True, **changes), executor)
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


def test_a_size_changes_the_pictures_and_not_what_is_seen(made, tmp_path, executor):
    out = tmp_path / "set"
    short = ("frames=2", "background_frames=1")
    labels = SequenceSettings(("seg",), (192, 144))
    make(request(out, targets=("cross",), seeds=1, settings=short, labels=labels), executor)
    large, small = open_dataset(out).sequences[0], open_dataset(made).sequences[0]
    assert large.seg(0, 0).shape == (144, 192)
    assert large.rig.left.K[0, 0] == pytest.approx(2 * small.rig.left.K[0, 0])
    share = [(s.seg(0, 0) == 1).mean() for s in (large, small)]
    assert share[0] == pytest.approx(share[1], rel=0.1)


def test_a_tracker_is_not_part_of_a_data_set(tmp_path):
    with pytest.raises(BenchError, match="a data set has no tracker"):
        make(request(tmp_path / "set", settings=("tracker.gate=4",)))


def test_a_data_set_of_another_renderer_is_not_gone_on_with(made, tmp_path, executor):
    out = tmp_path / "set"
    shutil.copytree(made, out)
    shutil.rmtree(out / "seq_000001")
    record = read_json(out / "manifest.json")
    record["made_with"]["renderer"] = "another"
    (out / "manifest.json").write_text(json.dumps(record | {"complete": False}))
    message = "was begun with another OpenGL library or other versions"
    with pytest.raises(BenchError, match=message) as fault:
        make(request(out), executor)
    assert fault.value.exit_code == 2
    assert not (out / "seq_000001").exists()


@pytest.mark.long
def test_varied_sequences_share_no_room_body_or_rig(tmp_path, executor):
    out = tmp_path / "set"
    settings = ("frames=2", "background_frames=1")
    labels = SequenceSettings(("seg",), (96, 72))
    changes = {"targets": ("cross", "bounce"), "settings": settings, "labels": labels}
    make(request(out, varied=True, **changes), executor)
    dataset = open_dataset(out)
    identities = [sequence.recipe["identity"] for sequence in dataset.sequences]
    for part in ("room", "body", "rig"):
        assert len({identity[part] for identity in identities}) == len(identities) == 4, part
    # Not by their seed alone: what can be seen differs.
    drawn = [sequence.recipe["values"] for sequence in dataset.sequences]
    seen = ("wall_hue", "floor_value", "room_depth", "light_azimuth", "skin_ita", "focal")
    assert all(len({values[name] for values in drawn}) == 4 for name in seen)
    card = (out / "README.md").read_text()
    assert "4 sequences; different rooms: 4, bodies: 4, rigs: 4" in card
    assert "dataset make cross bounce --seeds 2 --first-seed 100" in card
    assert " --varied " in card
    first = dataset.sequences[0]
    remake_sequence(first.folder / "recipe.json", tmp_path / "again", None)
    assert contents(tmp_path / "again") == contents(first.folder)
    with pytest.raises(BenchError, match=r"--ladder films each sequence five times in one room"):
        make(request(tmp_path / "other", varied=True, ladder=True))
