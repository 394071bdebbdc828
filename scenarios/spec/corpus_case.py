"""Corpus files: concrete scenarios in which a tracker failed, kept so that it never does again."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, Strict, field_validator

from reports.score.robustness import MEASURES
from scenarios.spec.faults import FileFault
from scenarios.spec.loader import parse, read_text
from scenarios.spec.parameters.record import Name, Number, Record, Text, Whole, fault_at
from scenarios.spec.suggestion import did_you_mean
from scenarios.spec.suite import Suite, SuiteEntry
from scenarios.spec.yaml_reader import read_yaml

FORMAT = 1  # of the files
CORPUS = "corpus"
MOST_LABEL = 60  # characters
LABEL = r"^[a-z][a-z0-9_.@+-]*$"
Label = Annotated[str, Strict(), Field(pattern=LABEL, max_length=MOST_LABEL)]


class CorpusCase(Record):
    """A concrete scenario, how a tracker failed in it, and whether that is cured.

    family, scenario: names, or the file or plug-in that they come from.
    version, digest: of the scenario, so that a scenario that has changed since is noticed; event: a
    measure of `reports.score.robustness`; rho: its value when the case was put in; status: fixed
    cases must pass with the tracker that is named, open ones may fail. settings: its changed
    parameters, as `tracker.gate=4`. note: for people.
    """

    format: Whole
    name: Label
    family: Text
    scenario: Text
    version: Annotated[Whole, Field(ge=1)]
    digest: Text
    seed: Annotated[Whole, Field(ge=0)]
    values: dict[Name, Annotated[float, Strict()] | Text]
    event: Annotated[Name, Field(json_schema_extra={"enum": list(MEASURES)})]
    rho: Number
    status: Literal["open", "fixed"]
    detector: Text
    tracker: Text
    settings: tuple[Text, ...] = ()
    note: Text = ""

    @field_validator("event")
    @classmethod
    def _known(cls, event: str) -> str:
        if event not in MEASURES:
            hint = did_you_mean(event, MEASURES)
            raise fault_at(f"must be one of {', '.join(MEASURES)}, got {event!r}{hint}")
        return event


class CorpusEntry(SuiteEntry):
    """An entry of a suite of corpus files. digest: of the concrete scenario that it must be."""

    first_seed: Annotated[Whole, Field(ge=0)] = 0
    digest: Text = ""


def numbered_label(name: str, end: str) -> str:
    """A name for a file: `name`, shortened where it is too long, and `end`."""
    return name[: MOST_LABEL - len(end)] + end


def corpus_folder() -> Path:
    """The folder of the shipped corpus files."""
    return Path(str(files("scenarios") / CORPUS))


def corpus_files(folder: Path | None = None) -> tuple[Path, ...]:
    """The corpus files of a folder, sorted; None: of the shipped one."""
    return tuple(sorted((folder or corpus_folder()).glob("*.yaml")))


def load_corpus_case(path: Path | str) -> CorpusCase:
    """The case of a file. Raises FileFault with the place of the first fault."""
    text = read_text(path)
    data, positions = read_yaml(text, str(path))
    if isinstance(data, dict) and data.get("format", FORMAT) != FORMAT:
        raise FileFault(
            str(path),
            positions[("format",)],
            f"is a corpus file of format {str(data['format'])[:20]}; this version reads format "
            f"{FORMAT}",
        )
    return parse(text, str(path), CorpusCase, Path(path).parent)


def is_corpus_file(path: Path | str) -> bool:
    """Whether a YAML file is a corpus file, though perhaps not a whole one. Raises FileFault."""
    data, _ = read_yaml(read_text(path), str(path))
    return isinstance(data, dict) and len({"event", "digest", "status"} & data.keys()) > 1


def corpus_suite(cases: Iterable[CorpusCase]) -> Suite:
    """A suite that plays each case with its seed."""
    entries = [
        CorpusEntry(
            scenario=case.scenario,
            label=case.name,
            seeds=1,
            overrides=dict(case.values),
            first_seed=case.seed,
            digest=case.digest,
        )
        for case in cases
    ]
    summary = "Scenarios in which a tracker failed; docs/stress.md."
    return Suite(name=CORPUS, summary=summary, scenarios=tuple(entries))


def corpus_cases(target: str) -> tuple[CorpusCase, ...]:
    """The cases that a target of `run` names: the whole shipped corpus, a file; else none.

    Raises FileFault for a damaged file, or one of another version.
    """
    if target == CORPUS:
        return tuple(map(load_corpus_case, corpus_files()))
    if target.endswith((".yaml", ".yml")) and is_corpus_file(target):
        return (load_corpus_case(target),)
    return ()
