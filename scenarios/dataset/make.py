"""The verb `dataset make`: sequences in worker processes, whole or not at all, and resumed."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import shutil
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.filesize import decimal
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from pjpdaf.errors import BenchError, InfrastructureError
from pjpdaf.plugins.registry import described
from reports.run.provenance import PACKAGES, provenance
from reports.summary.text import count
from scenarios.console.folder import written_whole
from scenarios.console.interrupts import Interrupted, interrupts
from scenarios.dataset.finish import write_exports, write_text, write_top
from scenarios.dataset.verify import cast_rays
from scenarios.play.ladder import rungs_of
from scenarios.play.play import digest_of
from scenarios.play.recipe import FILES, Recipe, Settings, read_recipe, stored_name
from scenarios.run.run import RunRequest, plan, worker_count
from scenarios.spec.draw import setting_of
from scenarios.spec.names import scenario_names, suite_names
from sim import gl
from sim.contact.contact import Unposable
from sim.dataset.files.checksums import files_below, read_sums, sha256_of, text_of
from sim.dataset.files.layout import (
    CHECKSUMS,
    MANIFEST,
    PART,
    sequence_name,
)
from sim.dataset.files.manifest import SequenceEntry, manifest_record, write_manifest
from sim.dataset.files.reading import read_json
from sim.dataset.reader import open_dataset
from sim.dataset.writer import Written, write_frame, write_sequence
from sim.files import disk_faults
from sim.processes import WORKER_ENVIRONMENT, Answer, Lost, Workers
from sim.sequence import Simulation

TIME_LIMIT_S = 24 * 3600.0  # of one sequence; nothing of a user's is called in it
# A worker is replaced after this many sequences: whatever a driver leaks goes with it.
SEQUENCES_A_WORKER = 64
RAY_FRAMES = 4  # of a data set, compared with rays for its card


@dataclass(frozen=True)
class MakeRequest:
    """What the command line asked for; None = the default."""

    targets: tuple[str, ...]
    out: Path
    seeds: int | None = None
    first_seed: int = 0
    settings: tuple[str, ...] = ()
    labels: Settings = field(default_factory=Settings)
    exports: tuple[str, ...] = ()
    ladder: bool = False
    jobs: int | None = None


@dataclass(frozen=True)
class _Task:
    """One sequence to make, in a worker. part: begins the name of the folder to write into."""

    recipe: Recipe
    part: Path
    final: Path


def make(request: MakeRequest) -> None:
    """Make, or go on making, a data set. Raises BenchError; Interrupted after a signal."""
    workers = worker_count(request.jobs)
    recipes = recipes_of(request)
    out = request.out.absolute()
    settings = {**request.labels.record(), "ladder": request.ladder}
    entries = [entry_of(index, recipe) for index, recipe in enumerate(recipes)]
    words = words_of(request)
    console = Console(stderr=True)
    with disk_faults(out, "the data set"):
        out.mkdir(parents=True, exist_ok=True)
    with _alone(out), interrupts() as arrived, arrived.raising():
        _check_same(out, settings, entries)
        try:
            with Workers(workers, SEQUENCES_A_WORKER) as pool:
                made_with = {"renderer": pool.renderer(), "versions": versions()}
                _check_renderer(out, made_with)
                _sweep(out)
                if not (out / MANIFEST).exists():
                    record = manifest_record(entries, settings, made_with, False, words)
                    write_manifest(out, record)
                tasks = {
                    index: _Task(
                        replace(recipes[index], made_with=made_with),
                        out / f"{PART}{entry.folder}",
                        out / entry.folder,
                    )
                    for index, entry in enumerate(entries)
                    if not (out / entry.folder).is_dir()
                }
                frames = sum(entries[index].frames for index in tasks)
                started = time.perf_counter()
                with _Progress(console, tasks, frames) as progress:
                    written = _make_all(pool, tasks, progress.step)
            _sweep(out)  # of workers that were killed
            wall_s = time.perf_counter() - started
            finish(out, entries, settings, made_with, request.exports, words)
        except KeyboardInterrupt:
            _sweep(out)
            done = sum((out / entry.folder).is_dir() for entry in entries)
            raise Interrupted(
                f"interrupted: {done} of {len(entries)} sequences are in {out}; the same command "
                "goes on"
            ) from None
        except BaseException:
            _sweep(out)
            raise
    size = sum(one.bytes for one in written)
    said = f"{count(len(tasks), 'sequence')}, {count(frames, 'stereo frame')}"
    if tasks:
        said += f", {decimal(size)} in {wall_s:.0f} s ({frames / wall_s:.1f} frames/s)"
    kept = len(entries) - len(tasks)
    print(f"{said}, {count(workers, 'worker')}" + (f"; {kept} were there" if kept else ""))
    print(f"data set: {request.out}")


def recipes_of(request: MakeRequest) -> list[Recipe]:
    """All sequences in their order; everything that can be wrong with them is found here."""
    for pair in request.settings:
        part = pair.partition("=")[0].partition(".")[0]
        if part in ("tracker", "detector"):
            raise BenchError(f"--set {pair}: a data set has no {part}; it is for `run`")
    run = RunRequest(
        targets=request.targets,
        seeds=request.seeds,
        preset="thesis",
        detector="thesis",
        tracker="thesis",
        settings=request.settings,
        jobs=None,
        out=None,
        argv=(),
        first_seed=request.first_seed,
    )
    recipes = []
    for job in plan(run):
        if not request.ladder:
            recipes.append(Recipe(job, request.labels))
            continue
        for rung, rung_job in rungs_of(job).items():
            recipes.append(Recipe(rung_job, request.labels, rung))
    return recipes


def words_of(request: MakeRequest) -> tuple[str, ...]:
    """The command that makes the same again anywhere: without places and numbers of workers."""
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
    words += ["--ladder"] * request.ladder
    for pair in request.settings:
        key, _, value = pair.partition("=")
        words += ["--set", f"{key}={Path(value).name}"]  # a value may be a file
    return (*words, "--out", "DIR")


def entry_of(index: int, recipe: Recipe) -> SequenceEntry:
    """What the manifest says of a sequence."""
    job = recipe.job
    return SequenceEntry(
        folder=sequence_name(index),
        scenario=job.scenario.name,
        label=job.name,
        group=job.scenario.group,
        seed=job.seed,
        rung=recipe.rung,
        digest=digest_of(job),
        frames=int(setting_of(job.scenario, job.overrides, "frames")),
        fps=setting_of(job.scenario, job.overrides, "fps"),
    )


def versions() -> dict[str, str]:
    """Of all on which the bytes depend."""
    found = provenance()["versions"]
    assert isinstance(found, dict)
    wanted = ("mujoco", "numpy", "opencv-python-headless", "pjpdaf-bench", "scipy", "pyarrow")
    return {name: found[name] for name in wanted if name in PACKAGES}


def _make_one(task: _Task) -> Written | BenchError:
    """In a worker: make a sequence in a part folder, then give it its name."""
    if task.final.is_dir():  # the worker before was killed between finishing and saying so
        files = files_below(task.final)
        size = sum(file.stat().st_size for file in files)
        return Written(entry_of(0, task.recipe).frames, len(files), size)
    part = task.part.with_name(f"{task.part.name}-{os.getpid()}")
    try:
        with disk_faults(task.final, "the data set"):
            part.mkdir()
            with _held(part):  # nobody sweeps it away while this process lives
                written = write_recipe(task.recipe, part)
                part.rename(task.final)
        return written
    except BenchError as fault:
        return fault
    except Unposable as fault:
        return BenchError(f"{task.final.name}: cannot be posed: {fault}; leave out this seed")
    except Exception as fault:
        return InfrastructureError(f"{task.final.name}: {described(fault)}")
    finally:
        shutil.rmtree(part, ignore_errors=True)


@contextmanager
def _held(folder: Path, wait_for_it: bool = True) -> Iterator[None]:
    """The folder's lock, which ends with the process, in any way. Raises BlockingIOError, OSError.

    On a disk without locks nothing is held.
    """
    opened = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | (0 if wait_for_it else fcntl.LOCK_NB))
    except OSError as fault:
        if fault.errno not in (errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS, errno.EINVAL):
            os.close(opened)
            raise
    try:
        yield
    finally:
        os.close(opened)


def write_recipe(recipe: Recipe, folder: Path) -> Written:
    """A recipe's sequence in an empty folder. Raises BenchError, Unposable, OSError."""
    performance = recipe.performance()
    for file in recipe.files().values():
        (folder / FILES).mkdir(exist_ok=True)
        shutil.copyfile(file.path, folder / FILES / stored_name(file))
    with Simulation(performance) as simulation:
        record = recipe.record(performance.redrawn)
        return write_sequence(simulation, folder, recipe.settings.labels, record)


