"""Shards of a run: put together they are the run; what is missing or does not fit is named."""

import functools
from dataclasses import replace

import pytest
from commands import in_this_process
from made_dataset import contents, made_dataset
from point_episodes import all_seen, apart, episode_of

from pjpdaf.errors import BenchError, InfrastructureError, NotComparable
from reports.run.rows import rows_of
from reports.score.records import EpisodeFailure
from scenarios.console.interrupts import interrupts
from scenarios.execute.episodes import results_of
from scenarios.play.plan import PlanRequest, plan
from scenarios.run.finish import finish_run
from scenarios.run.merge import MergeRequest, merge_shards
from scenarios.run.request import RunRequest, Shard, parse_shard
from scenarios.run.unfinished import reserved, reserved_shard

REQUEST = RunRequest(PlanRequest(("cross", "bounce"), seeds=3), slim=True)
JOBS = plan(REQUEST.plan)


@pytest.fixture(scope="module")
def rows():
    """Rows for each job: of one synthetic episode, as if each scenario and seed had it."""
    episode = episode_of(apart, all_seen, frames=12)
    of_job = functools.cache(lambda name, seed: rows_of(replace(episode, scenario=name, seed=seed)))
    return lambda job, **changes: replace(of_job(job.name, job.seed), **changes)


def play(folder, index, rows, count=2, request=REQUEST, kept=lambda job: True, **changes):
    """A shard as it is after its command."""
    jobs = plan(request.plan)
    with reserved_shard(request, Shard(index, count), folder, jobs) as run:
        for job in run.jobs:
            if kept(job):
                run.keep(job, rows(job, stage_s={"detect": float(index)}, **changes))


def request_of(shard, request=REQUEST):
    return replace(request, shard=Shard(*shard))


def merge(*folders, out):
    merge_shards(MergeRequest(folders, out))


def tables(folder):
    files = contents(folder)
    return {name: digest for name, digest in files.items() if name != "run.json"}


def shards(tmp_path, rows, count=3):
    for index in range(1, count + 1):
        request = request_of((index, count))
        play(tmp_path / str(index), index, rows, count, request)
    return [tmp_path / str(index) for index in range(1, count + 1)]


def test_merged_shards_are_the_run(tmp_path, rows, capsys):
    whole = replace(REQUEST, out=tmp_path / "whole")
    with reserved(whole, JOBS, ()) as run, interrupts() as arrived:
        finish_run(whole, run, results_of(dict(enumerate(map(rows, JOBS)))), "here", arrived)
    one, two, three = shards(tmp_path, rows)
    merge(three, one, two, one, out=tmp_path / "merged")
    assert tables(tmp_path / "merged") == tables(tmp_path / "whole")
    assert "6 episodes, 72 stereo frames of 4 shards" in capsys.readouterr().out
    assert sorted(p.name for p in tmp_path.iterdir()) == ["1", "2", "3", "merged", "whole"]


def test_a_missing_shard_and_an_unfinished_one_are_named(tmp_path, rows):
    one, two, three = shards(tmp_path, rows)
    with pytest.raises(BenchError, match=r"shards 1/3, 3/3 are missing, with 4 episodes; name"):
        merge(two, out=tmp_path / "m")
    with pytest.raises(BenchError, match=r"^shard 3/3 is missing, with 2 episodes; name all"):
        merge(one, two, out=tmp_path / "m")
    late = tmp_path / "late"
    play(late, 2, rows, 3, request_of((2, 3)), kept=lambda job: job.name == "cross")
    with pytest.raises(BenchError, match=r"late: is not finished: 1 episode missing, the first b"):
        merge(one, late, three, out=tmp_path / "m")
    assert not (tmp_path / "m").exists()


def test_duplicates_must_agree_but_for_times(tmp_path, rows):
    one, two, three = shards(tmp_path, rows)
    play(tmp_path / "x", 2, rows, 3, request_of((2, 3)), truth="other")
    with pytest.raises(NotComparable, match=r"cross seed 1: .*2 and .*x do not agree; leave out"):
        merge(one, two, tmp_path / "x", three, out=tmp_path / "m")


