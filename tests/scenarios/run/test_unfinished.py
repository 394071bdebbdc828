"""The folder of an unfinished run: one process at a time, nothing finished is lost."""

from dataclasses import replace

import pytest

from pjpdaf.errors import BenchError
from reports.run.rows import rows_of
from reports.score.records import EpisodeFailure
from scenarios.console.folder import default_folder
from scenarios.execute.journal import FILE
from scenarios.play.job import Job, System
from scenarios.play.plan import PlanRequest
from scenarios.run.request import REQUEST, RunRequest, read_request
from scenarios.run.unfinished import reserved, unfinished_run
from scenarios.spec.names import load_scenario

JOBS = [Job(load_scenario("cross"), seed, {"frames": 2}, System()) for seed in range(3)]


def asked(folder):
    return RunRequest(PlanRequest(("cross",), seeds=3), out=folder)


def rows(seed, kind="plug-in"):
    return rows_of(EpisodeFailure("cross", seed, "no step today", "g", "digest", kind))


def begun(folder, *seeds):
    """A run that was killed after these episodes."""
    with reserved(asked(folder), JOBS, ()) as run:
        for seed in seeds:
            run.keep(JOBS[seed], rows(seed))
        return run.part


def test_what_is_finished_is_there_the_next_time(tmp_path):
    part = begun(tmp_path / "r", 2, 0)
    assert part == tmp_path / "r.part"
    with reserved(asked(tmp_path / "r"), JOBS, ()) as run:
        assert {index: row.seed for index, row in run.finished.items()} == {0: 0, 2: 2}
        assert repr(run.finished[2]) == repr(rows(2))
        assert run.staged == part / "r"
    assert read_request(part / REQUEST) == replace(asked(None), jobs=None)


def test_a_second_process_is_refused_at_once(tmp_path):
    folder = tmp_path / "r"
    with (
        reserved(asked(folder), JOBS, ()),
        pytest.raises(BenchError, match=r"r\.part: another process is writing there"),
        reserved(asked(folder), JOBS, ()),
    ):
        pass


def test_another_run_is_refused(tmp_path):
    begun(tmp_path / "r", 1)
    other = [replace(job, system=System(tracker="thesis")) for job in JOBS]
    with (
        pytest.raises(BenchError, match=r"r\.part: holds results of other work"),
        reserved(asked(tmp_path / "r"), other, ()),
    ):
        pass
    with reserved(asked(tmp_path / "r"), JOBS, ()) as run:
        assert [*run.finished] == [1]


def test_where_nothing_is_finished_nothing_is_left(tmp_path):
    assert not begun(tmp_path / "r").exists()
    with pytest.raises(RuntimeError), reserved(asked(tmp_path / "r"), JOBS, ()):
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []


def test_failures_of_the_machine_are_played_again(tmp_path):
    with reserved(asked(tmp_path / "r"), JOBS, ()) as run:
        for job, kind in zip(JOBS, ("worker died", "time limit", "exception"), strict=True):
            run.keep(job, rows(job.seed, kind))
    with reserved(asked(tmp_path / "r"), JOBS, ()) as run:
        assert [*run.finished] == [2]


def test_default_names_never_meet(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    request = asked(None)
    with reserved(request, JOBS, ("cross",)) as one, reserved(request, JOBS, ("cross",)) as other:
        assert one.folder != other.folder
        assert default_folder(("cross",)).absolute() not in (one.folder, other.folder)
        assert not one.shown.is_absolute()


def test_a_folder_of_something_else_is_refused(tmp_path):
    (tmp_path / "r").mkdir()
    (tmp_path / "r" / "mine.txt").write_text("mine")
    with (
        pytest.raises(BenchError, match="exists and is not empty"),
        reserved(asked(tmp_path / "r"), JOBS, ()),
    ):
        pass
    begun(tmp_path / "s", 0)
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / "mine.txt").write_text("mine")
    with (
        pytest.raises(BenchError, match="is not a saved run, so it is not replaced"),
        reserved(asked(tmp_path / "s"), JOBS, ()),
    ):
        pass
    (tmp_path / "t.part").mkdir()
    (tmp_path / "t.part" / "mine.txt").write_text("mine")
    with (
        pytest.raises(BenchError, match=r"t\.part: exists and is not empty"),
        reserved(asked(tmp_path / "t"), JOBS, ()),
    ):
        pass
    assert (tmp_path / "t.part" / "mine.txt").read_text() == "mine"


def test_a_damaged_episode_is_played_again(tmp_path):
    part = begun(tmp_path / "r", 0, 1)
    data = (part / FILE).read_bytes()
    (part / FILE).write_bytes(data[:-20])
    with reserved(asked(tmp_path / "r"), JOBS, ()) as run:
        assert [*run.finished] == [0]


def test_resume_takes_either_name(tmp_path):
    begun(tmp_path / "r", 0)
    assert unfinished_run(tmp_path / "r") == unfinished_run(tmp_path / "r.part") == tmp_path / "r"
    with pytest.raises(BenchError, match=r"no\.part: no such unfinished run"):
        unfinished_run(tmp_path / "no")
    (tmp_path / "done").mkdir()
    (tmp_path / "done" / "run.json").write_text("{}")
    with pytest.raises(BenchError, match="done: is finished; there is nothing to go on with"):
        unfinished_run(tmp_path / "done")


@pytest.mark.parametrize("name", ["/", "x" * 255])
def test_a_folder_that_cannot_be_is_one_line(tmp_path, name):
    with pytest.raises(BenchError, match=r"exists and is not empty|File name too long"):
        begun(tmp_path / name)
    with pytest.raises(BenchError, match=r"no such unfinished run|File name too long"):
        unfinished_run(tmp_path / name)
