"""The verb `run`: plan episodes, play them, save the run, print the table."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from rich.console import Console

from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.parameters import PRESETS, find_preset, override
from pjpdaf.registry import make_detector, make_tracker
from reports.page import write_page
from reports.results import RunInfo, check_free, load, save
from reports.rows import EpisodeRows
from reports.tables import count, rich_table, summarise
from scenarios.catalogue import resolve, scenarios_of
from scenarios.concrete import SETTINGS, concrete, in_si, perform, setting_of
from scenarios.execute import Played, play_all
from scenarios.filming import rig_of
from scenarios.parameters import File, nearest
from scenarios.play import Job, System
from scenarios.progress import progress_bar
from scenarios.spec import Scenario, Suite
from sim.contact import Unposable
from sim.rig import stereo_rig
from sim.stage import Value

MAX_SEEDS = 100_000
SCENARIO_SEEDS = 10  # of a scenario that is named alone


@dataclass(frozen=True)
class RunRequest:
    """What the command line asked for; None = the default."""

    targets: tuple[str, ...]
    seeds: int | None
    preset: str
    detector: str
    tracker: str
    settings: tuple[str, ...]
    jobs: int | None
    out: Path | None
    argv: tuple[str, ...]
    films: bool = False


@dataclass(frozen=True)
class Settings:
    """KEY=VALUE pairs by what they change."""

    scenario: dict[str, str]
    detector: dict[str, str]
    tracker: dict[str, str]


def worker_count(asked: int | None) -> int:
    """How many workers to start. Raises BenchError outside 1 .. max(32, 4 a core)."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    cores = cores or 1
    most = max(32, 4 * cores)
    if asked is None:
        return cores
    if not 1 <= asked <= most:
        raise BenchError(
            f"--jobs must be between 1 and {most}, got {asked}; this machine has {cores} cores"
        )
    return asked


def read_settings(pairs: Sequence[str]) -> Settings:
    """`--set` arguments by their prefix. Raises BenchError for one without '=' or given twice."""
    settings = Settings({}, {}, {})
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not equals or not key:
            raise BenchError(f"--set {pair}: must be KEY=VALUE, e.g. noise_sd=5 or tracker.gate=4")
        part, dot, name = key.partition(".")
        home = {"detector": settings.detector, "tracker": settings.tracker}.get(part if dot else "")
        home, name = (settings.scenario, key) if home is None else (home, name)
        if name in home:
            raise BenchError(f"--set {key}: given twice")
        home[name] = value
    return settings


def find_plug_ins_here(*parts: str) -> None:
    """Let a module:factory lie in the current folder; last, so that it hides no library."""
    here = str(Path.cwd())
    if any(":" in part for part in parts) and here not in sys.path:
        sys.path.append(here)


@dataclass(frozen=True)
class Part:
    """One scenario of a run: what a suite changes of it, and how many seeds it plays."""

    scenario: Scenario
    overrides: Mapping[str, Value]
    seeds: int
    label: str

    @property
    def takes(self) -> frozenset[str]:
        """What `--set` can change."""
        return frozenset((*self.scenario.parameters, *SETTINGS))


def _parts(name: str) -> list[Part]:
    found = resolve(name)
    if not isinstance(found, Suite):
        return _at_rates(Part(found, {}, SCENARIO_SEEDS, found.name))
    return [
        part
        for entry, scenario in scenarios_of(found)
        for part in _at_rates(
            Part(
                scenario,
                entry.overrides | ({} if entry.frames is None else {"frames": entry.frames}),
                entry.seeds or found.seeds,
                entry.label or scenario.name,
            )
        )
    ]


def _at_rates(part: Part) -> list[Part]:
    """The same time at each of the scenario's frame rates; the part itself where it has none."""
    scenario = part.scenario
    if not scenario.rates or "fps" in part.overrides:
        return [part]
    duration_s = float(part.overrides.get("frames", scenario.frames)) / scenario.fps
    return [
        replace(
            part,
            overrides={**part.overrides, "fps": rate, "frames": max(1, round(duration_s * rate))},
            label=f"{part.label}@{rate:g}",
        )
        for rate in scenario.rates
    ]


def plan(request: RunRequest) -> list[Job]:
    """All episodes of a run, in their order; everything that can be wrong is found here.

    Raises BenchError for an unknown scenario, key or part, a value out of range, a scenario twice.
    """
    if request.seeds is not None and not 1 <= request.seeds <= MAX_SEEDS:
        raise BenchError(f"--seeds must be between 1 and {MAX_SEEDS}, got {request.seeds}")
    settings = read_settings(request.settings)
    parts = [part for name in request.targets for part in _parts(name)]
    names = [part.label for part in parts]
    for name in names:
        if names.count(name) > 1:
            raise BenchError(
                f"{name}: asked for twice; a run plays a scenario once (or under another label)"
            )
    known = {key for part in parts for key in part.takes}
    for key in settings.scenario:
        if key not in known:
            hint = nearest(key, known)
            raise BenchError(f"--set {key}: no such parameter in these scenarios{hint}")
    system = System(request.detector, request.tracker, settings.detector, settings.tracker)
    jobs = []
    for part in parts:
        asked = {key: value for key, value in settings.scenario.items() if key in part.takes}
        overrides = {**part.overrides, **asked}
        seeds = request.seeds if request.seeds is not None else part.seeds
        jobs += [
            Job(part.scenario, seed, overrides, system, seed == 0, part.label, request.films)
            for seed in range(seeds)
        ]
    for job in {job.name: job for job in jobs}.values():
        check(job)
    return jobs