def _make_all(
    pool: Workers, tasks: Mapping[int, _Task], on_poll: Callable[[int, int], None]
) -> list[Written]:
    """Make them. Raises BenchError of the first that fails; the others are ended then."""
    written: list[Written] = []
    for found in pool.outcomes(_make_one, tasks, TIME_LIMIT_S):
        if found is not None:
            index, outcome = found
            written.append(_written(tasks[index], outcome))
        on_poll(len(written), sum(one.bytes for one in written))
    return written


def _written(task: _Task, outcome: Answer[Written | BenchError] | Lost) -> Written:
    name = task.final.name
    if isinstance(outcome, Lost):
        if outcome.late:
            hours = TIME_LIMIT_S / 3600
            raise InfrastructureError(f"{name}: not finished within {hours:.0f} hours")
        times, code = outcome.attempts, outcome.exit_code
        raise InfrastructureError(f"{name}: its worker died {times} times (exit code {code})")
    if isinstance(outcome.value, BenchError):
        raise outcome.value
    return outcome.value


def finish(
    out: Path,
    entries: Sequence[SequenceEntry],
    settings: Mapping[str, Any],
    made_with: Mapping[str, Any],
    exports: Sequence[str],
    command: Sequence[str],
) -> None:
    """Write all that is made from the finished sequences; the manifest that says so comes last.

    A few frames are compared with rays, and the card says what came of it.
    """
    write_manifest(out, manifest_record(entries, settings, made_with, False, command))
    dataset = open_dataset(out)
    write_exports(dataset, exports)
    write_top(dataset, command, cast_rays(out, RAY_FRAMES).figures)
    write_manifest(out, manifest_record(entries, settings, made_with, True, command))
    write_sums(out, [entry.folder for entry in entries])


