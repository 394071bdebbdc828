"""The plan of a run: from names, seeds and `--set` to the episodes to play, in their order."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from pjpdaf.errors import BenchError
from pjpdaf.plugins.registry import make_detector
from scenarios.play.from_dataset import jobs_of_dataset, open_with_sequences
from scenarios.play.job import Job, System
from scenarios.play.lag import check_lag, make_lagged
from scenarios.play.settings import Settings, read_settings
from scenarios.play.targets import PlannedScenario, expand_target, in_rooms
from scenarios.spec.cameras import rig_of
from scenarios.spec.draw import SETTINGS, concrete, in_si, perform, setting_of
from scenarios.spec.motion.script import ScriptMotion
from scenarios.spec.parameters.file import File
from scenarios.spec.suggestion import suggestion
from scenarios.spec.surroundings import NOMINAL
from sim.contact.contact import Unposable
from sim.scene.rig import stereo_rig

MAX_SEEDS = 100_000
MAX_FIRST_SEED = 2**31


@dataclass(frozen=True)
class PlanRequest:
    """Which episodes to play, and with which detector and tracker.

    targets: scenarios, suites, or YAML files of either; seeds: episodes of each scenario, None: as
    many as the suite says; only: labels of the scenarios to keep, all without; settings: `--set`
    arguments; detector, tracker: preset, entry point or module:factory; keep_pictures: of some
    frames of each scenario's first seed; keep_films: of every episode; dataset: folder of a data
    set whose sequences, those of the seeds, are read instead of rendering `targets`; detections:
    file or folder of 2-D detections of that data set, in place of a detector; use_cache: pictures
    may come from the cache; lag: frames by which estimates come later; surroundings: varied plays
    every scenario in rooms of its own.
    """

    targets: tuple[str, ...] = ()
    seeds: int | None = None
    first_seed: int = 0
    only: tuple[str, ...] = ()
    settings: tuple[str, ...] = ()
    detector: str = System.detector
    tracker: str = System.tracker
    keep_pictures: bool = False
    keep_films: bool = False
    dataset: Path | None = None
    detections: Path | None = None
    lag: int = 0
    use_cache: bool = True
    surroundings: str = NOMINAL


def plan(request: PlanRequest) -> list[Job]:
    """All episodes in their order; every fault of the request shows here, before any is played.

    Raises BenchError for an unknown scenario, key, detector or tracker, a value out of range, and
    a scenario that is named twice.
    """
    if request.seeds is not None and not 1 <= request.seeds <= MAX_SEEDS:
        raise BenchError(f"--seeds must be between 1 and {MAX_SEEDS}, got {request.seeds}")
    if not 0 <= request.first_seed <= MAX_FIRST_SEED:
        raise BenchError(
            f"--first-seed must be between 0 and {MAX_FIRST_SEED}, got {request.first_seed}"
        )
    settings = read_settings(request.settings)
    check_lag(request.lag)
    system = System(
        request.detector, request.tracker, settings.detector, settings.tracker, request.lag
    )
    if request.detections is not None and request.dataset is None:
        raise BenchError("--detections goes with --from DATASET: they are of a data set's pictures")
    if request.dataset is not None:
        return _plan_of_dataset(request, request.dataset, settings, system)
    scenarios = _selected(
        [
            in_rooms(planned, request.surroundings)
            for target in request.targets
            for planned in expand_target(target)
        ],
        request.only,
    )
    labels = [planned.label for planned in scenarios]
    for label in labels:
        if labels.count(label) > 1:
            raise BenchError(
                f"{label}: asked for twice; a run plays a scenario once (or under another label)"
            )
    known = {key for planned in scenarios for key in planned.changeable}
    for key in settings.scenario:
        if key not in known:
            listed = f"pjpdaf-bench scenarios show {scenarios[0].scenario.name}"
            hint = suggestion(key, known, listed)
            raise BenchError(f"--set {key}: no such parameter in these scenarios{hint}")
    jobs = [job for planned in scenarios for job in _jobs_of(planned, request, settings, system)]
    for job in {job.name: job for job in jobs}.values():
        check_job(job)
    return jobs


def _jobs_of(
    planned: PlannedScenario, request: PlanRequest, settings: Settings, system: System
) -> list[Job]:
    """The episodes of a scenario, a seed each."""
    changes = {key: v for key, v in settings.scenario.items() if key in planned.changeable}
    seeds = request.seeds if request.seeds is not None else planned.seeds
    first = planned.first_seed + request.first_seed
    return [
        Job(
            planned.scenario,
            seed,
            {**planned.overrides, **changes},
            system,
            keep_pictures=seed == first and request.keep_pictures,
            label=planned.label,
            keep_film=request.keep_films,
            use_cache=request.use_cache,
        )
        for seed in range(first, first + seeds)
    ]


def _plan_of_dataset(
    request: PlanRequest, folder: Path, settings: Settings, system: System
) -> list[Job]:
    """The sequences of a data set. Raises BenchError for a request that would change pictures."""
    refused = [f"--set {key}" for key in settings.scenario]
    refused += list(request.targets)
    if refused:
        raise BenchError(
            f"{refused[0]} does not go with --from: a data set's sequences are as they were made; "
            "--only NAME, --first-seed and --seeds choose among them"
        )
    seeds = 2 * MAX_FIRST_SEED if request.seeds is None else request.seeds
    return jobs_of_dataset(
        open_with_sequences(folder),
        system,
        request.only,
        range(request.first_seed, request.first_seed + seeds),
        pictures=request.keep_pictures,
        films=request.keep_films,
        detections=request.detections,
    )


def _selected(scenarios: list[PlannedScenario], only: Sequence[str]) -> list[PlannedScenario]:
    """The scenarios whose labels are in `only`; all without. Raises BenchError."""
    labels = [planned.label for planned in scenarios]
    for label in only:
        if label not in labels:
            hint = suggestion(label, labels)
            raise BenchError(f"--only {label}: not played{hint}")
    return [planned for planned in scenarios if planned.label in only or not only]


def check_job(job: Job) -> None:
    """Raise BenchError where scenario, values, detector or tracker of a job do not fit together.

    Whether the motion can be posed is left to the worker, except for a motion read from a file, and
    for a script: raises Unposable where this seed has no draw that can be played.
    """
    values = in_si(job.scenario, concrete(job.scenario, job.seed, job.overrides))
    cameras = stereo_rig(rig_of(values)).cameras
    make_detector(job.system.detector, cameras, job.system.detector_settings)
    make_lagged(job.system, cameras)
    for setting in SETTINGS:
        setting_of(job.scenario, job.overrides, setting)
    if isinstance(job.scenario.motion, ScriptMotion):
        perform(job.scenario, job.seed, job.overrides)
    if any(isinstance(p, File) for p in job.scenario.parameters.values()):
        with suppress(Unposable):  # of this seed alone; it becomes a failed episode
            perform(job.scenario, job.seed, job.overrides)
