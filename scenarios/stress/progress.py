"""The progress of a campaign: runs, failures, the best robustness, the time that is left."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from scenarios.console.progress import Meter, progress
from scenarios.execute.executor import Executor
from scenarios.stress.case import Trial, TrialResult


@dataclass
class Progress:
    """Counts what is played.

    frames: of the last run, of the first as they are planned; results: runs that gave one; lost: by
    key, trials without a result through no fault of the draw.
    """

    meter: Meter
    frames: int = 0
    doing: str = "starting"
    runs: int = 0
    results: int = 0
    failures: int = 0
    best: float = float("inf")
    lost: dict[str, tuple[Trial, TrialResult]] = field(default_factory=dict)

    @property
    def quarantined(self) -> list[tuple[Trial, TrialResult]]:
        """The trials without a result, in an order that no number of workers changes."""
        return [self.lost[key] for key in sorted(self.lost)]

    def on_result(self, trial: Trial, result: TrialResult) -> None:
        """Count a trial, played or found in the journal."""
        self.runs += 1
        self.failures += bool(result.failed)
        if result.robustness is not None:
            self.results += 1
            self.best = min(self.best, result.robustness.worst)
        if result.failure is not None and result.failure.kind != "unposable":
            self.lost[trial.key] = trial, result
        if result.frames:
            self.frames = result.frames
        self.meter.finish(1, self._text())

    def start(self, doing: str, total: int | None = None) -> None:
        """Begin another part of the campaign; total: its trials, None: `expect` adds them."""
        self.doing, self.best, self.failures = doing, float("inf"), 0
        self.meter.begin(self._text(), total, "run")

    def expect(self, trials: int) -> None:
        """Add trials that this part of the campaign plays next."""
        self.meter.expect(trials)

    def running_runs(self, executor: Executor) -> float:
        """The runs in progress, as the share of their frames that is done."""
        return executor.running_steps() / self.frames if self.frames else 0.0

    def _text(self) -> str:
        if self.best == float("inf"):  # nothing was played yet
            return self.doing
        return f"{self.doing}: {self.failures} failed, best rho {self.best:+.2f}"


@contextmanager
def campaign_progress(
    executor: Executor, frames: int = 0, total: int | None = None
) -> Iterator[Progress]:
    """A progress line on standard error, until the block ends.

    executor: plays the trials; frames: of a trial, until one has ended.
    """
    with progress() as meter:
        counted = Progress(meter, frames)
        meter.running = lambda: counted.running_runs(executor)
        meter.begin("starting", total, "run")
        yield counted
