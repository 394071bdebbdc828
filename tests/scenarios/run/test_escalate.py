"""Escalation on real, small runs: the reserve is played, joined and judged."""

import json
import sys
from dataclasses import replace

import pytest

from reports.gate.gate import compare
from reports.gate.pairing import NotComparable
from reports.run.load import load
from scenarios.execute.episodes import play_all
from scenarios.execute.local import local_executor
from scenarios.play.job import digest_of
from scenarios.play.plan import PlanRequest, plan
from scenarios.run.compare import CompareRequest, compare_runs
from scenarios.run.escalate import (
    FIRST_RESERVE_SEED,
    LOOKS,
    ROUNDS,
    CannotEscalate,
    escalate,
    manual_command,
    planned_jobs,
    play_round,
    refusal,
    request_of,
    reserve_jobs,
    same_episode,
)
from scenarios.run.save_run import save_run

SHORT = ("frames=3", "fps=1")  # in three seconds a useless tracker can fall behind
SHORT += ("background_frames=2", "detector.background_learn_min=2")


def asked(*settings, targets=("cross",), seeds=2, first_seed=100):
    return PlanRequest(
        targets,
        seeds,
        first_seed,
        settings=(*SHORT, *settings),
        detector="thesis",
        tracker="thesis",
    )


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reserve")
    found = []
    with pytest.MonkeyPatch.context() as patch:  # both trackers are shown the same pictures
        patch.setenv("PJPDAF_BENCH_CACHE", str(folder / "cache"))
        with local_executor(1) as executor:
            for name, settings in {"base": (), "new": ("tracker.measurement_px2=1e7",)}.items():
                request = asked(*settings)
                jobs = plan(request)
                played = play_all(jobs, executor)
                found.append(save_run(request, jobs, played, folder / name, preset="thesis"))
    return found


def test_a_run_says_all_that_is_needed_to_go_on_with_it(runs):
    for run in runs:
        again = load(run.folder)
        assert request_of(again) == asked(*again.meta["request"]["settings"][len(SHORT) :])
        jobs = planned_jobs(again)
        assert [job.seed for job in jobs] == [100, 101]
        assert jobs[0].system.tracker_settings == dict(
            pair.removeprefix("tracker.").split("=")
            for pair in again.meta["request"]["settings"][len(SHORT) :]
        )


def test_the_reserve_is_new_seeds_in_the_sizes_that_were_fixed(runs):
    jobs = planned_jobs(runs[0])
    seeds = [[job.seed - FIRST_RESERVE_SEED for job in reserve_jobs(jobs, k)] for k in range(3)]
    assert seeds == [[0, 1], [2, 3, 4, 5], [6, 7, 8, 9, 10, 11, 12, 13]]
    assert ROUNDS == (1, 2, 4)
    assert LOOKS == 4
    assert not any(job.keep_pictures for job in reserve_jobs(jobs, 0))


def test_scenarios_of_a_suite_keep_their_own_number_of_seeds():
    jobs = plan(asked(targets=("cross", "drink"), seeds=1, first_seed=0))
    mixed = [*jobs, replace(jobs[0], seed=1), replace(jobs[0], seed=2)]
    found = [(job.name, job.seed - FIRST_RESERVE_SEED) for job in reserve_jobs(mixed, 1)]
    assert found == [*(("cross", k) for k in range(3, 9)), ("drink", 1), ("drink", 2)]


@pytest.mark.long
def test_a_round_is_played_for_both_saved_and_joined(executor, runs, tmp_path):
    plans = [planned_jobs(run) for run in runs]
    done = []

    def on_round(number, jobs):
        return lambda index, rows: done.append(len(jobs))

    grown = play_round(runs, plans, 0, executor, tmp_path, on_round)
    assert done == [4] * 4
    for run, name in zip(grown, ("base", "new"), strict=True):
        assert run.meta["scenarios"][0]["seeds"] == [100, 101, 1_000_000, 1_000_001]
        assert len(run.episodes) == 4 * 3
        saved = load(tmp_path / f"{name}-1")
        assert saved.slim
        assert saved.meta["request"]["targets"] == ["cross"]
    verdict = compare(*grown, looks=LOOKS)
    assert verdict.episodes == 4
    assert verdict.alpha == 0.05 / 4
    # The same seeds in both: the reserve can be paired.
    assert compare(grown[0], grown[0]).identical
    with pytest.raises(NotComparable, match="lacks 2 of 4"):
        compare(runs[0], grown[1])


def test_an_episode_played_again_is_recognised_and_another_is_not(executor, runs):
    job = planned_jobs(runs[0])[0]
    (row,) = play_all([job], executor).rows
    assert same_episode(runs[0], row)
    assert not same_episode(runs[1], row)


