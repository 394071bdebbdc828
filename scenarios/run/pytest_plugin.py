"""What the fixtures of the pytest plug-in (`pjpdaf.pytest_plugin`) do: play, and compare.

Their process is somebody's pytest, where `sim`, `reports` and `scenarios` may be packages of the
tests: every function that imports runs inside `own_packages`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import pytest

from pjpdaf.entry import own_packages
from pjpdaf.presets.names import DEFAULT_PRESET

if TYPE_CHECKING:
    from reports.gate.verdict import Verdict
    from reports.run.load import SavedRun
    from reports.summary.tables import Summary, SummaryRow
    from scenarios.play.plan import PlanRequest


@dataclass(frozen=True, eq=False)
class BenchRun:
    """A run that a test played. saved: all of it; the rest: its figures over all scenarios.

    name: below which its baseline is kept.
    """

    name: str
    saved: SavedRun

    @cached_property
    def summary(self) -> Summary:
        """The figures per scenario and target (`reports.summary.tables`)."""
        with own_packages():
            from reports.summary.tables import summarise

            return summarise(self.saved)

    @property
    def overall(self) -> SummaryRow:
        """All scenarios and targets together."""
        return self.summary.overall

    @property
    def median_error_mm(self) -> float:
        """Median 3-D error of all target-frames [mm]."""
        return self.overall.median_mm

    @property
    def within_100(self) -> float:
        """Share of target-frames within 100 mm of the truth."""
        return self.overall.within_100

    @property
    def swapped(self) -> int:
        """Episodes in which the hands were swapped."""
        return self.overall.swapped or 0

    @property
    def lost(self) -> int:
        """Episodes in which a target was lost."""
        return self.overall.lost


class PlayRun(Protocol):
    """The function that the fixture `pjpdaf_run` hands to a test."""

    def __call__(
        self,
        *targets: str,
        tracker: str = DEFAULT_PRESET,
        detector: str = DEFAULT_PRESET,
        seeds: int | None = None,
        settings: Mapping[str, object] | None = None,
    ) -> BenchRun:
        """Play scenarios or suites; the test fails where an episode gives no result.

        tracker, detector: preset, entry point or module:factory. seeds: episodes of each scenario
        [the suite's own; 10]. settings: what `--set` changes.
        """
        ...


Check = Callable[..., "Verdict"]


def player(request: pytest.FixtureRequest, tmp_path: Path) -> PlayRun:
    """The value of the fixture `pjpdaf_run`: a function that plays scenarios for a test."""
    stem = re.sub(r"[^A-Za-z0-9_.-]+", "_", request.node.name).strip("_.")[:80]
    played: list[BenchRun] = []

    def play(
        *targets: str,
        tracker: str = DEFAULT_PRESET,
        detector: str = DEFAULT_PRESET,
        seeds: int | None = None,
        settings: Mapping[str, object] | None = None,
    ) -> BenchRun:
        with own_packages():
            run = one_run(targets, tracker, detector, seeds, settings or {})
        played.append(run)
        return run

    def one_run(
        targets: tuple[str, ...],
        tracker: str,
        detector: str,
        seeds: int | None,
        settings: Mapping[str, object],
    ) -> BenchRun:
        from pjpdaf.errors import BenchError
        from scenarios.play.plan import PlanRequest

        number = len(played) + 1
        name = stem if number == 1 else f"{stem}-{number}"
        wanted = PlanRequest(
            targets=targets,
            seeds=seeds,
            detector=detector,
            tracker=tracker,
            settings=tuple(f"{key}={value}" for key, value in settings.items()),
            keep_pictures=True,
        )
        jobs = request.config.getoption("--pjpdaf-jobs")
        try:
            return BenchRun(name, _play_and_save(wanted, jobs, tmp_path / "pjpdaf" / name))
        except BenchError as fault:
            pytest.fail(str(fault), pytrace=False)

    return play


def _play_and_save(request: PlanRequest, jobs: int | None, folder: Path) -> SavedRun:
    """Play a plan on `jobs` workers and save it. Raises BenchError, also for a failed episode."""
    from scenarios.execute.episodes import play_all
    from scenarios.execute.isolated import allow_plug_ins_from_here
    from scenarios.execute.local import local_executor, worker_count
    from scenarios.play.plan import plan
    from scenarios.run.finish import refuse_failures
    from scenarios.run.save_run import save_run

    allow_plug_ins_from_here(request.detector, request.tracker)
    planned = plan(request)
    with local_executor(worker_count(jobs)) as executor:
        played = play_all(planned, executor)
    if played.interrupted:
        raise KeyboardInterrupt
    refuse_failures(played)
    return save_run(request, planned, played, folder)


def checker(request: pytest.FixtureRequest) -> Check:
    """The value of the fixture `assert_no_regression`: a function that fails a worse run."""
    folder = request.config.getoption("--pjpdaf-baseline")
    update = bool(request.config.getoption("--pjpdaf-update-baseline"))

    def check(run: BenchRun, margins: Mapping[str, float] | None = None) -> Verdict:
        with own_packages():
            return verdict_on(run, margins)

    def verdict_on(run: BenchRun, margins: Mapping[str, float] | None) -> Verdict:
        from pjpdaf.errors import BenchError
        from reports.gate.gate import compare
        from reports.gate.markdown import markdown
        from reports.run.load import load
        from reports.run.save import save_slim

        if folder is None:
            pytest.fail("assert_no_regression needs --pjpdaf-baseline DIR", pytrace=False)
        place = Path(folder) / run.name
        try:
            if update:
                save_slim(run.saved, place, force=place.exists())
            elif not (place / "run.json").is_file():
                pytest.fail(
                    f"{place}: no baseline; make it with --pjpdaf-update-baseline", pytrace=False
                )
            verdict = compare(load(place), run.saved, margins)
        except BenchError as fault:
            pytest.fail(str(fault), pytrace=False)
        if verdict.verdict != "pass":
            pytest.fail(f"{place}: {verdict.verdict}\n\n{markdown(verdict)}", pytrace=False)
        return verdict

    return check
