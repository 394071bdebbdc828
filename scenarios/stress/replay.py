"""The verbs on a single case: replay it, film it, put it into the corpus."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from pjpdaf.errors import BenchError, InfrastructureError, PlugInFault
from pjpdaf.follow import FollowedFrame
from pjpdaf.plugins.loading import allow_plug_ins_from_here, describe_exception
from pjpdaf.presets.registry import PRESETS
from pjpdaf.targets import TARGETS
from reports.pictures.film import FilmWriter, film_suffix
from reports.pictures.overlay import overlay_picture
from reports.summary.text import count
from reports.words import MEASURE_WORDS, event_text
from scenarios.console.interrupts import unwritten_if_interrupted
from scenarios.console.lines import print_line
from scenarios.console.progress import progress
from scenarios.execute.isolated import try_plug_ins
from scenarios.execute.local import check_time_limit, local_executor
from scenarios.play.fast import play_fast
from scenarios.play.footage import open_footage
from scenarios.play.job import System
from scenarios.play.settings import read_settings
from scenarios.spec.corpus_case import (
    LABEL,
    MOST_LABEL,
    CorpusCase,
    corpus_folder,
    is_corpus_file,
    load_corpus_case,
)
from scenarios.spec.motion.plugged import trust
from scenarios.stress.case import Case, Fidelity, Trial, TrialResult
from scenarios.stress.case_file import case_of, corpus_case, load_case, system_to_play, write_case
from scenarios.stress.families import find_family, is_own
from scenarios.stress.play_trial import full_result, result_of
from scenarios.stress.space import Space
from scenarios.stress.trials import TIME_LIMIT_S
from sim.contact.contact import Unposable
from sim.files import disk_faults, written_whole_file
from sim.motion.stage import Value
from sim.processes import Answer
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
    time_limit_s: float = TIME_LIMIT_S


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
    """Play a case again in a process of its own; writes the film.

    The same case, system and fidelity give the same result, byte for byte. Raises BenchError, and
    InfrastructureError where a plug-in gives no result.
    """
    check_time_limit(request.time_limit_s)
    case, system, expected = _case_and_system(request)
    allow_plug_ins_from_here(system.detector, system.tracker)
    try_plug_ins(system.detector, system.tracker)
    if request.film is not None and request.fidelity == "fast":
        raise BenchError("--film: the fast fidelity has no pictures; leave out --fidelity fast")
    trial = Trial(case, system, request.fidelity)
    if request.film is None:
        result = _isolated(trial, None, request.time_limit_s)
    else:
        if request.film.suffix != film_suffix():
            raise BenchError(f"--film {request.film}: must end in {film_suffix()} here.")
        with (
            unwritten_if_interrupted(request.film),
            written_whole_file(request.film, "the film", replace=True) as part,
        ):
            result = _isolated(trial, part, request.time_limit_s)
    return Replayed(case, system, request.fidelity, result, expected)


def _isolated(trial: Trial, film: Path | None, limit_s: float) -> TrialResult:
    """Play a trial in a process of its own. Raises as `replay`."""
    with local_executor(1) as executor, progress(running=executor.running_steps) as meter:
        meter.begin("replay", trial.case.frames)
        outcomes = executor.outcomes(_played, {0: (trial, film)}, limit_s, attempts=1)
        outcome = next(indexed for indexed in outcomes if indexed is not None)[1]
    without = f"{trial.case.family} seed {trial.case.seed}: no result"
    if isinstance(outcome, Answer):
        if isinstance(outcome.value, TrialResult):
            return outcome.value
        raise InfrastructureError(f"{without}: {outcome.value}")
    if outcome.late:
        raise InfrastructureError(f"{without}: not finished within {limit_s:g} s (--time-limit)")
    raise InfrastructureError(f"{without}: {outcome.death}")


def _played(task: tuple[Trial, Path | None]) -> TrialResult | str:
    """In a worker: the result, or the fault of a plug-in. Raises BenchError."""
    trial, film = task
    try:
        if trial.fidelity == "fast":
            return result_of(trial.key, play_fast(trial.case.job(trial.system)))
        return _rendered(trial, film)
    except PlugInFault as fault:
        return str(fault)
    except KeyboardInterrupt as fault:  # of a plug-in: the terminal's does not reach a worker
        return describe_exception(fault)
    except Unposable as fault:
        case = trial.case
        raise BenchError(f"{case.family} seed {case.seed}: no result: {fault}") from None


def promote(
    path: Path,
    name: str | None,
    folder: Path | None,
    status: str,
    detector: str | None = None,
    tracker: str | None = None,
) -> Path:
    """Play a case file in full and put it into a corpus; returns the new file.

    name: None: the file's; detector, tracker: None: those of the file, which must name a plug-in of
    its here too. Raises BenchError where it does not fail (or, for `fixed`, where it
    does), and where the corpus has the same concrete scenario for the same tracker already.
    """
    record = load_case(path)
    case, system = case_of(record), system_to_play(record, path, detector, tracker)
    if is_own(record.family):
        raise BenchError(
            f"{path}: is of {record.family}; the corpus keeps cases of shipped scenarios"
        )
    folder = folder or corpus_folder()
    if name is not None and (len(name) > MOST_LABEL or re.fullmatch(LABEL, name) is None):
        raise BenchError(
            f"--name {name[:60]}: must be lower-case letters, digits and _, beginning with a "
            "letter, at most 60"
        )
    if folder.exists() and not folder.is_dir():
        raise BenchError(f"{folder}: is a file; a corpus is a folder")
    _check_new(record, path, folder, name or record.name, system.tracker)
    replayed = replay(ReplayRequest(str(path), (), None, detector, tracker))
    assert replayed.result.robustness is not None
    measures = replayed.result.robustness.measures
    fails = measures[record.event] < 0
    if fails == (status == "fixed"):
        outcome = "fails" if fails else "does not fail"
        raise BenchError(
            f"{path}: {MEASURE_WORDS[record.event]} {outcome} with {system.tracker} when rendered "
            f"(rho {measures[record.event]:+.2f}): not put into the corpus as {status}"
        )
    new = corpus_case(
        name or record.name, case, system, record.event, measures[record.event], status, record.note
    )
    target = folder / f"{new.name}.yaml"
    with disk_faults(folder, "the case"):
        folder.mkdir(parents=True, exist_ok=True)
    write_case(target, new)
    return target


def _check_new(record: CorpusCase, path: Path, folder: Path, name: str, tracker: str) -> None:
    """Raise BenchError where a corpus has the name, or the same scenario for the same tracker."""
    for other in sorted(folder.glob("*.yaml")):
        kept = load_corpus_case(other)
        if (kept.digest, kept.tracker) == (record.digest, tracker) and other != path:
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
        case, expected = case_of(record), record.event
        case = case if request.seed is None else case.with_seed(request.seed)
        system = system_to_play(record, Path(request.target), request.detector, request.tracker)
    else:
        case = case_from_settings(request.target, settings.scenario, request.seed or 0)
        # A preset's tracker brings its detector.
        paired = request.tracker if request.tracker in PRESETS else None
        system = System(
            request.detector or paired or system.detector, request.tracker or system.tracker
        )
    return (
        case,
        replace(
            system,
            detector_settings=settings.detector or system.detector_settings,
            tracker_settings=settings.tracker or system.tracker_settings,
        ),
        expected,
    )


def _rendered(trial: Trial, film: Path | None) -> TrialResult:
    """Play in full, with a film of both views if there is a path for it."""
    job = trial.case.job(trial.system)
    with ExitStack() as stack:
        footage = stack.enter_context(open_footage(job))
        writer = None
        if film is not None:
            writer = FilmWriter(film.parent, film.stem, footage.fps)
            stack.callback(writer.close)
        cameras = footage.rig.cameras

        def draw(step: FollowedFrame, truth: Truth) -> None:
            if writer is not None:
                writer.add(
                    overlay_picture(step.frame, cameras, step.detections, step.estimates, truth)
                )

        return full_result(job, trial.key, footage, draw)
