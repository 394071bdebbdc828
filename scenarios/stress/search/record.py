"""search.json: all that a search found, as plain values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scenarios.stress.confirm import Counterexample
from scenarios.stress.search.search import FamilySearch

KIND, VERSION = "pjpdaf-bench stress search", 1


def family_record(search: FamilySearch, found: Sequence[Counterexample]) -> dict[str, Any]:
    """A family's part: every evaluated point with its robustness, and the failures."""
    return {
        "family": search.space.family.name,
        "parameters": list(search.space.names),
        "runs": search.runs,
        "ended": search.ended,
        "points": [
            {
                "values": dict(e.case.values),
                "seed": e.case.seed,
                "rho": None if e.result.robustness is None else e.result.robustness.measures,
                "failure": None if e.result.failure is None else e.result.failure.kind,
            }
            for e in search.evaluations
        ],
        "failures": [failure_record(one) for one in found],
    }


def failure_record(found: Counterexample) -> dict[str, Any]:
    """A distinct failure."""
    failure = found.failure
    return {
        "family": failure.signature.family,
        "event": failure.signature.measure,
        "cell": dict(failure.signature.cell),
        "drawn": dict(failure.signature.drawn),
        "found": failure.evaluation.case.to_json(),
        "minimal": failure.minimal.to_json(),
        "case": found.case.to_json(),
        "survival": [found.survival.failed, found.survival.of],
        "rendered": found.full is not None,
        "confirmed": found.confirmed,
        "rho": None if found.result.robustness is None else found.result.robustness.measures,
        "severity": found.result.severity,
        "blame": found.blame,
    }