def labels_of(folder: Path) -> tuple[str, ...]:
    """The labels of a data set. Raises BenchError."""
    return open_dataset(folder).labels


def export_again(folder: Path, exports: Sequence[str]) -> list[Path]:
    """`dataset export`: the formats, and the checksums of the whole anew; the files written.

    Raises BenchError, also where the data set is not finished.
    """
    dataset = open_dataset(folder)
    if not dataset.manifest.get("complete"):
        raise BenchError(f"{folder}: is not finished; give the command that made it once more")
    with _alone(folder), interrupts() as arrived, arrived.raising():
        written = write_exports(dataset, exports)
        # The card and Croissant name what is there.
        command = dataset.manifest.get("command")
        words = [str(word) for word in command] if isinstance(command, list) else []
        write_top(dataset, words, cast_rays(folder, RAY_FRAMES).figures)
        write_sums(folder, [sequence.name for sequence in dataset.sequences])
    return written


def write_sums(out: Path, sequences: Sequence[str]) -> None:
    """SHA256SUMS of the whole: the sequences' own sums are taken over, the rest is read."""
    sums: dict[str, str] = {}
    for name in sequences:
        own = out / name / CHECKSUMS
        sums |= {f"{name}/{path}": value for path, value in read_sums(own).items()}
        sums[f"{name}/{CHECKSUMS}"] = sha256_of(own)
    known = set(sequences)
    for path in sorted(out.iterdir()):
        if path.name in known or path.name == CHECKSUMS or path.name.startswith(PART):
            continue
        for file in files_below(path) if path.is_dir() else (path,):
            sums[file.relative_to(out).as_posix()] = sha256_of(file)
    write_text(out / CHECKSUMS, text_of(sums))


@contextmanager
def _alone(out: Path) -> Iterator[None]:
    """Only one process makes a data set. Raises BenchError where another does."""
    with disk_faults(out, "the data set"), ExitStack() as held:
        try:
            held.enter_context(_held(out, wait_for_it=False))
        except BlockingIOError:
            raise BenchError(
                f"{out}: another process is making this data set; wait for it, or end it"
            ) from None
        opened = held.pop_all()
    with opened:
        yield


def _check_same(out: Path, settings: Mapping[str, Any], entries: Sequence[SequenceEntry]) -> None:
    """Raise BenchError where something else lies in the folder, or another data set."""
    path = out / MANIFEST
    if not path.exists():
        others = [p.name for p in out.iterdir() if not p.name.startswith(".")]
        if others:
            raise BenchError(
                f"{out}: is not empty ({sorted(others)[0]}) and no data set; give a new folder"
            )
        return
    record = open_dataset(out).manifest
    had = record.get("settings")
    if had != json.loads(json.dumps(settings)):
        raise BenchError(f"{out}: holds a data set of other settings: {_difference(had, settings)}")
    before = [(e.get("folder"), e.get("digest")) for e in record["sequences"]]
    if before != [(entry.folder, entry.digest) for entry in entries]:
        raise BenchError(
            f"{out}: holds a data set of other scenarios or seeds ({len(before)} sequences, asked "
            f"for {len(entries)}); give another folder"
        )


