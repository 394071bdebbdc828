"""The verbs on a single case: replay it, film it, put it into the corpus."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from pjpdaf.errors import BenchError, PlugInFault
from pjpdaf.follow import FollowedFrame
from pjpdaf.plugins.loading import allow_plug_ins_from_here
from pjpdaf.presets.registry import PRESETS
from pjpdaf.targets import TARGETS
from reports.pictures.film import FilmWriter, film_suffix
from reports.pictures.overlay import overlay_picture
from reports.summary.text import count
from reports.words import MEASURE_WORDS, event_text
from scenarios.console.interrupts import unwritten_if_interrupted
from scenarios.console.lines import print_line
from scenarios.execute.isolated import try_plug_ins
from scenarios.play.fast import play_fast
from scenarios.play.footage import open_footage
from scenarios.play.job import System
from scenarios.play.settings import read_settings
from scenarios.spec.corpus_case import (
    CorpusCase,
    corpus_folder,
    is_corpus_file,
    load_corpus_case,
)
from scenarios.spec.motion.plugged import trust
from scenarios.stress.case import Case, Fidelity, Trial, TrialResult
from scenarios.stress.case_file import case_of, corpus_case, load_case, system_of, write_case
from scenarios.stress.families import find_family, is_own
from scenarios.stress.play_trial import full_result, result_of
from scenarios.stress.space import Space
from sim.contact.contact import Unposable
from sim.files import written_whole_file
from sim.motion.stage import Value
from sim.truth import Truth


@dataclass(frozen=True)
class ReplayRequest:
    """Which case to replay: a case file, or a family with values (the others are nominal).

    tracker, detector: None: those of the file, of a family the preset `default`.
    """

    target: str
    settings: tuple[str, ...] = ()
    seed: int | None = None
    detector: str | None = None
    tracker: str | None = None
    fidelity: Fidelity = "full"
    film: Path | None = None


@dataclass(frozen=True)
class Replayed:
    """A case that was played again; expected: the measure that a file says fails, "" without."""

    case: Case
    system: System
    fidelity: Fidelity
    result: TrialResult
    expected: str = ""


def replay_verb(request: ReplayRequest) -> None:
    """Play a case again and print what happens. Raises BenchError."""
    out = Console()
    replayed = replay(request)
    result = replayed.result
    assert result.robustness is not None
    print_line(
        f"{replayed.case.family} seed {replayed.case.seed}, {replayed.fidelity}, tracker "
        f"{replayed.system.tracker}: {count(result.frames, 'frame')} at {result.fps:g} a second",
        out,
    )
    for measure, rho in result.robustness.measures.items():
        mark = "  fails" if rho < 0 else ""
        print_line(f"  {MEASURE_WORDS[measure]:<28} rho {rho:+.3f}{mark}", out)
    for event in result.events:
        stage = result.blame.get((event.kind, event.target, event.first))
        fault = f", blame: {stage}" if stage else ""
        names = {"target": TARGETS[event.target], "other": TARGETS[event.other]}
        words = event_text({"kind": event.kind, **names})
        print_line(f"  {words}: frames {event.first} to {event.last}{fault}", out)
    if replayed.expected:
        rho = result.robustness.measures[replayed.expected]
        outcome = "fails as the file says" if rho < 0 else "does not fail any more"
        print_line(f"{MEASURE_WORDS[replayed.expected]}: {outcome}", out)
    digest = hashlib.sha256(result.to_json()).hexdigest()
    print_line(f"result: sha256 {digest}", out)
    if request.film is not None:
        print_line(f"film: {request.film}", out)


def replay(request: ReplayRequest) -> Replayed:
    """Play a case again; writes the film. Raises BenchError where it gives no result.

    The same case, system and fidelity give the same result, byte for byte.
    """
    case, system, expected = _case_and_system(request)
    allow_plug_ins_from_here(system.detector, system.tracker)
    try_plug_ins(system.detector, system.tracker)
    if request.film is not None and request.fidelity == "fast":
        raise BenchError("--film: the fast fidelity has no pictures; leave out --fidelity fast")
    key = Trial(case, system, request.fidelity).key
    try:
        if request.fidelity == "fast":
            result = result_of(key, play_fast(case.job(system)))
        else:
            result = _rendered(case, system, key, request.film)
    except (PlugInFault, Unposable) as fault:
        raise BenchError(f"{case.family} seed {case.seed}: no result: {fault}") from None
    return Replayed(case, system, request.fidelity, result, expected)


def promote(path: Path, name: str | None, folder: Path | None, status: str) -> Path:
    """Play a case file in full and put it into a corpus; returns the new file.

    name: None: the file's. Raises BenchError where it does not fail (or, for `fixed`, where it
    does), and where the corpus has the same concrete scenario for the same tracker already.
    """
    record = load_case(path)
    case, system = case_of(record), system_of(record)
    if is_own(record.family):
        raise BenchError(
            f"{path}: is of {record.family}; the corpus keeps cases of shipped scenarios"
        )
    folder = folder or corpus_folder()
    _check_new(record, path, folder, name or record.name)
    replayed = replay(ReplayRequest(str(path)))
    assert replayed.result.robustness is not None
    measures = replayed.result.robustness.measures
    fails = measures[record.event] < 0
    if fails == (status == "fixed"):
        outcome = "fails" if fails else "does not fail"
        raise BenchError(
            f"{path}: {MEASURE_WORDS[record.event]} {outcome} with {record.tracker} when rendered "
            f"(rho {measures[record.event]:+.2f}): not put into the corpus as {status}"
        )
    new = corpus_case(
        name or record.name, case, system, record.event, measures[record.event], status, record.note
    )
    target = folder / f"{new.name}.yaml"
    folder.mkdir(parents=True, exist_ok=True)
    write_case(target, new)
    return target


def _check_new(record: CorpusCase, path: Path, folder: Path, name: str) -> None:
    """Raise BenchError where a corpus has the name, or the same scenario for the same tracker."""
    for other in sorted(folder.glob("*.yaml")):
        kept = load_corpus_case(other)
        if (kept.digest, kept.tracker) == (record.digest, record.tracker) and other != path:
            raise BenchError(f"{path}: is in the corpus already: {other}")
        if other.stem == name and other != path:
            raise BenchError(f"{other}: exists and is another case; give a --name")


def case_from_settings(family_name: str, settings: Mapping[str, Value], seed: int) -> Case:
    """A case of a family: nominal, but for some values. Raises BenchError."""
    space = Space.of(find_family(family_name))
    fixed = Space.of(space.family, (), settings).fixed
    return Case(family_name, {**space.nominal(), **fixed}, seed)


def _case_and_system(request: ReplayRequest) -> tuple[Case, System, str]:
    settings = read_settings(request.settings)
    system, expected = System(), ""
    trust(request.target)
    of_file = request.target.endswith((".yaml", ".yml"))
    if of_file and (not Path(request.target).is_file() or is_corpus_file(request.target)):
        if settings.scenario:
            raise BenchError("--set: the values of a case are those of its file")
        record = load_case(Path(request.target))
        case, system, expected = case_of(record), system_of(record), record.event
        case = case if request.seed is None else case.with_seed(request.seed)
    else:
        case = case_from_settings(request.target, settings.scenario, request.seed or 0)
    # A preset's tracker brings its detector.
    tracker = request.tracker or system.tracker
    paired = request.tracker if request.tracker in PRESETS else None
    return (
        case,
        System(
            request.detector or paired or system.detector,
            tracker,
            settings.detector or system.detector_settings,
            settings.tracker or system.tracker_settings,
        ),
        expected,
    )


def _rendered(case: Case, system: System, key: str, film: Path | None) -> TrialResult:
    """Play in full, with a film of both views if there is a path for it."""
    job = case.job(system)
    with ExitStack() as stack:
        footage = stack.enter_context(open_footage(job))
        writer = None
        if film is not None:
            if film.suffix != film_suffix():
                raise BenchError(f"--film {film}: must end in {film_suffix()} here.")
            stack.enter_context(unwritten_if_interrupted(film))
            part = stack.enter_context(written_whole_file(film, "the film", replace=True))
            writer = FilmWriter(part.parent, part.stem, footage.fps)
            stack.callback(writer.close)
        cameras = footage.rig.cameras

        def draw(step: FollowedFrame, truth: Truth) -> None:
            if writer is not None:
                writer.add(
                    overlay_picture(step.frame, cameras, step.detections, step.estimates, truth)
                )

        return full_result(job, key, footage, draw)
