"""The journal: what it has kept is there after a kill, and nothing else is believed."""

import resource
import signal
import subprocess
import sys

import pytest

from pjpdaf.errors import BenchError
from scenarios.execute.journal import FILE, Journal


def kept(folder, identity="work"):
    with Journal.open(folder, identity) as journal:
        return dict(journal.finished)


def filled(folder, count=5):
    with Journal.open(folder, "work") as journal:
        for number in range(count):
            journal.append(f"k{number}", bytes([number]) * (10 + number))
    return folder


def test_results_are_there_again(tmp_path):
    folder = filled(tmp_path / "new" / "run")
    assert kept(folder) == {f"k{n}": bytes([n]) * (10 + n) for n in range(5)}


def test_a_torn_tail_is_cut_at_any_byte(tmp_path):
    folder = filled(tmp_path / "run")
    whole = (folder / FILE).read_bytes()
    for cut in range(len(whole) - 1, len(whole) - 60, -1):
        (folder / FILE).write_bytes(whole[:cut])
        with Journal.open(folder, "work") as journal:
            # The last record has 32 bytes of head, 2 of key, 14 of payload.
            assert len(journal.finished) == (4 if cut >= len(whole) - 48 else 3)
            journal.append("again", b"x")
        assert kept(folder)["again"] == b"x"


def test_a_damaged_record_is_dropped_and_the_others_stay(tmp_path):
    folder = filled(tmp_path / "run")
    whole = bytearray((folder / FILE).read_bytes())
    whole[whole.index(b"\x02" * 12) + 3] ^= 0xFF
    (folder / FILE).write_bytes(whole)
    with Journal.open(folder, "work") as journal:
        assert sorted(journal.finished) == ["k0", "k1", "k3", "k4"]
        assert journal.dropped > 0


def test_a_damaged_length_loses_no_later_record(tmp_path):
    folder = filled(tmp_path / "run")
    whole = bytearray((folder / FILE).read_bytes())
    at = whole.index(b"k1") - 32
    whole[at + 8 : at + 16] = b"\xff" * 8
    (folder / FILE).write_bytes(whole)
    assert sorted(kept(folder)) == ["k0", "k2", "k3", "k4"]


def test_a_second_process_is_refused_at_once(tmp_path):
    with Journal.open(tmp_path / "run", "work"):
        code = (
            "import sys, pathlib; from scenarios.execute.journal import Journal\n"
            "from pjpdaf.errors import BenchError\n"
            "try:\n with Journal.open(pathlib.Path(sys.argv[1]), 'work'): pass\n"
            "except BenchError as fault: print(fault)"
        )
        done = subprocess.run(
            [sys.executable, "-c", code, str(tmp_path / "run")], capture_output=True, text=True
        )
    assert "another process is writing there" in done.stdout


def test_other_work_is_refused(tmp_path):
    folder = filled(tmp_path / "run")
    with pytest.raises(BenchError, match="other work, or of another version"):
        kept(folder, "other")
    assert len(kept(folder)) == 5


def test_a_folder_of_something_else_is_refused(tmp_path):
    (tmp_path / "mine.txt").write_text("x")
    with pytest.raises(BenchError, match="exists and is not empty"):
        kept(tmp_path)
    with pytest.raises(BenchError, match="is a file"):
        kept(tmp_path / "mine.txt")


def test_a_full_disk_loses_nothing(tmp_path):
    folder = filled(tmp_path / "run")
    size = (folder / FILE).stat().st_size
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        with Journal.open(folder, "work") as journal:
            resource.setrlimit(resource.RLIMIT_FSIZE, (size + 100, before[1]))
            with pytest.raises(BenchError, match="cannot write the journal"):
                journal.append("large", bytes(1000))
            journal.append("small", b"x")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, ignored)
    assert sorted(kept(folder)) == ["k0", "k1", "k2", "k3", "k4", "small"]
