"""The sequences of a data set, and the command that makes the same again."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from pjpdaf.errors import BenchError
from scenarios.play.job import digest_of
from scenarios.play.ladder import rungs_of
from scenarios.play.plan import PlanRequest, plan
from scenarios.play.recipe import Recipe, SequenceSettings
from scenarios.spec.draw import setting_of
from scenarios.spec.names import scenario_names, suite_names
from scenarios.spec.surroundings import NOMINAL, VARIED
from sim.dataset.files.layout import (
    sequence_name,
)
from sim.dataset.files.manifest import SequenceEntry


@dataclass(frozen=True)
class MakeRequest:
    """The options of `dataset make`; None = the default. cluster: as of `place_of`."""

    targets: tuple[str, ...]
    out: Path
    seeds: int | None = None
    first_seed: int = 0
    settings: tuple[str, ...] = ()
    labels: SequenceSettings = field(default_factory=SequenceSettings)
    exports: tuple[str, ...] = ()
    ladder: bool = False
    varied: bool = False
    jobs: int | None = None
    cluster: str | None = None


def plan_recipes(request: MakeRequest) -> list[Recipe]:
    """The recipes of all sequences, in their order. Raises BenchError for any fault of theirs."""
    for pair in request.settings:
        role = pair.partition("=")[0].partition(".")[0]
        if role in ("tracker", "detector"):
            raise BenchError(f"--set {pair}: a data set has no {role}; it is for `run`")
    if request.varied and request.ladder:
        raise BenchError(
            "--ladder films each sequence five times in one room, --varied none twice: leave out "
            "one of them"
        )
    episodes = PlanRequest(
        request.targets,
        request.seeds,
        request.first_seed,
        settings=request.settings,
        surroundings=VARIED if request.varied else NOMINAL,
    )
    recipes = []
    for job in plan(episodes):
        if not request.ladder:
            recipes.append(Recipe(job, request.labels))
            continue
        for rung, rung_job in rungs_of(job).items():
            recipes.append(Recipe(rung_job, request.labels, rung))
    return recipes


def repeat_command(request: MakeRequest) -> tuple[str, ...]:
    """The command that makes the same data set anywhere: without folders and --jobs."""
    words = ["dataset", "make"]
    words += [
        name if name in (*scenario_names(), *suite_names()) else Path(name).name
        for name in request.targets
    ]
    if request.seeds is not None:
        words += ["--seeds", str(request.seeds)]
    if request.first_seed:
        words += ["--first-seed", str(request.first_seed)]
    if request.labels.size_px:
        words += ["--size", "x".join(map(str, request.labels.size_px))]
    words += ["--labels", ",".join(request.labels.labels) or "none"]
    words += ["--ladder"] * request.ladder + ["--varied"] * request.varied
    for pair in request.settings:
        key, _, value = pair.partition("=")
        words += ["--set", f"{key}={Path(value).name}"]  # a value may be a file
    return (*words, "--out", "DIR")


def sequence_entry(index: int, recipe: Recipe) -> SequenceEntry:
    """The entry of a sequence in the manifest."""
    job = recipe.job
    return SequenceEntry(
        folder=sequence_name(index),
        scenario=job.scenario.name,
        label=job.name,
        group=job.scenario.group,
        seed=job.seed,
        rung=recipe.rung,
        digest=digest_of(job),
        frames=job.frames,
        fps=setting_of(job.scenario, job.overrides, "fps"),
    )