def test_an_episode_that_failed_for_the_machine_is_kept_as_failed(tmp_path, rows):
    one, two, three = shards(tmp_path, rows)
    with reserved_shard(request_of((2, 3)), Shard(2, 3), tmp_path / "x", JOBS) as run:
        for job in run.jobs:
            failed = EpisodeFailure(job.name, job.seed, "died", "g", "d", "worker died")
            run.keep_failure(job, rows_of(failed))
    with pytest.raises(InfrastructureError, match=r"2 of 6 episodes gave no result, the first: cr"):
        merge(one, tmp_path / "x", three, out=tmp_path / "m")
    merge(one, tmp_path / "x", two, three, out=tmp_path / "n")  # played to their end elsewhere
    with reserved_shard(request_of((2, 3)), Shard(2, 3), tmp_path / "x", JOBS) as run:
        assert run.finished == {}  # they are played again


def test_shards_of_different_runs_are_refused(tmp_path, rows):
    one, two, _ = shards(tmp_path, rows)
    other = replace(REQUEST, plan=replace(REQUEST.plan, first_seed=5))
    play(tmp_path / "x", 3, rows, 3, request_of((3, 3), other))
    with pytest.raises(
        NotComparable, match=r"x: is a shard of another run .*: first_seed 5, there"
    ):
        merge(one, two, tmp_path / "x", out=tmp_path / "m")
    play(tmp_path / "y", 2, rows, 2, request_of((2, 2)))
    with pytest.raises(NotComparable, match=r"y: is shard 2 of 2, .*divided in two ways"):
        merge(one, tmp_path / "y", out=tmp_path / "m")
    (two / "journal.bin").unlink()
    (two / "request.json").unlink()
    with reserved_shard(request_of((2, 3)), Shard(2, 3), two, JOBS[:4]):  # another identity
        pass
    with pytest.raises(NotComparable, match=r"2: was played with other code, plug-ins or versions"):
        merge(one, two, out=tmp_path / "m")


def test_a_folder_that_is_no_shard_and_a_shard_of_another_number(tmp_path, rows):
    one, two, _ = shards(tmp_path, rows)
    with pytest.raises(BenchError, match=r"no: is no shard of a run: there is no request.json"):
        merge(tmp_path / "no", out=tmp_path / "m")
    with (
        pytest.raises(BenchError, match=r"1: holds shard 1 of 3; give shard 2 of 3 another folder"),
        reserved_shard(request_of((2, 3)), Shard(2, 3), one, JOBS),
    ):
        pass
    with (
        reserved_shard(request_of((2, 3)), Shard(2, 3), two, JOBS),
        pytest.raises(BenchError, match=r"2: another process is writing there"),
    ):
        merge(one, two, out=tmp_path / "m")
    with (
        pytest.raises(BenchError, match=r"--shard 9/9: the run has 6 episodes"),
        reserved_shard(request_of((9, 9)), Shard(9, 9), tmp_path / "z", JOBS),
    ):
        pass


@pytest.mark.long
def test_shards_of_a_command_are_its_run_with_pictures_and_films(tmp_path, tmp_path_factory):
    footage = made_dataset(tmp_path_factory)
    words = ("run", "--from", footage, "--set", "detector.background_learn_min=2", "--films")
    words = (*words, "--jobs", 1)
    assert in_this_process(*words, "--out", tmp_path / "whole").returncode == 0
    folders = [tmp_path / str(index) for index in (1, 2, 3)]
    for index, out in enumerate(folders, 1):
        done = in_this_process(*words, "--shard", f"{index}/3", "--out", out)
        assert done.returncode == 0, done.stderr
        assert f"shard {index} of 3: {2 if index == 1 else 1} of 4 episodes" in done.stdout
        again = in_this_process(*words, "--shard", f"{index}/3", "--out", out)
        assert "were there" in again.stdout
    merged = in_this_process("merge", *reversed(folders), "--out", tmp_path / "m")
    assert merged.returncode == 0, merged.stderr
    found, wanted = tables(tmp_path / "m"), tables(tmp_path / "whole")
    assert found.pop("report.html") != wanted.pop("report.html")  # it shows times
    assert found == wanted
    assert any(name.endswith(".jpg") for name in found)
    assert any(name.endswith(".zip") for name in found)


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "1/0", "a/b", "1/2/3", "-1/2"])
def test_a_shard_that_is_none_is_one_line(text):
    with pytest.raises(BenchError, match=r"--shard .*: must be I/K"):
        parse_shard(text)


def test_shards_divide_the_episodes():
    parts = [[n for n in range(10) if Shard(i, 3).owns(n)] for i in (1, 2, 3)]
    assert sorted(n for part in parts for n in part) == list(range(10))
    assert max(map(len, parts)) - min(map(len, parts)) <= 1
