"""A campaign: what every long verb of stress shares: spaces, workers, journal, progress."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rich.console import Console

from pjpdaf.errors import BenchError
from pjpdaf.plugins.loading import allow_plug_ins_from_here
from pjpdaf.plugins.registry import DETECTORS, TRACKERS, make_detector, make_tracker
from pjpdaf.plugins.scenes import cameras_in_front
from pjpdaf.presets.names import DEFAULT_PRESET
from pjpdaf.presets.registry import PRESETS
from scenarios.console.interrupts import Interrupted, interrupts
from scenarios.console.lines import print_line
from scenarios.execute.code_digest import NO_TRIAL, code_digest, plug_in_digest
from scenarios.execute.executor import ClusterFault
from scenarios.execute.isolated import try_plug_ins
from scenarios.execute.journal import Journal
from scenarios.execute.local import check_time_limit
from scenarios.execute.place import executor_at, place_of
from scenarios.execute.software import PlugIns
from scenarios.play.fast_trust import fast_trust
from scenarios.play.job import System
from scenarios.play.settings import read_settings
from scenarios.spec.corpus_case import is_corpus_file
from scenarios.spec.draw import SETTINGS
from scenarios.spec.motion.plugged import trust
from scenarios.spec.names import is_path
from scenarios.spec.own_motion import is_own_motion
from scenarios.spec.parameters.numeric import Numeric
from scenarios.spec.parameters.units import parse_quantity
from scenarios.stress.case import Fidelity
from scenarios.stress.families import FAMILIES, StressFamily, find_family
from scenarios.stress.progress import Progress, campaign_progress
from scenarios.stress.space import Space
from scenarios.stress.trials import TIME_LIMIT_S, TrialRunner
from sim.motion.stage import Value

ALL = "all"
MAX_RUNS = 10_000_000


@dataclass(frozen=True)
class CampaignRequest:
    """The options that the long verbs of stress share.

    target: families, with commas between them, or `all`; settings: `--set` arguments, of a scenario
    (it does not vary then), `tracker.` or `detector.`; also: further parameters that vary; ranges:
    `NAME=LOW..HIGH`; fidelity: None: fast where the detector lets it; options: of the verb, part of
    the campaign's identity; jobs: worker processes; cluster: as of
    `place_of`.
    """

    verb: str
    target: str
    detector: str = DEFAULT_PRESET
    tracker: str = DEFAULT_PRESET
    settings: tuple[str, ...] = ()
    also: tuple[str, ...] = ()
    ranges: tuple[str, ...] = ()
    fidelity: Fidelity | None = None
    against: str | None = None
    seed: int = 0
    jobs: int | None = None
    cluster: str | None = None
    out: Path | None = None
    time_limit_s: float = TIME_LIMIT_S
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def system(self) -> System:
        """The system under test. Raises BenchError for a setting that is no pair."""
        settings = read_settings(self.settings)
        return System(self.detector, self.tracker, settings.detector, settings.tracker)

    @property
    def plug_ins(self) -> PlugIns:
        """The code that is not ours."""
        others = () if self.against is None else (self.against,)
        named = PlugIns.named(self.detector, self.tracker, *others)
        targets = self.target.split(",")
        return named.with_motions(name for name in targets if is_own_motion(name))

    @property
    def other(self) -> System | None:
        """The system to compare with: `against` as tracker, and as detector where it is a preset
        and so is the detector under test."""
        if self.against is None:
            return None
        presets = self.against in PRESETS and self.detector in PRESETS
        return System(self.against if presets else self.detector, self.against)

    def identity(self) -> str:
        """Canonical JSON of everything that decides the results, the code's version included."""
        record = asdict(self)
        for name in ("jobs", "cluster", "out", "time_limit_s"):
            del record[name]
        return json.dumps({**record, "code": self.code()}, sort_keys=True, default=str)

    def code(self) -> str:
        """Canonical JSON of the code that decides the results of a trial.

        The identity of a journal: a trial's key names all else, so that several verbs, of several
        systems, can share one.
        """
        trackers = (self.tracker, self.against or self.tracker)
        plug_ins = {
            f"{group} {name}": plug_in_digest(name, group)
            for group, name in ((DETECTORS, self.detector), *((TRACKERS, t) for t in trackers))
        }
        record = {
            "version": version("pjpdaf-bench"),
            "code": code_digest(NO_TRIAL),
            "plug-ins": plug_ins,
        }
        return json.dumps(record, sort_keys=True)


