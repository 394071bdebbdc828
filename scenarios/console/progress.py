"""The progress of every long verb: a live line on a terminal, a plain line now and then elsewhere.

Both go to standard error: what a verb prints of its results is never mixed with them.
"""

from __future__ import annotations

import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from reports.summary.text import count, duration
from scenarios.console.screen import is_screen
from sim.steps import counting

PLAIN_S = 30.0  # between two lines in a pipe or the log of a CI job
SAMPLE_S = 1.0
WINDOW_S = 120.0  # over which the pace is taken
REFRESH_HZ = 4.0
WIDE_COLUMNS, BAR_COLUMNS, SHORT_BAR_COLUMNS = 80, 24, 10


class Pace:
    """How fast steps are done lately: the time that is left."""

    def __init__(self) -> None:
        self._samples: deque[tuple[float, float]] = deque()

    def left_s(self, now_s: float, done: float, total: float) -> float | None:
        """The time until `total` [s]; None while nothing says."""
        samples = self._samples
        # A worker was killed, or a finished part is not counted yet: what was done of it is not.
        first_s = samples[0][0] if samples else now_s
        while samples and samples[-1][1] > done:
            samples.pop()
        if not samples and first_s < now_s:
            samples.append((first_s, done))
        if done > 0 and (not samples or now_s >= samples[-1][0] + SAMPLE_S):
            samples.append((now_s, done))
        while len(samples) > 2 and samples[0][0] < now_s - WINDOW_S:
            samples.popleft()
        if not samples or now_s <= samples[0][0] or done <= samples[0][1]:
            return None
        started_s, before = samples[0]
        return max(total - done, 0.0) * (now_s - started_s) / (done - before)


class Meter:
    """What a verb has done: steps of parts that are finished, and of those in progress.

    doing: a few words for the line. A step is a frame wherever there are frames.
    """

    def __init__(
        self,
        running: Callable[[], float] = lambda: 0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.doing = "starting"
        self.running = running
        self._clock = clock
        self._begun_s = clock()
        self._lock = threading.Lock()
        self.begin("starting", None)

    def begin(self, doing: str, total: int | None, unit: str = "frame", finished: int = 0) -> None:
        """Begin a part of the work. total: its steps, None: not known; finished: those done."""
        with self._lock:
            self.doing, self._total, self._unit = doing, total, unit
            self._finished, self._current = float(finished), 0.0
            self._before = float(finished)
            self._pace = Pace()

    def expect(self, steps: int) -> None:
        """Add steps to this part of the work, whose total was not known before."""
        with self._lock:
            self._total = (self._total or 0) + steps

    def step(self) -> None:
        """Count a step that was done in this process."""
        self._current += 1

    def finish(self, steps: int, doing: str | None = None) -> None:
        """Count the steps of a finished part, in place of those counted while it went on."""
        self._finished += steps
        self._current = 0.0
        self.doing = self.doing if doing is None else doing

    @property
    def done(self) -> float:
        """Steps done until now."""
        done = self._finished + self._current + self.running()
        return done if self._total is None else min(done, self._total)

    @property
    def share(self) -> float | None:
        """The share that is done, 0-1; None where the total is not known."""
        return None if not self._total else self.done / self._total

    def figures(self) -> str:
        """Steps done and in all, and the time left; sampled each time."""
        with self._lock:
            done, total = self.done, self._total
            if total is None:
                return count(int(done), self._unit) if done else ""
            left_s = self._pace.left_s(self._clock(), done - self._before, total - self._before)
            left = "" if left_s is None else f", {duration(left_s)} left"
            return f"{int(done)}/{count(total, self._unit)}{left}"

    def plain_line(self) -> str:
        """A line for a log."""
        parts = (self.doing, self.figures(), f"{duration(self._clock() - self._begun_s)} gone")
        return "progress: " + ", ".join(part for part in parts if part)

    def live_line(self, columns: int) -> Table:
        """The line of a terminal of this width: words, bar, figures; the words are cut first."""
        line = Table.grid(padding=(0, 1), expand=True)
        line.add_column(no_wrap=True, overflow="ellipsis", ratio=1)
        line.add_column(no_wrap=True)
        line.add_column(no_wrap=True, justify="right")
        width = BAR_COLUMNS if columns >= WIDE_COLUMNS else SHORT_BAR_COLUMNS
        share = self.share
        bar = ProgressBar(
            total=1.0, completed=share or 0.0, width=width, pulse=share is None and self.done == 0
        )
        figures = self.figures()
        if "left" not in figures:  # something moves from the first second on
            figures = f"{figures} {duration(self._clock() - self._begun_s)} gone".strip()
        line.add_row(Text(self.doing), bar, Text(figures))
        return line


@contextmanager
def progress(
    console: Console | None = None,
    running: Callable[[], float] = lambda: 0,
    plain_s: float = PLAIN_S,
) -> Iterator[Meter]:
    """Show a meter on standard error until the block ends; it leaves nothing on a terminal.

    console: of other messages on standard error, which appear above the live line. running: the
    steps of parts in progress elsewhere (`Executor.running_steps`); steps that this thread counts
    (`sim.steps`) count too. plain_s: between two lines where standard error is no terminal.
    """
    console = Console(stderr=True) if console is None else console
    meter = Meter(running)
    shown = _live(console, meter) if is_screen(console) else _plain(meter, plain_s)
    with shown, counting(meter.step):
        yield meter


@contextmanager
def _live(console: Console, meter: Meter) -> Iterator[None]:
    with Live(
        get_renderable=lambda: meter.live_line(console.width),
        console=console,
        refresh_per_second=REFRESH_HZ,
        transient=True,
        redirect_stdout=False,
        redirect_stderr=False,
    ):
        yield


@contextmanager
def _plain(meter: Meter, plain_s: float) -> Iterator[None]:
    ended = threading.Event()

    def write_lines() -> None:
        due_s = time.monotonic() + plain_s
        while not ended.wait(min(SAMPLE_S, plain_s)):
            meter.figures()  # samples the pace
            if time.monotonic() >= due_s and sys.stderr is not None:
                due_s += plain_s
                sys.stderr.write(meter.plain_line() + "\n")
                sys.stderr.flush()

    writer = threading.Thread(target=write_lines, name="progress", daemon=True)
    writer.start()
    try:
        yield
    finally:
        ended.set()
        writer.join()
