"""The lock of the suites: a locked version never changes in silence."""

import copy
import json
import shutil
from pathlib import Path

import pytest

from pjpdaf.errors import BenchError
from reports.run.schema import METRICS_VERSION
from scenarios.play.suite_lock import (
    faults,
    main,
    read_lock,
    shipped_records,
    suite_record,
    updated_lock,
)
from scenarios.spec.loader import parse
from scenarios.spec.names import load_suite, suite_names
from scenarios.spec.suite import Suite

SUITES = Path(__file__).parents[3] / "scenarios" / "suites"


@pytest.fixture(scope="module")
def stamps():
    return shipped_records()


def suite_of(*entries, version=1, seeds=2):
    lines = "".join(f"  - {{{entry}}}\n" for entry in entries)
    head = f"name: mine\nversion: {version}\nsummary: Mine.\nseeds: {seeds}\nscenarios:\n"
    return parse(head + lines, "mine.yaml", Suite)


def test_the_shipped_suites_are_what_the_lock_says(stamps):
    found = faults(read_lock(), stamps)
    assert not found, "\n".join(found)
    assert set(stamps) == {f"{name}@{load_suite(name).version}" for name in suite_names()}


def test_a_stamp_names_every_entry_in_order_with_seeds_and_digest():
    found = suite_record(
        suite_of("scenario: cross", "scenario: drink, label: drink+short, frames: 9")
    )
    assert list(found["entries"]) == ["cross", "drink+short"]
    scenario, seeds, digest = found["entries"]["drink+short"].split()
    assert scenario.startswith("drink@")
    assert seeds == "x2"
    assert len(digest) == 64
    assert found["metrics_version"] == METRICS_VERSION


@pytest.mark.parametrize(
    "other",
    [
        suite_of("scenario: drink", "scenario: cross"),
        suite_of("scenario: cross", "scenario: drink, frames: 10"),
        suite_of("scenario: cross", "scenario: drink", seeds=3),
        suite_of("scenario: cross", "scenario: drink, overrides: {noise_sd: 3.0}"),
        suite_of("scenario: cross"),
    ],
    ids=["order", "frames", "seeds", "overrides", "fewer"],
)
def test_whatever_changes_what_is_played_changes_the_digest(other):
    plain = suite_record(suite_of("scenario: cross", "scenario: drink"))
    assert suite_record(suite_of("scenario: cross", "scenario: drink")) == plain
    assert suite_record(other)["digest"] != plain["digest"]


def changed(stamps, name, label, text):
    found = copy.deepcopy(stamps)
    found[name]["entries"][label] = text
    found[name]["digest"] = "0" * 64
    return found


def test_a_changed_scenario_says_which_and_what_to_do(stamps):
    name = next(iter(sorted(stamps)))
    label, entry = next(iter(stamps[name]["entries"].items()))
    scenario, seeds, _ = entry.split()
    bare, suite, version = scenario.partition("@")[0], *name.split("@")
    now = changed(stamps, name, label, f"{scenario} {seeds} {'1' * 64}")
    (line,) = faults(stamps, now)
    assert line == (
        f"{name} is locked, but has changed ({label}): raise `version` of {bare} in "
        f"scenarios/catalog/, set `version: {int(version) + 1}` in scenarios/suites/{suite}.yaml, "
        f"run `python -m scenarios.play.suite_lock` and commit scenarios/suites/lock.json"
    )
    raised = changed(stamps, name, label, f"{bare}@99 {seeds} {'1' * 64}")
    assert f"({label}): set `version: " in faults(stamps, raised)[0]


def test_a_new_version_and_new_metrics_ask_for_a_new_lock(stamps):
    name = next(iter(sorted(stamps)))
    without = {key: one for key, one in stamps.items() if key != name}
    assert faults(without, stamps) == [
        f"{name} is not locked: run `python -m scenarios.play.suite_lock` and commit "
        f"scenarios/suites/lock.json"
    ]
    old = copy.deepcopy(stamps)
    old[name] |= {"metrics_version": 0, "digest": "0" * 64}
    (line,) = faults(old, stamps)
    assert "was locked with metrics version 0, now it is" in line


def test_an_update_keeps_old_versions_and_refuses_to_change_a_locked_one(stamps):
    name = next(iter(sorted(stamps)))
    label, entry = next(iter(stamps[name]["entries"].items()))
    now = changed(stamps, name, label, f"{entry[:-64]}{'1' * 64}")
    with pytest.raises(BenchError, match="is locked, but has changed"):
        updated_lock(stamps, now)
    assert updated_lock(stamps, now, replace=True) == now
    older = {"old@1": {"digest": "x", "entries": {}}}
    assert updated_lock(older, stamps) == {**older, **stamps}


def test_the_command_writes_the_lock_and_says_what_it_refuses(tmp_path, monkeypatch, capsys):
    import scenarios.play.suite_lock as module

    shutil.copytree(SUITES, tmp_path / "suites")
    monkeypatch.setattr(module, "__file__", str(tmp_path / "play" / "suite_lock.py"))
    assert main(["--replace"]) == 0
    written = json.loads((tmp_path / "suites" / "lock.json").read_text())
    assert {name: written[name] for name in shipped_records()} == shipped_records()
    name = next(iter(sorted(written)))
    wrong = {name: {**written[name], "entries": {}}}
    monkeypatch.setattr(module, "read_lock", lambda: wrong)
    assert main([]) == 2
    assert f"{name} is locked, but has changed" in capsys.readouterr().err
