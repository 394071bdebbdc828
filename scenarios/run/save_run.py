"""A played plan as a saved run: its rows, and what run.json says of how it was made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from pjpdaf.presets.flat import flat_values
from pjpdaf.presets.names import DEFAULT_PRESET
from pjpdaf.presets.override import override
from pjpdaf.presets.registry import PRESETS, find_preset
from reports.run.load import SavedRun, load
from reports.run.save import RunInfo, save, save_slim
from scenarios.execute.episodes import PlayResults
from scenarios.play.job import Job
from scenarios.play.plan import PlanRequest
from scenarios.play.settings import read_settings
from scenarios.play.suite_lock import suite_record
from scenarios.spec.names import resolve
from scenarios.spec.suite import Suite


def save_run(
    request: PlanRequest,
    jobs: Sequence[Job],
    played: PlayResults,
    folder: Path,
    *,
    preset: str = DEFAULT_PRESET,
    argv: Sequence[str] = (),
    slim: bool = False,
    force: bool = False,
) -> SavedRun:
    """Save the episodes of `jobs` in `folder` and read them back.

    preset, argv: for run.json. slim: the folder gets only what `compare` needs; the whole run is
    returned. force: a run in `folder` is replaced. Raises BenchError (`reports.run.save.save`).
    """
    info = RunInfo(
        name=folder.name,
        preset=preset,
        detector=request.detector,
        tracker=request.tracker,
        lag_frames=request.lag,
        parameters=parameters_in_force(request),
        overrides=dict(pair.split("=", 1) for pair in request.settings),
        renderer=played.renderer,
        argv=tuple(argv),
        complete=not played.interrupted,
        request={
            "targets": list(request.targets),
            "seeds": request.seeds,
            "first_seed": request.first_seed,
            "only": list(request.only),
            "settings": list(request.settings),
            "dataset": None if request.dataset is None else str(request.dataset),
            "detections": None if request.detections is None else str(request.detections),
        },
        suites=suite_records(request.targets),
        entries={job.name: scenario_record(job) for job in jobs},
    )
    if not slim:
        return load(save(folder, played.rows, info, force=force))
    with TemporaryDirectory() as temporary:
        whole = load(save(Path(temporary) / folder.name, played.rows, info))
        save_slim(whole, folder, force=force)
    return replace(whole, folder=folder)


def parameters_in_force(request: PlanRequest) -> dict[str, object]:
    """All parameters of a preset's detector and tracker; of a plug-in only its name is known."""
    settings = read_settings(request.settings)
    parameters: dict[str, object] = {}
    if request.detector in PRESETS:
        changed = override(find_preset(request.detector), settings.detector)
        parameters["detector"] = flat_values(changed.detector)
    if request.tracker in PRESETS:
        changed = override(find_preset(request.tracker), settings.tracker)
        parameters["tracker"] = flat_values(changed.tracker)
    return parameters


def suite_records(targets: Sequence[str]) -> list[dict[str, object]]:
    """Name, version and digest of each suite among the targets."""
    stamps = [suite_record(suite) for t in targets if isinstance(suite := resolve(t), Suite)]
    return [{key: whole[key] for key in ("name", "version", "digest")} for whole in stamps]


def scenario_record(job: Job) -> dict[str, object]:
    """Scenario, version, family and changed values of an episode, for run.json."""
    scenario = job.scenario
    return {
        "scenario": scenario.name,
        "version": scenario.version,
        "family": scenario.stream,
        "overrides": {
            k: v if isinstance(v, int | float) else str(v) for k, v in job.overrides.items()
        },
    }
