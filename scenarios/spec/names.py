"""The shipped scenarios and suites: their names, and loading by name or by file."""

from __future__ import annotations

from collections.abc import Collection
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

from pjpdaf.errors import BenchError
from scenarios.spec.corpus_case import (
    CORPUS,
    corpus_cases,
    corpus_suite,
    is_corpus_file,
    load_corpus_case,
)
from scenarios.spec.loader import load_either_file, load_scenario_file, load_suite_file, parse
from scenarios.spec.motion.plugged import trust
from scenarios.spec.own_motion import is_own_motion, scenario_of_motion
from scenarios.spec.scenario import Scenario
from scenarios.spec.suggestion import suggestion
from scenarios.spec.suite import Suite, SuiteEntry

_SUFFIXES = (".yaml", ".yml")


class UnknownName(BenchError):
    """No shipped scenario or suite has this name. kind: "scenario", "suite", or both."""

    def __init__(self, kind: str, name: str, known: Collection[str]) -> None:
        hint = suggestion(name, known, "pjpdaf-bench scenarios list")
        super().__init__(f"no {kind} {name[:200]!r}{hint}; a file of your own ends in .yaml")


@lru_cache(maxsize=8)
def _names(folder: str) -> tuple[str, ...]:
    entries = (files("scenarios") / folder).iterdir()
    return tuple(sorted(e.name[: -len(".yaml")] for e in entries if e.name.endswith(".yaml")))


def scenario_names() -> tuple[str, ...]:
    """Names of the shipped scenarios, sorted."""
    return _names("catalog")


def suite_names() -> tuple[str, ...]:
    """Names of the shipped suites, sorted."""
    return _names("suites")


@lru_cache(maxsize=256)
def _shipped_scenario(name: str) -> Scenario:
    text = (files("scenarios") / "catalog" / f"{name}.yaml").read_text(encoding="utf-8")
    return parse(text, f"catalog/{name}.yaml", Scenario)


@lru_cache(maxsize=64)
def _shipped_suite(name: str) -> Suite:
    text = (files("scenarios") / "suites" / f"{name}.yaml").read_text(encoding="utf-8")
    return parse(text, f"suites/{name}.yaml", Suite)


def is_path(name: str) -> bool:
    """Whether a name given by the user is that of a file."""
    return name.endswith(_SUFFIXES) or "/" in name or "\\" in name


def load_scenario(name: str) -> Scenario:
    """Load a scenario by name, from a YAML file, or of a plug-in's motion. Raises BenchError."""
    if name in scenario_names():  # before all that reads disks: stress asks for each trial
        return _shipped_scenario(name)
    if is_path(name):
        return load_scenario_file(Path(name))
    if is_own_motion(name):
        return scenario_of_motion(name)
    raise UnknownName("scenario", name, scenario_names())


def load_suite(name: str) -> Suite:
    """Load a suite by name, or from a YAML file. Raises BenchError."""
    if is_path(name):
        return load_suite_file(Path(name))
    if name not in suite_names():
        raise UnknownName("suite", name, suite_names())
    return _shipped_suite(name)


def resolve(name: str) -> Scenario | Suite:
    """Load a scenario or a suite by name, or from a file of either, or of a corpus case.

    Raises BenchError.
    """
    if is_path(name):
        if is_corpus_file(name):
            return corpus_suite((load_corpus_case(name),))
        return load_either_file(Path(name))
    if name == CORPUS and (cases := corpus_cases(CORPUS)):
        return corpus_suite(cases)
    if name in scenario_names():
        return _shipped_scenario(name)
    if name in suite_names():
        return _shipped_suite(name)
    if is_own_motion(name):
        trust(name)
        return scenario_of_motion(name)
    raise UnknownName("scenario or suite", name, (*scenario_names(), *suite_names(), CORPUS))


def scenarios_of(suite: Suite) -> tuple[tuple[SuiteEntry, Scenario], ...]:
    """A suite's entries with their scenarios, in order. Raises BenchError for an unknown name."""
    return tuple((entry, load_scenario(entry.scenario)) for entry in suite.scenarios)
