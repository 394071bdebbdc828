"""The digest of a suite."""

from __future__ import annotations

from scenarios.spec.names import load_scenario, load_suite
from scenarios.spec.suite import suite_digest


def test_the_digest_of_a_suite_follows_its_scenarios():
    suite = load_suite("thesis")
    scenarios = {e.scenario: load_scenario(e.scenario) for e in suite.scenarios}
    first = suite_digest(suite, scenarios)
    scenarios["drink"] = scenarios["drink"].model_copy(update={"frames": 53})
    assert suite_digest(suite, scenarios) != first
