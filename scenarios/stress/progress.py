"""The progress of a campaign: runs, failures, the best robustness, the time that is left."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from rich.console import Console
from rich.progress import Progress as Bar
from rich.progress import TaskID

from scenarios.console.progress import progress_bar
from scenarios.stress.case import Trial, TrialResult


@dataclass
class Progress:
    """Counts what is played. lost: by key, trials without a result through no fault of the draw."""

    bar: Bar
    task: TaskID
    doing: str = "starting"
    runs: int = 0
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
            self.best = min(self.best, result.robustness.worst)
        if result.failure is not None and result.failure.kind != "unposable":
            self.lost[trial.key] = trial, result
        self.show()
        self.bar.advance(self.task)

    def start(self, doing: str, total: int | None = None) -> None:
        """Begin another part of the campaign; total: of the trials in it."""
        self.doing, self.best, self.failures = doing, float("inf"), 0
        self.bar.reset(self.task, total=total)
        self.show()

    def show(self) -> None:
        """Bring the line up to date."""
        best = f", best rho {self.best:+.2f}" if self.best < float("inf") else ""
        text = f"{self.doing}: {self.failures} failed{best}"
        self.bar.update(self.task, description=text)


@contextmanager
def campaign_progress(total: int | None = None) -> Iterator[Progress]:
    """A progress line on standard error, until the block ends."""
    with progress_bar(Console(stderr=True)) as bar:
        yield Progress(bar, bar.add_task("starting", total=total))
