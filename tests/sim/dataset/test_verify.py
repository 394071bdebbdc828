"""An undamaged data set has no fault; every damage to one is named with its file.

The checks are tested in the folder check, with checksums that were written again after the damage:
they must find it by themselves.
"""

import os
import signal

import numpy as np
import pytest
from commands import worker_pids
from damaged_dataset import SEQ, edit_json, faults_of, files

from pjpdaf.errors import BenchError
from sim.dataset.check.fault import Fault
from sim.dataset.files.layout import CHECKSUMS
from sim.dataset.verify import verify
from sim.processes import WorkerPool


def test_an_undamaged_data_set_has_no_fault(trio, single):
    names = []
    assert verify(single) == []
    assert verify(trio, on_sequence=names.append) == []
    assert names == ["seq_000000", "seq_000001", "seq_000002"]


@pytest.mark.long
def test_worker_processes_find_the_same(copies):
    (copies / SEQ / "right" / "000003.png").unlink()
    with WorkerPool(2) as pool:
        assert verify(copies, pool=pool, sums=False) == verify(copies, sums=False)


def test_workers_that_are_killed_are_replaced_and_the_verdict_is_complete(copies):
    (copies / SEQ / "right" / "000003.png").unlink()
    wanted = verify(copies, sums=False)
    others, names, killed = set(worker_pids(os.getpid())), [], []

    def kill_all_once(name):
        """While the other worker is checking another sequence."""
        names.append(name)
        if not killed:
            killed.extend(set(worker_pids(os.getpid())) - others)
            for pid in killed:
                os.kill(pid, signal.SIGKILL)

    with WorkerPool(2) as pool:
        assert verify(copies, pool=pool, sums=False, on_sequence=kill_all_once) == wanted
    assert len(killed) == 2
    assert names == ["seq_000000", "seq_000001", "seq_000002"]


@pytest.mark.sample(2)
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
    assert "manifest.json" in files(faults_of(copy))


def test_without_a_manifest_the_rest_is_still_checked(copy):
    (copy / "manifest.json").write_text("{")
    (copy / SEQ / "right" / "000003.png").unlink()
    named = files(faults_of(copy))
    assert "manifest.json" in named
    assert f"{SEQ}/right/000003.png" in named
    (copy / "manifest.json").unlink()
    assert Fault("manifest.json", "missing") in faults_of(copy)


def test_another_scale_in_the_conventions_is_named(copy):
    edit_json(copy / "conventions.json", lambda c: c["depth"].update(unit_m=1e-3))
    assert files(faults_of(copy)) == ["conventions.json"]


@pytest.mark.long
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
    with pytest.raises(BenchError, match="no such data set"):
        verify(tmp_path / "nothing")
