"""Case files: written, read back, refused where they are of something else."""

from pathlib import Path

import pytest

from pjpdaf.errors import BenchError, NotComparable
from scenarios.play.job import System
from scenarios.play.plan import PlanRequest, plan
from scenarios.spec.corpus_case import (
    corpus_suite,
    is_corpus_file,
    load_corpus_case,
    numbered_label,
)
from scenarios.spec.faults import FileFault
from scenarios.spec.motion.plugged import TRUSTED_VARIABLE
from scenarios.stress.case import Case
from scenarios.stress.case_file import (
    case_of,
    case_text,
    corpus_case,
    load_case,
    system_of,
    system_to_play,
    write_case,
)
from scenarios.stress.families import FAMILIES, find_family
from scenarios.stress.replay import case_from_settings, promote
from scenarios.stress.space import Space

SCRIPT = str(Path(__file__).parents[3] / "examples" / "motion" / "drink_script.yaml")
SYSTEM = System("default", "thesis", {}, {"gate": "4"})


def record_of(family="cross", seed=11):
    space = Space.of(find_family(family))
    values = space.values_of_unit([0.3] * len(space.axes))
    return corpus_case(
        "a_case", Case(family, values, seed), SYSTEM, "swap", -0.5, "open", 'found "here": it'
    )


@pytest.mark.parametrize("family", FAMILIES)
def test_a_case_is_read_back_as_it_was(family, tmp_path):
    record = record_of(family)
    write_case(tmp_path / "c.yaml", record)
    assert load_case(tmp_path / "c.yaml") == record
    assert case_of(record).digest == record.digest
    assert system_of(record) == SYSTEM
    assert case_text(load_case(tmp_path / "c.yaml")) == (tmp_path / "c.yaml").read_text()


def test_a_case_of_a_scenario_file_names_the_file_and_stays_out_of_the_corpus(tmp_path):
    record = record_of(SCRIPT)
    write_case(tmp_path / "c.yaml", record)
    assert load_case(tmp_path / "c.yaml") == record
    assert record.family == record.scenario == SCRIPT
    (job,) = plan(PlanRequest(targets=(str(tmp_path / "c.yaml"),)))
    assert (job.scenario.name, job.seed) == ("drink_script", 11)
    with pytest.raises(BenchError, match="the corpus keeps cases of shipped scenarios"):
        promote(tmp_path / "c.yaml", None, tmp_path, "open")


def test_a_case_of_somebody_else_starts_no_code(tmp_path, monkeypatch):
    monkeypatch.setenv(TRUSTED_VARIABLE, "")
    path = changed(tmp_path, "family: cross\n", 'family: "antigravity:geohash"\n')
    with pytest.raises(BenchError, match="a file alone does not start code"):
        load_case(path)


def test_run_plays_a_case_with_its_seed(tmp_path):
    write_case(tmp_path / "c.yaml", record_of())
    (job,) = plan(PlanRequest(targets=(str(tmp_path / "c.yaml"),)))
    assert (job.name, job.seed, job.scenario.name) == ("a_case", 11, "cross")
    expected = case_of(record_of()).job(System())
    assert dict(job.overrides) == dict(expected.overrides)
    (entry,) = corpus_suite([record_of()]).scenarios
    assert entry.digest == record_of().digest


def changed(tmp_path, old, new):
    path = tmp_path / "c.yaml"
    path.write_text(case_text(record_of()).replace(old, new))
    return path


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("format: 1", "format: 2", "c.yaml:1:1: is a corpus file of format 2; this version reads"),
        ("event: swap", "event: swop", "event: must be one of"),
        ("event: swap", "event: swop", "did you mean swap?"),
        ("status: open", "status: closed", "status: must be one of open, fixed"),
        ("seed: 11", "seed: -1", "seed: must be at least 0, got -1"),
        ("seed: 11", "sead: 11", "sead: no such field; did you mean seed?"),
    ],
)
def test_faults_of_a_file_are_a_line_with_the_place(old, new, line, tmp_path):
    path = changed(tmp_path, old, new)
    with pytest.raises(FileFault) as fault:
        load_corpus_case(path)
    assert line in str(fault.value)


@pytest.mark.parametrize(("old", "new"), [("seed: 11", "seed: 12"), ("digest: ", "digest: a")])
def test_another_episode_than_the_one_that_failed_is_not_comparable(old, new, tmp_path):
    path = changed(tmp_path, old, new)
    for read in (load_case, lambda p: plan(PlanRequest(targets=(str(p),)))):
        with pytest.raises(NotComparable, match="not comparable: cross has changed since") as fault:
            read(path)
        assert fault.value.exit_code == 4


def test_a_case_without_its_event_is_told_so(tmp_path):
    path = changed(tmp_path, "event: swap\n", "")
    assert is_corpus_file(path)
    with pytest.raises(FileFault, match="event: is missing"):
        load_case(path)


def test_the_scenario_is_that_of_the_family(tmp_path):
    path = changed(tmp_path, "scenario: cross\n", "scenario: drink\n")
    with pytest.raises(BenchError, match="scenario: must be cross, as that is the scenario of"):
        load_case(path)


def test_a_long_name_keeps_its_end():
    assert numbered_label("cross", "_swap_1") == "cross_swap_1"
    assert numbered_label("x" * 60, "_swap_1") == "x" * 53 + "_swap_1"


def test_settings_stay_with_the_tracker_that_they_are_of(tmp_path):
    record = record_of()
    assert system_to_play(record, tmp_path) == SYSTEM
    assert system_to_play(record, tmp_path, tracker=SYSTEM.tracker).tracker_settings == (
        SYSTEM.tracker_settings
    )
    assert system_to_play(record, tmp_path, tracker="default") == System("default", "default")


def test_scenarios_are_no_corpus_files(tmp_path):
    write_case(tmp_path / "c.yaml", record_of())
    assert is_corpus_file(tmp_path / "c.yaml")
    (tmp_path / "s.yaml").write_text("name: x\nmotion: {kind: cross}\n")
    assert not is_corpus_file(tmp_path / "s.yaml")


def test_a_case_of_values_is_nominal_but_for_them():
    case = case_from_settings("cross", {"speed": "0.5 m/s", "frames": "20"}, 4)
    nominal = Space.of(find_family("cross")).nominal()
    assert case.values == {**nominal, "speed": 0.5, "frames": 20.0}
    with pytest.raises(BenchError, match="did you mean speed"):
        case_from_settings("cross", {"speeed": 1}, 0)


def test_what_the_corpus_has_is_refused_before_it_is_played(tmp_path, monkeypatch):
    def played(request):
        raise AssertionError("rendering takes a minute")

    monkeypatch.setattr("scenarios.stress.replay.replay", played)
    corpus = tmp_path / "corpus"
    corpus.mkdir()
    write_case(corpus / "a_case.yaml", record_of())
    write_case(tmp_path / "same.yaml", record_of())
    with pytest.raises(BenchError, match=r"same.yaml: is in the corpus already: .*a_case.yaml"):
        promote(tmp_path / "same.yaml", "new", corpus, "open")
    write_case(tmp_path / "other.yaml", record_of(seed=12))
    with pytest.raises(BenchError, match=r"a_case.yaml: exists and is another case; give a --name"):
        promote(tmp_path / "other.yaml", None, corpus, "open")
