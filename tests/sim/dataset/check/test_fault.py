"""The line of a fault, and the log that reads files and collects faults."""

from pathlib import Path

import pytest

from pjpdaf.errors import FileError
from sim.dataset.check.fault import Fault, FaultLog, FrameFault
from sim.dataset.files.reading import read_json


def test_faults_are_one_printable_line():
    text = str(Fault("a\x1b[31m\nb", "what\x07"))
    assert text.isprintable()


def test_faults_of_frames_become_a_fault_per_file_and_kind():
    log = FaultLog(Path("set"))
    frames = [FrameFault("t", "box", frame, f"is {frame}") for frame in (7, 3, 3)]
    assert not log.add("masks", [*frames, FrameFault("t", "centroid", 0, "is off")])
    assert log.add("files", [Fault("a", "missing")])
    assert log.all() == (
        Fault("a", "missing"),
        Fault("t", "box: frame 3: is 3 (and in 1 more frames)"),
        Fault("t", "centroid: frame 0: is off"),
    )
    assert [fault.check for fault in log.all()] == ["files", "masks", "masks"]


def test_a_reader_s_error_becomes_the_fault_of_its_file(tmp_path):
    log = FaultLog(tmp_path)
    (tmp_path / "seq").mkdir()
    (tmp_path / "seq" / "list.json").write_text("[]")
    (tmp_path / "seq" / "good.json").write_text('{"a": 1}')
    assert log.read(lambda: read_json(tmp_path / "seq" / "good.json")) == {"a": 1}
    for name in ("list", "none"):
        assert log.read(lambda name=name: read_json(tmp_path / "seq" / f"{name}.json")) is None
    expected = [
        Fault("seq/list.json", "is not a JSON object"),
        Fault("seq/none.json", "missing"),
    ]
    assert log.faults == expected


def test_a_fault_of_a_file_has_its_fields_and_its_line():
    error = FileError(Path("sets") / "SHA256SUMS", "is not a line of checksums", 3)
    assert str(error) == "sets/SHA256SUMS:3: is not a line of checksums."
    assert (error.file, error.cause) == (Path("sets/SHA256SUMS"), "is not a line of checksums")
    with pytest.raises(FileError, match="nowhere: cannot be read"):
        read_json(Path("nowhere"))