def _difference(had: Any, asked: Mapping[str, Any]) -> str:
    before = had if isinstance(had, Mapping) else {}
    for key, value in asked.items():
        if before.get(key) != value:
            return f"{key} {before.get(key)}, asked for {value}; give another folder"
    return "give another folder"


def _check_renderer(out: Path, made_with: Mapping[str, Any]) -> None:
    """Raise BenchError where the rest would not have the bytes that the first part has."""
    path = out / MANIFEST
    if not path.exists():
        return
    before = read_json(path).get("made_with")
    if before != made_with:
        raise BenchError(
            f"{out}: was begun with another OpenGL library or other versions; the rest would not "
            "fit to it. Go on where it was begun, or give a new folder"
        )


def _sweep(out: Path) -> None:
    """Remove what killed processes left half-written, once they have really ended."""
    for path in (*out.glob(f"{PART}*"), *out.glob(".*.part-*")):
        with suppress(FileNotFoundError), _held(path):
            shutil.rmtree(path, ignore_errors=True)


class _Progress:
    """Sequences, frames a second, time left and bytes; counts the files that are being written."""

    def __init__(self, console: Console, tasks: Mapping[int, _Task], frames: int) -> None:
        self._tasks, self._frames = tasks, frames
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[said]}"),
            TimeElapsedColumn(),
            console=console,
            transient=True,
        )
        self._id = self._bar.add_task("starting", total=frames, said="")
        self._started = time.perf_counter()

    def step(self, sequences: int, size: int) -> None:
        """What is written by now: whole sequences, their bytes."""
        done = 0
        for task in self._tasks.values():
            if task.final.is_dir():
                done += entry_of(0, task.recipe).frames
            else:
                done += sum(1 for _ in task.part.parent.glob(f"{task.part.name}-*/left/*"))
        rate = done / max(time.perf_counter() - self._started, 1e-9)
        left_s = (self._frames - done) / rate if done else 0.0
        said = f"{done}/{self._frames} frames, {rate:.1f}/s, {left_s:.0f} s left, {decimal(size)}"
        name = f"{sequences}/{len(self._tasks)} sequences"
        self._bar.update(self._id, completed=done, description=name, said=said)

    def __enter__(self) -> _Progress:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()


def make_again(path: Path, out: Path, frame: int | None = None) -> str:
    """`dataset make --recipe`: a sequence, or one frame of it, again; what is said at the end.

    The bytes are those of before where OpenGL library and versions are the same; where they are
    not, what is said says so. Raises BenchError, Unposable.
    """
    for name, value in WORKER_ENVIRONMENT.items():
        os.environ.setdefault(name, value)
    recipe = read_recipe(read_json(path), path.absolute().parent)
    frames = entry_of(0, recipe).frames
    if frame is not None and not 0 <= frame < frames:
        raise BenchError(f"--frame {frame}: the sequence has the frames 0 to {frames - 1}")
    gl.prepare()
    made_with = {"renderer": gl.describe(), "versions": versions()}
    with written_whole(out) as part, disk_faults(out, "the sequence"):
        if frame is None:
            write_recipe(replace(recipe, made_with=made_with), part)
        else:
            with Simulation(recipe.performance()) as simulation:
                write_frame(simulation, part, recipe.settings.labels, frame)
    what = "sequence" if frame is None else f"frame {frame}"
    if recipe.made_with and recipe.made_with != made_with:
        return f"{what}: {out}\nmade with {_other(recipe.made_with, made_with)}: bytes may differ"
    return f"{what}: {out}"


def _other(then: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    if then.get("renderer") != now["renderer"]:
        return f"{now['renderer']}, once with {str(then.get('renderer'))[:100]}"
    old = then.get("versions")
    changed = [
        f"{name} {version}, once {old.get(name) if isinstance(old, Mapping) else None}"
        for name, version in now["versions"].items()
        if not isinstance(old, Mapping) or old.get(name) != version
    ]
    return "; ".join(changed)