@dataclass(frozen=True)
class Campaign:
    """An open campaign; runner: plays its trials."""

    request: CampaignRequest
    spaces: tuple[Space, ...]
    system: System
    other: System | None
    fidelity: Fidelity
    folder: Path
    runner: TrialRunner
    progress: Progress

    def fidelity_for(self, space: Space) -> Fidelity:
        """The fidelity of a family: full where fast does not predict it, unless asked for."""
        if self.request.fidelity is not None or fast_fault(self.request, space) is None:
            return self.fidelity
        return "full"


def families_of(target: str) -> tuple[StressFamily, ...]:
    """The families of a target: names with commas between them, or `all`. Raises BenchError."""
    if target == ALL:
        return tuple(FAMILIES.values())
    names = [name.strip() for name in target.split(",")]
    if ALL in names:
        raise BenchError(f"{ALL}: has every family in it; name no other beside it")
    for name in names:
        if is_path(name) and is_corpus_file(name):
            raise BenchError(
                f"{name}: is a case; this verb takes families (shrink, replay, promote take a case)"
            )
        if names.count(name) > 1:
            raise BenchError(f"{name}: named twice")
    trust(*names)
    return tuple(find_family(name) for name in names)


def spaces_of(request: CampaignRequest) -> tuple[Space, ...]:
    """The space of each family of a request. Raises BenchError where none has a parameter."""
    families = families_of(request.target)
    settings = read_settings(request.settings).scenario
    ranges = _ranges(request.ranges)
    for name in (*ranges, *request.also):
        if name in settings:
            raise BenchError(f"{name}: --set holds it, so that it cannot vary too; leave one out")
    spaces = []
    for family in families:
        many = len(families) > 1
        fixed: dict[str, Value] = {n: v for n, v in settings.items() if not many or _has(family, n)}
        mine = {n: ends for n, ends in ranges.items() if not many or _has(family, n)}
        also = [name for name in request.also if not many or _has(family, name)]
        numbers = {name: _ends(family, name, ends) for name, ends in mine.items()}
        spaces.append(Space.of(family, also, fixed, numbers))
    for name in (*settings, *ranges, *request.also):
        if not any(_has(family, name) for family in families):
            families[0].parameter(name)  # raises, with the closest name
    return tuple(spaces)


@contextmanager
def open_campaign(request: CampaignRequest, total: int | None = None) -> Iterator[Campaign]:
    """Everything that a campaign needs, until the block ends.

    total: the number of trials that are expected at most. Raises BenchError for faults of the
    request, all before anything is played, and Interrupted after a signal: the same command goes
    on then.
    """
    check_time_limit(request.time_limit_s)
    if not 0 <= request.seed < 2**31:
        raise BenchError(f"--seed must be between 0 and {2**31 - 1}, got {request.seed}")
    spaces = spaces_of(request)
    place = place_of(request.jobs, request.cluster)
    fidelity = fidelity_of(request)
    system, other = request.system, request.other
    for tested in (system, other):
        if tested is not None:
            _check(tested)
    folder = request.out or default_folder(request, request.identity())
    _say_fidelities(request, spaces, fidelity)
    frames = max(space.family.scenario.frames for space in spaces)
    with (
        interrupts() as arrived,
        Journal.open(folder, request.code()) as journal,
        executor_at(place, request.plug_ins) as executor,
        campaign_progress(executor, frames, total) as progress,
    ):
        if fidelity == "full":
            executor.renderers()  # raises where there is no OpenGL
        runner = TrialRunner(
            executor, journal, request.time_limit_s, progress.on_result, lambda: arrived.arrived
        )
        try:
            with arrived.raising():
                yield Campaign(request, spaces, system, other, fidelity, folder, runner, progress)
                if arrived.arrived:  # swallowed by a library: what it was doing may be half done
                    raise KeyboardInterrupt
        except KeyboardInterrupt:
            raise Interrupted(f"interrupted: {_kept(journal, folder)}") from None
        except ClusterFault as fault:
            raise fault.reworded(f"{fault}; {_kept(journal, folder)}") from fault


