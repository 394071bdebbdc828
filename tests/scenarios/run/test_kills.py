"""Kills at random moments, a full disk: nothing finished is lost, and the end is undisturbed."""

import os
import random
import shutil
import signal
import time

import pytest
from commands import ENVIRONMENT, LIMIT_S, bench, command, server_pids, started, worker_pids
from made_dataset import contents, made_dataset
from small_disk import in_a_small_disk, needs_small_disk

from reports.run.load import load
from scenarios.execute.journal import FILE, Journal

KILLS = 50


@pytest.mark.long
def test_a_run_survives_kills_of_parent_and_workers(tmp_path, tmp_path_factory):
    footage = made_dataset(tmp_path_factory)
    words = ("run", "--from", footage, "--set", "detector.background_learn_min=2", "--jobs", "1")
    begun = time.monotonic()
    assert bench(*words, "--films", "--out", tmp_path / "reference").returncode == 0
    whole_s = time.monotonic() - begun
    expected = tables_and_pictures(tmp_path / "reference")
    rng, kills = random.Random(1), 0
    while kills < KILLS:
        kept = set()
        while True:
            process = started(*words, "--films", "--out", "r", cwd=tmp_path)
            time.sleep(rng.uniform(0.0, whole_s))
            others = [*server_pids(process.pid), *worker_pids(process.pid)]
            if process.poll() is None and kills < KILLS:
                victim = rng.choice([process.pid, process.pid, *others])
                os.kill(victim, signal.SIGKILL)
                kills += 1
            _, said = process.communicate(timeout=LIMIT_S)
            if process.returncode == 0:
                break
            assert process.returncode == -signal.SIGKILL, said
            if (tmp_path / "r").exists() and not (tmp_path / "r.part").exists():
                break  # killed at its very end
            if (tmp_path / "r").exists():  # the saved run is whole, or not there
                load(tmp_path / "r")
            elif (tmp_path / "r.part" / FILE).exists():
                now = finished(tmp_path / "r.part")
                assert kept <= now
                kept = now
        assert tables_and_pictures(tmp_path / "r") == expected
        assert sorted(path.name for path in tmp_path.iterdir()) == ["r", "reference"]
        shutil.rmtree(tmp_path / "r")


@pytest.mark.long
@needs_small_disk
def test_a_full_disk_is_one_line_and_the_run_goes_on_where_there_is_space(
    tmp_path, tmp_path_factory
):
    footage = made_dataset(tmp_path_factory)
    words = ("run", "--from", footage, "--set", "detector.background_learn_min=2", "--jobs", "1")
    assert bench(*words, "--films", "--out", tmp_path / "reference").returncode == 0
    run = " ".join(command(*words, "--films", "--out", "/mnt/r"))
    on = " ".join(command("run", "--resume", "/mnt/r"))
    kept = f"cp -r /mnt/r.part {tmp_path}/part"
    more = f"mount -o remount,size=50m /mnt && {on} && cp -r /mnt/r {tmp_path}/r"
    script = f"export PYTHONPATH={ENVIRONMENT['PYTHONPATH']}; {run}; echo rc $?; {kept}; {more}"
    done = in_a_small_disk(script, "108k")  # an episode has 41
    assert "rc 5" in done.stdout, done.stdout + done.stderr
    assert "No space left on device. Free some space there" in done.stderr
    assert "Traceback" not in done.stderr
    assert "goes on" in done.stderr
    assert len(finished(tmp_path / "part")) in (1, 2, 3)
    assert tables_and_pictures(tmp_path / "r") == tables_and_pictures(tmp_path / "reference")


def finished(part):
    """The keys of a journal, of a copy: to open one is to cut off what is torn."""
    copy = shutil.copytree(part, part.with_name("copy"))
    for other in copy.iterdir():
        if other.name != FILE and other.is_dir():
            shutil.rmtree(other)
    identity = (copy / FILE).read_bytes()[:200].partition(b"identity")[2][:64].decode()
    try:
        if not identity:
            return set()
        with Journal.open(copy, identity) as journal:
            return {*journal.finished}
    finally:
        shutil.rmtree(copy)


def tables_and_pictures(run):
    files = contents(run)
    return {name: files[name] for name in files if name not in ("run.json", "report.html")}
