"""Cases as files: what a search writes, `replay` plays, `promote` takes, and the corpus keeps."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from pjpdaf.errors import BenchError, NotComparable
from pjpdaf.presets.registry import PRESETS
from scenarios.play.job import System
from scenarios.play.settings import read_settings
from scenarios.spec.corpus_case import FORMAT, CorpusCase, load_corpus_case
from scenarios.spec.motion.plugged import is_code
from scenarios.spec.names import is_path
from scenarios.spec.parameters.file import FileText
from scenarios.stress.case import Case
from scenarios.stress.families import find_family
from sim.files import written_whole_file


def can_be_file(case: Case) -> bool:
    """Whether a case can be written as a case file: not with a file of the user's in it."""
    return not any(isinstance(value, FileText) for value in case.values.values())


def corpus_case(
    name: str, case: Case, system: System, measure: str, rho: float, status: str, note: str = ""
) -> CorpusCase:
    """The record of a case. Raises BenchError where a file of the user's is among its values."""
    job = case.job(system)
    for key, value in job.overrides.items():
        if isinstance(value, FileText):
            raise BenchError(f"{key}: a case with a file of yours cannot be written as a case file")
    return CorpusCase.model_validate(
        {
            "format": FORMAT,
            "name": name,
            "family": case.family,
            "scenario": find_family(case.family).scenario_name,
            "version": job.scenario.version,
            "digest": case.digest,
            "seed": case.seed,
            "values": dict(job.overrides),
            "event": measure,
            "rho": round(rho, 3),
            "status": status,
            "detector": system.detector,
            "tracker": system.tracker,
            "settings": settings_of(system),
            "note": note,
        }
    )


def case_of(record: CorpusCase) -> Case:
    """The concrete scenario of a record. Raises BenchError for a family that does not exist."""
    find_family(record.family)
    return Case(record.family, dict(record.values), record.seed)


def system_of(record: CorpusCase) -> System:
    """The system that failed."""
    settings = read_settings(record.settings)
    return System(record.detector, record.tracker, settings.detector, settings.tracker)


def system_to_play(
    record: CorpusCase, path: Path, detector: str | None = None, tracker: str | None = None
) -> System:
    """The system to play a case with: that of its file, but for what the user names.

    A preset's tracker brings its detector; settings stay with what the file names. A file names no
    code that is run: a plug-in must be named by the user as well. Raises BenchError.
    """
    filed = system_of(record)
    named = {"tracker": tracker, "detector": detector or (tracker if tracker in PRESETS else None)}
    for kind, name in (("tracker", filed.tracker), ("detector", filed.detector)):
        if named[kind] is None and is_code(name):
            raise BenchError(
                f"{path}: names the {kind} {name}; give --{kind} {name} too, as it is code, and a "
                "file alone starts none"
            )
    chosen = System(named["detector"] or filed.detector, named["tracker"] or filed.tracker)
    return dataclasses.replace(
        chosen,
        detector_settings=filed.detector_settings if chosen.detector == filed.detector else {},
        tracker_settings=filed.tracker_settings if chosen.tracker == filed.tracker else {},
    )


def settings_of(system: System) -> tuple[str, ...]:
    """The changed parameters of a system as arguments of `--set`."""
    settings = [f"detector.{k}={v}" for k, v in system.detector_settings.items()]
    return (*settings, *(f"tracker.{k}={v}" for k, v in system.tracker_settings.items()))


def load_case(path: Path) -> CorpusCase:
    """The record of a file, proved to be the episode that it was.

    Raises FileFault, NotComparable where its scenario has changed since, and BenchError for a
    family in its place.
    """
    if not is_path(str(path)) and not path.exists():
        raise BenchError(f"{path}: is not a case file, such as `stress {path} search` writes")
    record = load_corpus_case(path)
    scenario = find_family(record.family).scenario_name
    if record.scenario != scenario:
        raise BenchError(
            f"{path}: scenario: must be {scenario}, as that is the scenario of the family "
            f"{record.family}, got {record.scenario[:60]}"
        )
    case = case_of(record)
    if case.digest != record.digest:
        now = find_family(record.family).scenario.version
        raise NotComparable(
            f"{path}: not comparable: {record.scenario} has changed since, or the file was edited "
            f"(version {record.version} then, {now} now); search again"
        )
    return record


def write_case(path: Path, record: CorpusCase, *, replace: bool = False) -> None:
    """Write a case file. Raises BenchError where it cannot be written, or exists."""
    with written_whole_file(path, "the case", replace=replace) as part:
        part.write_text(case_text(record), encoding="utf-8")


def case_text(record: CorpusCase) -> str:
    """A record as YAML, a line a field; the same text for the same record."""
    lines = []
    for name, value in record.model_dump(exclude={"note", "values", "settings"}).items():
        lines.append(f"{name}: {_scalar(value)}")
    if record.settings:
        lines += ["settings:", *(f"- {_scalar(text)}" for text in record.settings)]
    if record.note:
        lines.append(f"note: {_scalar(record.note)}")
    lines += ["values:", *(f"  {n}: {_scalar(v)}" for n, v in record.values.items())]
    return "\n".join(lines) + "\n"


def _scalar(value: object) -> str:
    if isinstance(value, str):
        plain = value.replace("_", "").isalnum() and value[0].isalpha()
        return value if plain else '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return repr(value)
