"""`run --from`: the sequences of a data set as the episodes of a run; nothing is rendered."""

from __future__ import annotations

from collections.abc import Collection, Container, Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from pjpdaf.detector.external import DetectionTable
from pjpdaf.errors import BenchError
from pjpdaf.plugins.registry import make_detector
from scenarios.play.job import Job, System
from scenarios.play.lag import make_lagged
from scenarios.play.recipe import read_recipe
from scenarios.spec.suggestion import suggestion
from scenarios.tables.detections import read_detections, read_min_score
from sim.dataset.reader import Dataset, open_dataset
from sim.dataset.stored_sequence import StoredSequence

ALL_SEEDS = range(2**32)


def open_with_sequences(folder: Path) -> Dataset:
    """A data set with at least one finished sequence. Raises BenchError."""
    dataset = open_dataset(folder)
    if not dataset.sequences:
        raise BenchError(f"{folder}: has no finished sequence; `dataset make` goes on with it.")
    return dataset


def job_of_sequence(sequence: StoredSequence) -> Job:
    """The episode that a sequence is of, to be read instead of rendered.

    Raises BenchError where its recipe is of another version, or another than the manifest's.
    """
    recipe = read_recipe(sequence.recipe, sequence.folder)
    job = recipe.job
    for name, value in (("label", job.name), ("seed", job.seed)):
        if sequence.entry.get(name) != value:
            raise BenchError(
                f"{sequence.folder / 'recipe.json'}: its {name} is {value!r}, in the manifest it "
                f"is {sequence.entry.get(name)!r}; one of them was edited."
            )
    return replace(job, kept=sequence.folder.absolute(), size_px=recipe.settings.size_px)


def jobs_of_dataset(
    dataset: Dataset,
    system: System,
    only: Collection[str] = (),
    seeds: Container[int] = ALL_SEEDS,
    *,
    pictures: bool,
    films: bool,
    detections: Path | None = None,
) -> list[Job]:
    """The episodes of a data set in its order; only, seeds: those that are chosen.

    pictures: keep some of the first seed of each name; films: keep all of all; detections: file or
    folder of 2-D detections in place of a detector. Raises BenchError for a recipe or detections
    that cannot be read, a name or detector or tracker that does not exist.
    """
    # Of copies: a sequence keeps the tables that it has read, and there may be thousands.
    jobs = [job_of_sequence(replace(sequence)) for sequence in dataset.sequences]
    jobs = [replace(job, system=system, keep_film=films) for job in jobs]
    if detections is not None:
        jobs = with_detections(jobs, dataset, detections, system.detector_settings)
    names = list(dict.fromkeys(job.name for job in jobs))
    for name in only:
        if name not in names:
            raise BenchError(f"--only {name}: not in it{suggestion(name, names)}")
    check_once(dataset, ((job.name, job.seed) for job in jobs))
    jobs = [job for job in jobs if job.name in only or not only]
    there = sorted({job.seed for job in jobs})
    jobs = [job for job in jobs if job.seed in seeds]
    if not jobs:
        raise BenchError(
            f"{dataset.folder}: no sequence has such a seed; it has {there[0]} to {there[-1]}; see "
            "--first-seed, --seeds"
        )
    first = {job.name: job.seed for job in sorted(jobs, key=lambda job: -job.seed)}
    # A rig may be new to a detector or tracker: each name's first is tried.
    for job in {job.name: job for job in reversed(jobs)}.values():
        assert job.kept is not None
        cameras = StoredSequence(job.kept, {}).calibration.cameras
        if detections is None:
            make_detector(system.detector, cameras, system.detector_settings)
        make_lagged(system, cameras)
    return [replace(j, keep_pictures=pictures and j.seed == first[j.name]) for j in jobs]


def with_detections(
    jobs: Iterable[Job], dataset: Dataset, path: Path, settings: Mapping[str, str]
) -> list[Job]:
    """The jobs with their detections from a file or folder; none in a sequence that is not in it.

    settings: of the detector; only min_score has a meaning. Raises BenchError.
    """
    sequences = {one.folder.name: replace(one) for one in dataset.sequences}
    tables = read_detections(
        path,
        {name: one.calibration.cameras for name, one in sequences.items()},
        {name: one.frame_count for name, one in sequences.items()},
        read_min_score(settings),
    )
    if not tables:
        raise BenchError(f"{path}: has no detections.")
    nothing = (DetectionTable.empty(), DetectionTable.empty())
    return [replace(job, detections=tables.get(job.kept.name, nothing)) for job in jobs if job.kept]


def check_once(dataset: Dataset, episodes: Iterable[tuple[str, int]]) -> None:
    """Raise BenchError unless each (name, seed) is in it once: results have them once."""
    seen = set()
    for name, seed in episodes:
        if (name, seed) in seen:
            raise BenchError(
                f"{dataset.folder}: has {name} seed {seed} twice; results have each pair once."
            )
        seen.add((name, seed))


def renderer_of(dataset: Dataset) -> str:
    """Description of the renderer of its pictures, "" where the manifest has none."""
    made_with = dataset.manifest.get("made_with")
    renderer = made_with.get("renderer") if isinstance(made_with, dict) else None
    return renderer[:300] if isinstance(renderer, str) else ""
