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

    frames: of the last run; results: runs that gave one; lost: by key, trials without a result
    through no fault of the draw.
    """

    meter: Meter
    doing: str = "starting"
    runs: int = 0
    results: int = 0
    failures: int = 0
    best: float = float("inf")
    frames: int = 0
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
        """Begin another part of the campaign; total: of the trials in it."""
        self.doing, self.best, self.failures = doing, float("inf"), 0
        self.meter.begin(self._text(), total, "run")

    def running_runs(self, executor: Executor) -> float:
        """The runs in progress, as the share of their frames that is done."""
        return executor.running_steps() / self.frames if self.frames else 0.0

    def _text(self) -> str:
        best = f", best rho {self.best:+.2f}" if self.best < float("inf") else ""
        return f"{self.doing}: {self.failures} failed{best}"


@contextmanager
def campaign_progress(executor: Executor, total: int | None = None) -> Iterator[Progress]:
    """A progress line on standard error, until the block ends. executor: plays the trials."""
    with progress() as meter:
        counted = Progress(meter)
        meter.running = lambda: counted.running_runs(executor)
        meter.begin("starting", total, "run")
        yield counted
