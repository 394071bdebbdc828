"""The verb `run`: plan episodes, play them, save the run, print the table."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.console import Console

from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.plugins.registry import make_detector, make_tracker
from pjpdaf.presets.parameters import PRESETS, find_preset, override
from reports.page.page import write_page
from reports.run.load import SavedRun, load
from reports.run.rows import EpisodeRows
from reports.run.save import RunInfo, check_free, save, save_slim
from reports.summary.tables import rich_table, summarise
from reports.summary.text import count
from scenarios.console.interrupts import Interrupted, Interrupts, interrupts
from scenarios.console.progress import progress_bar
from scenarios.execute.episodes import EPISODE_TIME_LIMIT_S, Played, play_all
from scenarios.execute.isolated import try_plug_ins
from scenarios.play.from_dataset import jobs_of, open_with_sequences, renderer_of
from scenarios.play.play import Job, System
from scenarios.play.suite_lock import stamp
from scenarios.play.targets import Part, parts_of
from scenarios.spec.cameras import rig_of
from scenarios.spec.draw import SETTINGS, concrete, in_si, perform, setting_of
from scenarios.spec.names import resolve
from scenarios.spec.parameters import File, nearest
from scenarios.spec.scenario import Suite
from sim.contact.contact import Unposable
from sim.scene.rig import stereo_rig

MAX_SEEDS = 100_000
MAX_FIRST_SEED = 2**31
MAX_TIME_LIMIT_S = 86_400.0


@dataclass(frozen=True)
class RunRequest:
    """What the command line asked for; None = the default.

    dataset: its sequences are read instead of rendering targets.
    """

    targets: tuple[str, ...]
    seeds: int | None
    preset: str
    detector: str
    tracker: str
    settings: tuple[str, ...]
    jobs: int | None
    out: Path | None
    argv: tuple[str, ...]
    first_seed: int = 0
    only: tuple[str, ...] = ()
    slim: bool = False
    films: bool = False
    time_limit_s: float = EPISODE_TIME_LIMIT_S
    dataset: Path | None = None


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


def plan(request: RunRequest) -> list[Job]:
    """All episodes of a run, in their order; everything that can be wrong is found here.

    Raises BenchError for an unknown scenario, key or part, a value out of range, a scenario twice.
    """
    if request.seeds is not None and not 1 <= request.seeds <= MAX_SEEDS:
        raise BenchError(f"--seeds must be between 1 and {MAX_SEEDS}, got {request.seeds}")
    if not 0 <= request.first_seed <= MAX_FIRST_SEED:
        raise BenchError(
            f"--first-seed must be between 0 and {MAX_FIRST_SEED}, got {request.first_seed}"
        )
    if not 0 < request.time_limit_s <= MAX_TIME_LIMIT_S:
        raise BenchError(
            f"--time-limit must be above 0 s, at most {MAX_TIME_LIMIT_S:g}, got "
            f"{request.time_limit_s:g}"
        )
    settings = read_settings(request.settings)
    system = System(request.detector, request.tracker, settings.detector, settings.tracker)
    if request.dataset is not None:
        _check_kept(request, settings)
        whole = not request.slim
        return jobs_of(
            open_with_sequences(request.dataset),
            system,
            request.only,
            pictures=whole,
            films=request.films and whole,
        )
    parts = _chosen([part for name in request.targets for part in parts_of(name)], request.only)
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
    jobs = []
    for part in parts:
        asked = {key: value for key, value in settings.scenario.items() if key in part.takes}
        overrides = {**part.overrides, **asked}
        seeds = request.seeds if request.seeds is not None else part.seeds
        jobs += [
            Job(
                part.scenario,
                seed,
                overrides,
                system,
                keep_pictures=seed == request.first_seed and not request.slim,
                label=part.label,
                keep_film=request.films and not request.slim,
            )
            for seed in range(request.first_seed, request.first_seed + seeds)
        ]
    for job in {job.name: job for job in jobs}.values():
        check(job)
    return jobs


def _check_kept(request: RunRequest, settings: Settings) -> None:
    """Raise BenchError for what changes pictures: those of a data set are as they are."""
    asked = [f"--set {key}" for key in settings.scenario]
    asked += ["--seeds"] if request.seeds is not None else []
    asked += ["--first-seed"] if request.first_seed else []
    asked += list(request.targets)
    if asked:
        raise BenchError(
            f"{asked[0]} does not go with --from: a data set's sequences are as they were made; "
            "--only NAME chooses among them"
        )


def _chosen(parts: list[Part], only: Sequence[str]) -> list[Part]:
    """Those whose name in the results was asked for; all where none was."""
    labels = [part.label for part in parts]
    for name in only:
        if name not in labels:
            hint = nearest(name, labels) or ";"
            raise BenchError(f"--only {name}: not played{hint} there are: {', '.join(labels)}")
    return [part for part in parts if part.label in only or not only]


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


def record(
    request: RunRequest,
    jobs: Sequence[Job],
    played: Played,
    folder: Path,
    *,
    force: bool = False,
) -> SavedRun:
    """Save what came of `jobs` and read it back; the whole, also where a slim run is kept of it.

    Raises BenchError (`reports.run.save.save`).
    """
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
        # With --from, other seeds cannot be played, and no name plays one again.
        request={}
        if request.dataset is not None
        else {
            "targets": list(request.targets),
            "seeds": request.seeds,
            "first_seed": request.first_seed,
            "only": list(request.only),
            "settings": list(request.settings),
        },
        suites=suites_of(request.targets),
        entries={job.name: entry_of(job) for job in jobs},
    )
    if not request.slim:
        return load(save(folder, played.rows, info, force=force))
    with TemporaryDirectory() as temporary:
        whole = load(save(Path(temporary) / folder.name, played.rows, info))
        save_slim(whole, folder, force=force)
    return replace(whole, folder=folder)


def suites_of(targets: Sequence[str]) -> list[dict[str, object]]:
    """Name, version and digest of the suites among these."""
    stamps = [stamp(suite) for t in targets if isinstance(suite := resolve(t), Suite)]
    return [{key: one[key] for key in ("name", "version", "digest")} for one in stamps]


def entry_of(job: Job) -> dict[str, object]:
    """What an episode is of, and what is changed of it: by a suite, or by --set."""
    scenario = job.scenario
    return {
        "scenario": scenario.name,
        "version": scenario.version,
        "family": scenario.family,
        "overrides": {
            k: v if isinstance(v, int | float) else str(v) for k, v in job.overrides.items()
        },
    }


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
    try_plug_ins(request.detector, request.tracker)
    jobs = plan(request)
    names = request.targets if request.dataset is None else (request.dataset.absolute().name,)
    folder = request.out or default_folder(names)
    check_free(folder)
    with interrupts() as arrived:
        _play_and_save(request, jobs, workers, folder, arrived)


def _play_and_save(
    request: RunRequest, jobs: Sequence[Job], workers: int, folder: Path, arrived: Interrupts
) -> None:
    console = Console(stderr=True)
    started = time.perf_counter()
    with arrived.raising():
        played = _play_with_progress(jobs, workers, console, request.time_limit_s)
    # From here on signals are only counted: saving goes on to its end.
    if request.dataset is not None:
        played = replace(played, renderer=renderer_of(open_with_sequences(request.dataset)))
    if not played.rows:
        raise Interrupted("interrupted before any episode was finished; nothing saved")
    wall_s = time.perf_counter() - started
    saved = record(request, jobs, played, folder)
    out = Console()
    out.print(rich_table(summarise(saved)))
    frames = sum(row.frame_count for row in played.rows)
    out.print(
        f"{count(len(played.rows), 'episode')}, {count(frames, 'stereo frame')} in {wall_s:.0f} s "
        f"({frames / wall_s:.1f} a second, {workers} workers)",
        highlight=False,
    )
    if request.slim:
        out.print(f"slim run: {folder}", highlight=False, soft_wrap=True)
    else:
        page = write_page([saved], folder / "report.html")
        out.print(f"report: {page}", highlight=False, soft_wrap=True)
    _end(played, jobs, interrupted=arrived.arrived)


def _end(played: Played, jobs: Sequence[Job], interrupted: bool) -> None:
    failed = [row for row in played.rows if row.failure]
    if interrupted:
        raise Interrupted(
            f"interrupted: {len(played.rows)} of {len(jobs)} episodes are in the saved run"
        )
    if failed:
        first = failed[0]
        raise InfrastructureError(
            f"{len(failed)} of {len(jobs)} episodes gave no result, the first: "
            f"{first.scenario} seed {first.seed}: {first.failure}"
        )


def _play_with_progress(
    jobs: Sequence[Job], workers: int, console: Console, time_limit_s: float
) -> Played:
    with progress_bar(console) as progress:
        task = progress.add_task("starting", total=len(jobs))

        def on_done(row: EpisodeRows) -> None:
            label = f"{row.scenario} seed {row.seed}"
            progress.update(task, advance=1, description=label)

        return play_all(jobs, workers, on_done, time_limit_s)


def remake_report(run_folders: Sequence[Path], out: Path | None) -> Path:
    """The page of saved runs again, several side by side. Raises BenchError."""
    if out is None and len(run_folders) > 1:
        raise BenchError("a page of several runs is in none of them: give --out FILE.html")
    saved = [load(folder) for folder in run_folders]
    for run in saved:
        if run.slim:
            raise BenchError(f"{run.folder}: is a slim run, without frames; it has no page")
    return write_page(saved, out or run_folders[0] / "report.html")
