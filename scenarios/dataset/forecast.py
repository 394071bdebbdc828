"""The expected size and time of a data set, from a few of its frames that are made on trial."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.filesize import decimal

from pjpdaf.errors import BenchError, InfrastructureError
from scenarios.execute.executor import Executor
from scenarios.play.recipe import OWN_SIZE, Recipe
from scenarios.spec.draw import setting_of
from sim.dataset.writer import write_frames
from sim.processes import Answer
from sim.sequence import Simulation

LEAST_FRAMES = 100  # a smaller data set is there before its size is known
FRAMES_A_TRIAL = 100  # frames of a data set for each sequence that is tried
MOST_TRIALS = 8
TRIAL_LIMIT_S = 600.0


# Bytes beside pictures and labels, measured at 640x480 with all labels; they hardly matter.
FRAME_BYTES = 8_000  # rows of the tables, checksums
SEQUENCE_BYTES = 40_000  # recipe, rig, calibration
DATASET_BYTES = 160_000  # card with its pictures, Croissant record
EXPORT_FRAME_BYTES = {"coco": 8_000, "mot": 1_500, "webdataset": 19_000, "parquet": 2_000}
EXPORT_FRAME_BYTES |= {"yolo-pose": 2_000, "yolo-seg": 4_000, "middlebury": 500, "hdf5": 8_000}
PFM_BYTES = 2 * 4.05  # a pixel, of two files; the masks shrink
EXPORT_S_PER_MB = 0.02  # of copying


@dataclass(frozen=True)
class Trial:
    """A few frames of a sequence, made on trial.

    pictures: bytes of a stereo pair; labels: bytes of a frame's labels; start_s: until the first
    frame could be rendered [s]; frame_s: of a frame [s]; frame_cpu_s: of a frame, processor time of
    all threads [s].
    """

    pictures: float
    labels: float
    start_s: float
    frame_s: float
    frame_cpu_s: float


@dataclass(frozen=True)
class Forecast:
    """Expected bytes and wall time. exports: the part of `size` that is of exports.

    Of a stereo frame, on average: pictures and labels [bytes], cpu_s processor time [s].
    """

    size: int
    exports: int
    seconds: float
    pictures: float
    labels: float
    cpu_s: float


def forecast(
    trials: Mapping[int, Trial],
    missing: Mapping[int, Recipe],
    recipes: Sequence[Recipe],
    exports: Sequence[str],
    jobs: int,
) -> Forecast | None:
    """What a data set will take: each sequence as the tried one that is nearest; None without any.

    missing: the recipes that are to be made, by their index in `recipes`.
    """
    if not trials:
        return None
    nearest = [trials[min(trials, key=lambda k: abs(k - i))] for i in range(len(recipes))]
    made = sum(_sequence_bytes(nearest[i], recipe) for i, recipe in missing.items())
    exported = sum(
        recipe.job.frames * _export_bytes(nearest[i], recipe, exports)
        for i, recipe in enumerate(recipes)
    )
    workers = min(jobs, len(missing))
    seconds = sum(
        nearest[i].start_s + recipe.job.frames * nearest[i].frame_s for i, recipe in missing.items()
    )
    size = round(made + exported + DATASET_BYTES)
    frames = sum(recipe.job.frames for recipe in missing.values())

    def mean(part: Callable[[Trial], float]) -> float:
        return sum(r.job.frames * part(nearest[i]) for i, r in missing.items()) / frames

    return Forecast(
        size=size,
        exports=round(exported),
        seconds=seconds / workers + EXPORT_S_PER_MB * exported / 1e6,
        pictures=mean(lambda trial: trial.pictures),
        labels=mean(lambda trial: trial.labels),
        cpu_s=mean(lambda trial: trial.frame_cpu_s),
    )


def _sequence_bytes(trial: Trial, recipe: Recipe) -> float:
    job = recipe.job
    learnt = setting_of(job.scenario, job.overrides, "background_frames")
    frames = job.frames * (trial.pictures + trial.labels + FRAME_BYTES)
    return frames + learnt * trial.pictures + SEQUENCE_BYTES


def _export_bytes(trial: Trial, recipe: Recipe, exports: Sequence[str]) -> float:
    """Bytes of a frame in all exports.

    WebDataset and HDF5 repeat pictures and labels, Parquet and Middlebury pictures; YOLO links
    them.
    """
    width, height = recipe.settings.size_px or OWN_SIZE
    repeated = {
        "webdataset": trial.pictures + trial.labels,
        "parquet": trial.pictures,
        "hdf5": trial.pictures + trial.labels,
        "middlebury": trial.pictures + PFM_BYTES * width * height,
    }
    return sum(EXPORT_FRAME_BYTES[name] + repeated.get(name, 0.0) for name in exports)


def refuse_without_room(expected: Forecast, out: Path) -> int:
    """The bytes that are free where a data set is to be. Raises InfrastructureError if too few."""
    free = shutil.disk_usage(out).free
    if expected.size > free:
        raise InfrastructureError(
            f"{out}: takes about {decimal(expected.size)} ({decimal(expected.exports)} of it "
            f"exports), the disk has {decimal(free)} left: give another --out, fewer --labels or "
            "--export, or a smaller --size"
        )
    return free


def try_sequences(executor: Executor, recipes: Mapping[int, Recipe]) -> dict[int, Trial]:
    """Make frames of a few sequences, evenly spread, in workers. A sequence that fails is left out.

    recipes: of the sequences that are to be made, by index; none of fewer than `LEAST_FRAMES`.
    Raises InfrastructureError.
    """
    frames = sum(recipe.job.frames for recipe in recipes.values())
    if frames < LEAST_FRAMES:
        return {}
    indices = sorted(recipes)
    count = min(max(frames // FRAMES_A_TRIAL, 1), MOST_TRIALS, len(indices))
    chosen = sorted({indices[(2 * k + 1) * len(indices) // (2 * count)] for k in range(count)})
    tasks = {index: recipes[index] for index in chosen}
    trials = {}
    for ended in executor.outcomes(_try_sequence, tasks, TRIAL_LIMIT_S, attempts=1):
        if ended is None:
            continue
        index, outcome = ended
        if isinstance(outcome, Answer) and outcome.value is not None:
            trials[index] = outcome.value
    return trials


def _try_sequence(recipe: Recipe) -> Trial | None:
    """None where the sequence cannot be made, of which its own turn has the reason."""
    started = time.perf_counter()
    try:
        with TemporaryDirectory() as name, Simulation(recipe.performance()) as simulation:
            sizes = []
            # Flow is of two frames that follow each other; other labels need one.
            span = 1 + ("flow" in recipe.settings.labels)
            for index in (recipe.job.frames // 4, 3 * recipe.job.frames // 4):
                folder = Path(name, str(index))
                folder.mkdir()
                begun, begun_cpu = time.perf_counter(), time.process_time()
                write_frames(simulation, folder, recipe.settings.labels, range(index, index + span))
                ended, ended_cpu = time.perf_counter(), time.process_time()
                sizes.append([size / span for size in _sizes(folder)])
    except InfrastructureError:
        raise
    except (BenchError, ValueError, OSError):
        return None
    pictures, labels = (sum(column) / len(sizes) for column in zip(*sizes, strict=True))
    wall_s, cpu_s = (ended - begun) / span, (ended_cpu - begun_cpu) / span
    return Trial(pictures, labels, begun - started, wall_s, cpu_s)


def _sizes(folder: Path) -> tuple[int, int]:
    """Bytes of pictures and of labels below a folder; the tables of a frame say nothing.

    Two frames have one flow each way, more frames have nearly one each.
    """
    pictures = labels = 0
    for path in folder.glob("*/*"):
        if path.parent.name in ("left", "right"):
            pictures += path.stat().st_size
        else:
            labels += path.stat().st_size * (1 + path.parent.name.startswith("flow_"))
    return pictures, labels
