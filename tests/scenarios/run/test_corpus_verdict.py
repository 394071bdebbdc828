"""The verdict on corpus cases: what is as its status says, and what is not."""

import pytest

from reports.run.rows import rows_of
from scenarios.play.fast import play_fast
from scenarios.play.job import System
from scenarios.run.corpus_verdict import (
    CaseOutcome,
    FixedCaseFails,
    outcomes_of,
    refuse_regressions,
    verdict_lines,
)
from scenarios.spec.corpus_case import corpus_cases, corpus_files
from scenarios.stress.case_file import case_of, corpus_case, load_case, write_case
from scenarios.stress.replay import case_from_settings

THESIS = System("thesis", "thesis")


def outcome(status, rho, tracker="thesis", system=THESIS):
    case = case_from_settings("cross", {}, 0)
    record = corpus_case("c", case, System("thesis", tracker), "swap", -1.0, status)
    return CaseOutcome(record, system, rho)


def test_only_a_fixed_case_that_fails_with_its_own_tracker_is_a_regression():
    assert outcome("fixed", -0.1).regression
    assert outcome("fixed", None).regression
    assert not outcome("fixed", 0.1).regression
    assert not outcome("open", -0.1).regression
    assert not outcome("fixed", -0.1, tracker="default").regression
    with pytest.raises(FixedCaseFails, match="1 fixed case of the corpus fails again") as fault:
        refuse_regressions([outcome("fixed", -0.1), outcome("open", -1.0)])
    assert fault.value.exit_code == 1


def test_the_lines_name_what_is_not_as_its_status_says():
    as_said = [outcome("fixed", 0.5), outcome("open", -0.5)]
    assert list(verdict_lines(as_said)) == ["corpus: 2 cases; of 1 fixed 0 fail, of 1 open 1 fail"]
    lines = list(verdict_lines([*as_said, outcome("open", 0.25)]))
    assert lines[1:] == ["c: open for thesis: swap does not happen (rho +0.25)"]
    (*_, other) = verdict_lines([outcome("open", 0.25, tracker="default")])
    assert other == "c: open for default: swap does not happen (rho +0.25) with thesis"
    assert list(verdict_lines([])) == []


def test_rho_is_computed_from_the_rows_of_the_run(tmp_path):
    case = case_from_settings("cross", {"frames": 4}, 3)
    record = corpus_case("my_case", case, THESIS, "lost_left", -1.0, "open")
    write_case(tmp_path / "c.yaml", record)
    job = case.job(THESIS, label="my_case")
    (got,) = outcomes_of((str(tmp_path / "c.yaml"), "smoke"), [job], [rows_of(play_fast(job))])
    assert got.case == record
    assert 0 < got.rho <= 1


@pytest.mark.parametrize("path", corpus_files(), ids=lambda path: path.stem)
def test_every_shipped_case_is_still_the_episode_that_failed(path):
    record = load_case(path)
    assert record.name == path.stem
    assert record.rho < 0
    assert case_of(record).digest == record.digest


def test_the_corpus_has_no_case_twice():
    cases = corpus_cases("corpus")
    assert len({(c.digest, c.tracker, c.event) for c in cases}) == len(cases) > 20
