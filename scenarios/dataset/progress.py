"""The progress bar of `dataset make`."""

from __future__ import annotations

import time
from collections.abc import Mapping

from rich.console import Console
from rich.filesize import decimal
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from scenarios.dataset.sequence_plan import sequence_entry
from scenarios.dataset.sequence_task import SequenceTask


class MakeProgress:
    """A bar of sequences, frames a second, time left and bytes; counts pictures on the disk."""

    def __init__(self, console: Console, tasks: Mapping[int, SequenceTask], frames: int) -> None:
        self._tasks, self._frames = tasks, frames
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[figures]}"),
            TimeElapsedColumn(),
            console=console,
            transient=True,
        )
        self._id = self._bar.add_task("starting", total=frames, figures="")
        self._started = time.perf_counter()

    def step(self, sequences: int, size: int) -> None:
        """Show the progress. sequences: finished; size: their bytes."""
        done = 0
        for task in self._tasks.values():
            if task.final.is_dir():
                done += sequence_entry(0, task.recipe).frames
            else:
                done += sum(1 for _ in task.part.parent.glob(f"{task.part.name}-*/left/*"))
        rate = done / max(time.perf_counter() - self._started, 1e-9)
        left_s = (self._frames - done) / rate if done else 0.0
        figures = (
            f"{done}/{self._frames} frames, {rate:.1f}/s, {left_s:.0f} s left, {decimal(size)}"
        )
        name = f"{sequences}/{len(self._tasks)} sequences"
        self._bar.update(self._id, completed=done, description=name, figures=figures)

    def __enter__(self) -> MakeProgress:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()