def with_provenance(run, **changes):
    made = {**run.meta["provenance"], "commit": "a" * 40, "dirty": False, **changes}
    return replace(run, meta={**run.meta, "provenance": made})


def test_only_the_very_code_that_made_both_runs_goes_on_with_them(runs):
    base, new = (with_provenance(run) for run in runs)
    here = base.meta["provenance"]
    assert refusal(base, new, here) == ""
    reason = refusal(with_provenance(base, commit="b" * 40), new, here)
    assert reason.endswith("was made by commit bbbbbbbbbbbb, this is aaaaaaaaaaaa")
    assert "not committed" in refusal(base, with_provenance(new, dirty=True), here)
    assert refusal(base, new, {**here, "dirty": True}).startswith("this checkout has changes")
    older = {**here["versions"], "mujoco": "3.0"}
    assert "made with mujoco 3.0" in refusal(with_provenance(base, versions=older), new, here)
    installed = {**here, "commit": None, "dirty": None}
    pair = [with_provenance(run, commit=None, dirty=None) for run in runs]
    assert refusal(*pair, installed) == ""
    unknown = replace(base, meta={**base.meta, "request": {}})
    assert "does not say how it was started" in refusal(unknown, new, here)


def test_what_cannot_be_continued_says_how_to_do_it_by_hand(runs):
    assert manual_command(runs[1], "so it is") == (
        "inconclusive, and the reserve cannot be played here: so it is; play it with each of the "
        "two versions and compare these runs: pjpdaf-bench run cross --preset thesis "
        "--set frames=3 --set fps=1 --set background_frames=2 "
        "--set detector.background_learn_min=2 --set tracker.measurement_px2=1e7 "
        "--first-seed 1000000 --seeds 14 --slim --out DIR"
    )
    other = [{**one, "digests": ["x", "y"]} for one in runs[0].meta["scenarios"]]
    with pytest.raises(CannotEscalate, match="have changed") as caught:
        planned_jobs(replace(runs[0], meta={**runs[0].meta, "scenarios": other}))
    assert caught.value.exit_code == 3


def test_only_plug_ins_that_the_command_line_names_are_imported(runs, tmp_path, monkeypatch):
    (tmp_path / "theirs.py").write_text("raise SystemExit('imported')\n")
    monkeypatch.chdir(tmp_path)
    meta = {**runs[0].meta, "tracker": "theirs:make", "preset": "default; ls"}
    strange = replace(runs[0], meta=meta)
    with pytest.raises(CannotEscalate, match="--plug-in theirs:make") as caught:
        planned_jobs(strange)
    assert "--preset 'default; ls'" in str(caught.value)
    assert "theirs" not in sys.modules
    with pytest.raises(CannotEscalate, match="SystemExit: imported"):
        planned_jobs(strange, ("theirs:make",))


def test_the_digests_of_the_reserve_do_not_depend_on_the_system(runs):
    jobs = [reserve_jobs(planned_jobs(run), 0) for run in runs]
    assert [digest_of(job) for job in jobs[0]] == [digest_of(job) for job in jobs[1]]


def test_the_verb_says_what_it_cannot_do_and_stays_inconclusive(runs, tmp_path, capsys):
    file = runs[0].folder / "run.json"
    text = file.read_text()
    commit = runs[0].meta["provenance"]["commit"]
    try:
        old = f'"commit": {json.dumps(commit)}'
        assert old in text
        file.write_text(text.replace(old, '"commit": "abc"'))
        code = compare_runs(verb(runs, tmp_path))
    finally:
        file.write_text(text)
    said = capsys.readouterr()
    assert code == 3
    start = "pjpdaf-bench: inconclusive, and the reserve cannot be played here: "
    assert said.err.strip().startswith(start)
    assert "was made by commit abc" in said.err
    assert "inconclusive: " in said.out
    assert not (tmp_path / "reserve").exists()


def verb(runs, out):
    return CompareRequest(
        base=runs[0].folder,
        new=runs[1].folder,
        margins_file=None,
        margins=(),
        out=out,
        escalate=True,
        jobs=2,
        argv=(),
    )


@pytest.mark.long  # 28 episodes
def test_the_reserve_decides_what_two_seeds_cannot(executor, runs, tmp_path):
    base, new = (with_provenance(run) for run in runs)
    here = base.meta["provenance"]
    rounds = []

    def on_round(number, jobs):
        rounds.append(len(jobs))
        return lambda index, rows: None

    assert compare(base, new, looks=LOOKS).verdict == "inconclusive"
    verdict = escalate(base, new, {}, executor, tmp_path, on_round, here)
    assert rounds == [4, 8, 16][: len(rounds)]
    assert verdict.episodes == 2 + sum(rounds) // 2
    assert verdict.looks == LOOKS
    assert verdict.verdict != "inconclusive" or len(rounds) == 3
    assert len(list(tmp_path.iterdir())) == 2 * len(rounds)
