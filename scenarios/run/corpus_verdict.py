"""The verdict of a run on the corpus cases that it played: fixed ones must stay fixed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from reports.run.rows import EpisodeRows
from reports.score.robustness import robustness_of
from reports.summary.text import count
from scenarios.play.job import Job, System
from scenarios.spec.corpus_case import CorpusCase, corpus_cases
from scenarios.spec.draw import setting_of


class FixedCaseFails(BenchError):
    """A corpus case that was fixed fails again. Exit code 1."""

    exit_code = 1


@dataclass(frozen=True)
class CaseOutcome:
    """A corpus case as it was played; rho: None where the episode gave no result."""

    case: CorpusCase
    system: System
    rho: float | None

    @property
    def fails(self) -> bool:
        """Whether the event of the case happens."""
        return self.rho is None or self.rho < 0

    @property
    def regression(self) -> bool:
        """Whether a fixed case fails with the tracker and detector that it was fixed for."""
        case, system = self.case, self.system
        same = (case.detector, case.tracker) == (system.detector, system.tracker)
        return same and case.status == "fixed" and self.fails

    @property
    def text(self) -> str:
        """A line for people."""
        case = self.case
        rho = "no result" if self.rho is None else f"rho {self.rho:+.2f}"
        outcome = f"{case.event} {'again' if self.fails else 'does not happen'} ({rho})"
        other = self.system.tracker
        by = "" if other == case.tracker else f" with {other}"
        return f"{case.name}: {case.status} for {case.tracker}: {outcome}{by}"


def outcomes_of(
    targets: Sequence[str], jobs: Sequence[Job], rows: Sequence[EpisodeRows]
) -> tuple[CaseOutcome, ...]:
    """The outcomes of the corpus cases among the targets of a run. Raises FileFault."""
    cases = {case.name: case for target in targets for case in corpus_cases(target)}
    played = {(job.name, job.seed): job for job in jobs}
    outcomes = []
    for row in rows:
        case = cases.get(row.scenario)
        if case is not None and row.seed == case.seed:
            job = played[row.scenario, row.seed]
            outcomes.append(CaseOutcome(case, job.system, _rho(row, case, job)))
    return tuple(outcomes)


def verdict_lines(outcomes: Sequence[CaseOutcome]) -> Iterator[str]:
    """What people must know: how many fail, and each case that is not as its status says."""
    if not outcomes:
        return
    fixed = [o for o in outcomes if o.case.status == "fixed"]
    opened = [o for o in outcomes if o.case.status == "open"]
    yield (
        f"corpus: {count(len(outcomes), 'case')}; of {len(fixed)} fixed "
        f"{sum(o.fails for o in fixed)} fail, of {len(opened)} open "
        f"{sum(o.fails for o in opened)} fail"
    )
    for outcome in outcomes:
        if outcome.fails == (outcome.case.status == "fixed"):
            yield outcome.text


def refuse_regressions(outcomes: Sequence[CaseOutcome]) -> None:
    """Raise FixedCaseFails where a fixed case fails with its own tracker and detector."""
    broken = [o for o in outcomes if o.regression]
    if broken:
        raise FixedCaseFails(
            f"{count(len(broken), 'fixed case')} of the corpus "
            f"{'fails' if len(broken) == 1 else 'fail'} again, the first: {broken[0].text}"
        )


def _rho(row: EpisodeRows, case: CorpusCase, job: Job) -> float | None:
    if row.failure:
        return None
    fps = setting_of(job.scenario, job.overrides, "fps")
    truths, estimates = (_positions(row.frames, kind) for kind in ("truth", "estimate"))
    return robustness_of(truths, estimates, fps).measures[case.event]


def _positions(frames: Mapping[str, Sequence[object]], kind: str) -> Floats:
    """Positions (F, T, 3) of the columns of `FRAMES`, whose rows are frame by frame."""
    columns = [np.array(frames[f"{kind}_{axis}_m"], dtype=np.float64) for axis in "xyz"]
    return np.stack(columns, axis=-1).reshape(-1, len(TARGETS), 3)
