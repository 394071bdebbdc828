"""The request of a run as a file: read back as it was, and no code is run that it alone names."""

from pathlib import Path

import pytest

from pjpdaf.errors import BenchError
from scenarios.play.plan import PlanRequest
from scenarios.run.request import RunRequest, read_request, resume_command, write_request

PLAN = PlanRequest(
    targets=("cross", "my.yaml"),
    seeds=3,
    first_seed=5,
    only=("cross",),
    settings=("speed=0.3 m/s",),
    detector="thesis",
    tracker="default",
    keep_pictures=True,
    keep_films=True,
    dataset=Path("sets/a"),
    use_cache=False,
)
REQUEST = RunRequest(PLAN, "thesis", argv=("run", "cross"), slim=True, time_limit_s=7.5)


def with_plug_in(tmp_path, **names):
    path = tmp_path / "request.json"
    write_request(path, RunRequest(PlanRequest(("cross",), **names)))
    return path


def test_it_comes_back(tmp_path):
    path = tmp_path / "request.json"
    write_request(path, REQUEST)
    assert read_request(path) == REQUEST


def test_folder_and_processes_are_those_of_the_call(tmp_path):
    path = tmp_path / "request.json"
    write_request(path, RunRequest(PLAN, jobs=4, out=Path("here")))
    found = read_request(path)
    assert (found.jobs, found.out) == (None, None)


def test_a_plug_in_must_be_named_again(tmp_path):
    path = with_plug_in(tmp_path, tracker="os:system")
    with pytest.raises(BenchError, match="was begun with --tracker os:system; give that again"):
        read_request(path)
    with pytest.raises(BenchError, match="was begun with --tracker os:system, got mine:make"):
        read_request(path, tracker="mine:make")
    assert read_request(path, tracker="os:system").plan.tracker == "os:system"
    path = with_plug_in(tmp_path, detector="os:system")
    with pytest.raises(BenchError, match="was begun with --detector os:system"):
        read_request(path, tracker="default")


def test_the_command_that_goes_on_names_them():
    assert resume_command(Path("r"), REQUEST) == "pjpdaf-bench run --resume r"
    request = RunRequest(PlanRequest(("cross",), detector="a:b", tracker="mine:make"))
    assert resume_command(Path("my runs"), request) == (
        "pjpdaf-bench run --resume 'my runs' --detector a:b --tracker mine:make"
    )
    of_files = RunRequest(PlanRequest(detector="d.csv", detections=Path("d.csv")))
    assert resume_command(Path("r"), of_files) == "pjpdaf-bench run --resume r"


def test_detections_of_a_file_are_no_plug_in(tmp_path):
    path = with_plug_in(tmp_path, detector="d.csv", detections=Path("d.csv"), dataset=Path("s"))
    assert read_request(path).plan.detections == Path("d.csv")


@pytest.mark.parametrize("content", ["", "[]", '{"plan": 1}', '{"argv": 3}', "{" * 10_000])
def test_a_damaged_file_is_one_line(tmp_path, content):
    path = tmp_path / "request.json"
    path.write_text(content)
    with pytest.raises(BenchError, match=r"request\.json: is damaged: ") as fault:
        read_request(path)
    assert "\n" not in str(fault.value)
    with pytest.raises(BenchError, match="cannot be read"):
        read_request(tmp_path / "missing.json")