def check(job: Job) -> None:
    """Raise BenchError where scenario, values, detector or tracker of a job do not fit together.

    Whether the motion can be posed is left to the worker, but for one that is read from a file.
    """
    values = in_si(job.scenario, concrete(job.scenario, job.seed, job.overrides))
    cameras = stereo_rig(rig_of(values)).cameras
    make_detector(job.system.detector, cameras, job.system.detector_settings)
    make_tracker(job.system.tracker, cameras, job.system.tracker_settings)
    for setting in SETTINGS:
        setting_of(job.scenario, job.overrides, setting)
    if any(isinstance(p, File) for p in job.scenario.parameters.values()):
        with suppress(Unposable):  # of this seed alone; it becomes a failed episode
            perform(job.scenario, job.seed, job.overrides)


def parameters_of(request: RunRequest) -> dict[str, object]:
    """All parameter values in force, for run.json; of a plug-in only its name is known."""
    settings = read_settings(request.settings)
    parameters: dict[str, object] = {}
    if request.detector in PRESETS:
        changed = override(find_preset(request.detector), settings.detector)
        parameters["detector"] = asdict(changed.detector)
    if request.tracker in PRESETS:
        changed = override(find_preset(request.tracker), settings.tracker)
        parameters["tracker"] = asdict(changed.tracker)
    return parameters


def default_folder(targets: Sequence[str]) -> Path:
    """runs/NAME-DATE-TIME, a number behind it where two runs start in the same second."""
    name = "+".join(Path(target).stem for target in targets)[:60]
    base = Path("runs") / f"{name}-{time.strftime('%Y%m%d-%H%M%S')}"
    folder, number = base, 2
    while folder.exists():
        folder = base.with_name(f"{base.name}-{number}")
        number += 1
    return folder


def run_suite(request: RunRequest) -> None:
    """Play, score, save and print. Raises BenchError; SystemExit(130) after Ctrl-C."""
    workers = worker_count(request.jobs)
    find_plug_ins_here(request.detector, request.tracker)
    jobs = plan(request)
    folder = request.out or default_folder(request.targets)
    check_free(folder)
    # A cancelled CI job gets SIGTERM: what is finished is kept then, too.
    signal.signal(signal.SIGTERM, _interrupt)
    console = Console(stderr=True)
    started = time.perf_counter()
    played = _play_with_progress(jobs, workers, console)
    if not played.rows:
        raise Interrupted("interrupted before any episode was finished; nothing saved")
    wall_s = time.perf_counter() - started
    info = RunInfo(
        name=folder.name,
        preset=request.preset,
        detector=request.detector,
        tracker=request.tracker,
        parameters=parameters_of(request),
        overrides=dict(pair.split("=", 1) for pair in request.settings),
        renderer=played.renderer,
        argv=request.argv,
        complete=not played.interrupted,
    )
    save(folder, played.rows, info)
    saved = load(folder)
    page = write_page([saved], folder / "report.html")
    out = Console()
    out.print(rich_table(summarise(saved)))
    frames = sum(row.frame_count for row in played.rows)
    out.print(
        f"{count(len(played.rows), 'episode')}, {count(frames, 'stereo frame')} in {wall_s:.0f} s "
        f"({frames / wall_s:.1f} a second, {workers} workers)",
        highlight=False,
    )
    out.print(f"report: {page}", highlight=False, soft_wrap=True)
    _end(played, jobs)


def _interrupt(number: int, frame: object) -> None:
    raise KeyboardInterrupt


def _end(played: Played, jobs: Sequence[Job]) -> None:
    failed = [row for row in played.rows if row.failure]
    if played.interrupted:
        raise Interrupted(
            f"interrupted: {len(played.rows)} of {len(jobs)} episodes are in the saved run"
        )
    if failed:
        first = failed[0]
        raise InfrastructureError(
            f"{len(failed)} of {len(jobs)} episodes gave no result, the first: "
            f"{first.scenario} seed {first.seed}: {first.failure}"
        )


class Interrupted(BenchError):
    """Ctrl-C; what was finished is saved."""

    exit_code = 130


def _play_with_progress(jobs: Sequence[Job], workers: int, console: Console) -> Played:
    with progress_bar(console) as progress:
        task = progress.add_task("starting", total=len(jobs))

        def on_done(row: EpisodeRows) -> None:
            label = f"{row.scenario} seed {row.seed}"
            progress.update(task, advance=1, description=label)

        return play_all(jobs, workers, on_done)


def remake_report(run_folders: Sequence[Path], out: Path | None) -> Path:
    """The page of saved runs again, several side by side. Raises BenchError."""
    if out is None and len(run_folders) > 1:
        raise BenchError("a page of several runs is in none of them: give --out FILE.html")
    saved = [load(folder) for folder in run_folders]
    return write_page(saved, out or run_folders[0] / "report.html")
