"""`dataset export`: a finished data set in more formats, whole or not at all."""

import shutil
import signal

import pytest
from commands import command, messages, started, wait_until
from made_dataset import contents, made_dataset
from small_disk import in_a_small_disk, needs_small_disk

from scenarios.dataset.finish import export_dataset
from sim.dataset.verify import verify


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return made_dataset(tmp_path_factory)


@pytest.fixture
def copy(made, tmp_path):
    shutil.copytree(made, tmp_path / "set")
    return tmp_path / "set"


def test_more_formats_are_summed_and_the_rest_stays(copy):
    before = contents(copy)
    written = export_dataset(copy, ("mot", "hdf5"), jobs=2)
    assert {path.relative_to(copy).parts[0] for path in written} == {"mot", "hdf5"}
    assert verify(copy) == []
    after = contents(copy)
    sequences = {path for path in before if path.startswith("seq_")}
    assert {path: after[path] for path in sequences} == {path: before[path] for path in sequences}
    assert "hdf5/" in (copy / "README.md").read_text()


@pytest.mark.long
def test_a_signal_leaves_older_formats_and_no_halves(copy):
    export_dataset(copy, ("mot",), jobs=1)
    older = contents(copy / "mot")
    process = started("dataset", "export", copy, "--to", "parquet,hdf5,mot", "--jobs", "2")
    wait_until(lambda: list(copy.glob(".part-*")), process)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 130
    assert errors.strip().splitlines()[-1] == (
        f"pjpdaf-bench: interrupted: not all formats of {copy} are written, nor their checksums; "
        "the same command writes them anew"
    )
    assert not list(copy.glob(".part-*"))
    assert contents(copy / "mot") == older


@pytest.mark.long
@needs_small_disk
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_full_disk_is_one_line_and_the_data_set_stays(made, jobs):
    """The library of HDF5 would end the process at a full disk."""
    words = " ".join(command("dataset", "export", "/mnt/set", "--to", "hdf5", "--jobs", jobs))
    size_kb = sum(p.stat().st_size // 4096 * 4 + 4 for p in made.rglob("*") if p.is_file()) + 250
    script = f"cp -r {made} /mnt/set; {{ {words}; echo rc $?; ls -A /mnt/set; }}"
    done = in_a_small_disk(script, f"{size_kb}k")
    assert "rc 5" in done.stdout, done.stdout + done.stderr
    assert messages(done) == [
        "pjpdaf-bench: /mnt/set/hdf5: cannot write the HDF5 files: No space left on device. Free "
        "some space there, or write to another disk."
    ]
    assert "hdf5" not in done.stdout
    assert ".part" not in done.stdout
