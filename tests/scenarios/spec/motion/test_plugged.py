"""Motions of plug-ins: found by name, code only where the user trusts it, part of digests."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from pjpdaf.errors import BenchError
from scenarios.play.footage import footage_cache
from scenarios.play.job import Job, System
from scenarios.spec.draw import concrete, perform
from scenarios.spec.loader import parse
from scenarios.spec.motion.plugged import TRUSTED_VARIABLE
from scenarios.spec.names import load_scenario, resolve
from scenarios.spec.scenario import Scenario, digest
from scenarios.spec.suite import Suite
from scenarios.stress.families import find_family
from sim.families.plugged import own_motion

EXAMPLE = (Path(__file__).parents[4] / "examples" / "own_motion.py").read_text()
FILE = """\
name: mine
group: own
family: mine
summary: Mine.
frames: 36
motion: {kind: "my_knock:knock"}
parameters:
"""
SPEED = "  speed: {unit: m/s, range: [0.3, 0.4], nominal: {kind: fixed, value: 0.35}}\n"


@pytest.fixture
def plugged(tmp_path, monkeypatch):
    """A folder, current and on the path, with the example as a module and as an entry point."""
    (tmp_path / "my_knock.py").write_text(EXAMPLE)
    about = tmp_path / "my_knock-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: my-knock\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[pjpdaf_bench.families]\nknocking = my_knock:knock\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(TRUSTED_VARIABLE, "")
    yield tmp_path
    own_motion.cache_clear()
    sys.modules.pop("my_knock", None)


def test_a_file_alone_starts_no_code(plugged):
    refused = "6:10: motion.kind: my_knock:knock is code, and a file alone does not start code"
    with pytest.raises(BenchError, match=refused):
        parse(FILE + SPEED, "mine.yaml", Scenario)
    suite = "name: s\nsummary: S.\nscenarios:\n  - {scenario: 'my_knock:knock'}\n"
    named = parse(suite, "suite.yaml", Suite).scenarios[0].scenario
    with pytest.raises(BenchError, match="does not start code"):
        load_scenario(named)
    with pytest.raises(BenchError, match="does not start code"):
        find_family("my_knock:knock")
    assert "my_knock" not in sys.modules


def test_the_user_may_trust_it_by_name_or_by_a_variable(plugged, monkeypatch):
    by_name = resolve("my_knock:knock")
    assert by_name.name == "knock"
    assert os.environ[TRUSTED_VARIABLE] == "my_knock:knock"  # for worker processes
    monkeypatch.setenv(TRUSTED_VARIABLE, "other:thing, my_knock:knock")
    assert parse(FILE + SPEED, "mine.yaml", Scenario).motion.kind == "my_knock:knock"


def test_an_entry_point_is_a_kind_of_motion(plugged):
    text = FILE.replace('"my_knock:knock"', "knocking").replace("parameters:\n", "parameters: {}\n")
    scenario = parse(text, "mine.yaml", Scenario)
    assert scenario.parameters["times"].meaning == "how often it knocks"
    played = perform(resolve("knocking"), 0, {"times": 2})
    assert any("knock" in played.script.events(t / 3) for t in range(played.frames))


def test_a_file_may_give_a_declared_parameter_anew(plugged):
    resolve("my_knock:knock")
    scenario = parse(FILE + SPEED, "mine.yaml", Scenario)
    assert concrete(scenario, 3)["speed"] == 0.35
    with pytest.raises(BenchError, match="has no such parameter; did you mean speed"):
        parse(FILE + SPEED.replace("speed:", "sped:"), "mine.yaml", Scenario)


def test_its_source_is_part_of_the_digest_and_of_what_was_written(plugged):
    first = resolve("my_knock:knock")
    written = first.model_dump(mode="json")
    assert digest(Scenario.model_validate(written)) == digest(first)
    (plugged / "my_knock.py").write_text(EXAMPLE + "# changed\n")
    assert digest(resolve("my_knock:knock")) != digest(first)
    with pytest.raises(ValueError, match="my_knock:knock has changed since this was written"):
        Scenario.model_validate(written)


def test_its_pictures_never_come_from_the_cache(plugged, monkeypatch):
    monkeypatch.setenv("PJPDAF_BENCH_CACHE", str(plugged / "cache"))
    assert footage_cache(Job(resolve("my_knock:knock"), 0, {}, System())) is None
    assert footage_cache(Job(load_scenario("drink"), 0, {}, System())) is not None


def test_faults_of_names(plugged):
    for name, fault in {
        "my_knock:knok": "Did you mean 'knock'",
        "my_knok:knock": "cannot be imported: No module named 'my_knok'",
        "my_knock:EXAMPLE": "No 'EXAMPLE' in 'my_knock'",
    }.items():
        with pytest.raises(BenchError, match=fault):
            resolve(name)


def test_stress_takes_it_and_scenario_files_as_families(plugged):
    resolve("my_knock:knock")
    family = find_family("my_knock:knock")
    assert (family.name, family.target) == ("knock", "my_knock:knock")
    assert set(family.searched) == {"hand", "speed", "height", "times", "wait"}
    (plugged / "mine.yaml").write_text(FILE + SPEED)
    mine = find_family("mine.yaml")
    assert (mine.name, mine.target) == ("mine", "mine.yaml")
    assert find_family("drink").target == "drink"