def _kept(journal: Journal, folder: Path) -> str:
    return (
        f"{len(journal.finished)} finished runs are kept in {folder}; the same command goes on "
        "from there"
    )


def fidelity_of(request: CampaignRequest) -> Fidelity:
    """The fidelity of a request. Raises BenchError for fast with a detector of the user's."""
    can_be_fast = request.detector in PRESETS
    if request.fidelity == "fast" and not can_be_fast:
        raise BenchError(
            f"--fidelity fast: knows no error model of the detector {request.detector!r}; leave it "
            "out"
        )
    return request.fidelity or ("fast" if can_be_fast else "full")


def fast_fault(request: CampaignRequest, space: Space) -> str | None:
    """Why fast does not predict what pictures show in a family; None where it does."""
    if not space.family.fast:
        return "fast does not know what varies"
    trust = fast_trust(request.detector).get(space.family.name)
    if trust is None or trust.trusted:
        return None
    agreeing = trust.episodes - trust.only_full - trust.only_fast
    return f"fast agreed with rendered pictures in {agreeing} of {trust.episodes} episodes"


def _say_fidelities(request: CampaignRequest, spaces: Sequence[Space], fidelity: Fidelity) -> None:
    """Say which families are played in full although others are fast."""
    if request.fidelity is not None or fidelity == "full":
        return
    out = Console(stderr=True)
    for space in spaces:
        if fault := fast_fault(request, space):
            print_line(
                f"{space.family.name}: played in full: {fault}; --fidelity fast plays it fast", out
            )


def default_folder(request: CampaignRequest, identity: str) -> Path:
    """runs/stress-TARGET-VERB-DIGEST: the same for the same command and code."""
    digest = hashlib.sha256(identity.encode()).hexdigest()[:8]
    target = re.sub(r"[^\w@+.-]+", "_", request.target.replace(",", "+"))[-40:]
    return Path("runs") / f"stress-{target}-{request.verb}-{digest}"


def _check(system: System) -> None:
    """Raise BenchError where the system cannot be built."""
    allow_plug_ins_from_here(system.detector, system.tracker)
    try_plug_ins(system.detector, system.tracker)
    make_detector(system.detector, cameras_in_front(), system.detector_settings)
    make_tracker(system.tracker, cameras_in_front(), system.tracker_settings)


def _has(family: StressFamily, name: str) -> bool:
    try:
        family.parameter(name)
    except BenchError:
        return name in family.scenario.parameters or name in SETTINGS
    return True


def _ranges(texts: Sequence[str]) -> dict[str, tuple[str, str]]:
    ranges: dict[str, tuple[str, str]] = {}
    for name, ends in map(_range, texts):
        if name in ranges:
            raise BenchError(f"--range {name}: given twice")
        ranges[name] = ends
    return ranges


def _range(text: str) -> tuple[str, tuple[str, str]]:
    name, equals, ends = text.partition("=")
    low, dots, high = ends.partition("..")
    if not (equals and dots and name and low and high):
        raise BenchError(f"--range {text}: must be NAME=LOW..HIGH, as speed=0.2..0.4")
    return name, (low, high)


def _ends(family: StressFamily, name: str, ends: tuple[str, str]) -> tuple[float, float]:
    parameter = family.parameter(name)
    if not isinstance(parameter, Numeric):
        listed = ", ".join(parameter.choices)
        raise BenchError(f"{name}: is one of {listed}; it has no range")
    try:
        low, high = (parse_quantity(end, parameter.unit) for end in ends)
    except ValueError as fault:
        raise BenchError(f"--range {name}: {fault}") from None
    return low, high
