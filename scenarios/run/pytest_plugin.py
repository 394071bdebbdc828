"""What the fixtures of the pytest plug-in (`pjpdaf.pytest_plugin`) do: play, and compare.

Their process is somebody's pytest, where `sim`, `reports` and `scenarios` may be packages of the
tests: every function that imports runs inside `own_packages`.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
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
    from scenarios.play.job import Job
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
        preset: str = DEFAULT_PRESET,
        tracker: str | None = None,
        detector: str | None = None,
        seeds: int | None = None,
        first_seed: int = 0,
        settings: Mapping[str, object] | None = None,
        dataset: str | Path | None = None,
        compared: bool = True,
    ) -> BenchRun:
        """Play scenarios or suites; the test fails where an episode gives no result.

        preset: gives tracker and detector where these are not named; tracker, detector: preset,
        entry point or module:factory. seeds: episodes of each scenario [the suite's own; 10], from
        first_seed on. settings: what `--set` changes, of a scenario, `tracker.NAME` or
        `detector.NAME`. dataset: folder of a data set whose sequences are played in place of
        scenarios. compared: whether `assert_no_regression` will compare it, in a test that asks for
        that fixture: then the baseline must be there before anything is played.
        """
        ...


Check = Callable[..., "Verdict"]


def player(request: pytest.FixtureRequest, tmp_path: Path) -> PlayRun:
    """The value of the fixture `pjpdaf_run`: a function that plays scenarios for a test."""
    stem = re.sub(r"[^A-Za-z0-9_.-]+", "_", request.node.name).strip("_.")[:80]
    baselines = _Baselines.of(request.config)
    asks = "assert_no_regression" in request.fixturenames and not baselines.update
    numbers = itertools.count(1)

    def play(
        *targets: str,
        preset: str = DEFAULT_PRESET,
        tracker: str | None = None,
        detector: str | None = None,
        seeds: int | None = None,
        first_seed: int = 0,
        settings: Mapping[str, object] | None = None,
        dataset: str | Path | None = None,
        compared: bool = True,
    ) -> BenchRun:
        number = next(numbers)
        name = stem if number == 1 else f"{stem}-{number}"
        with own_packages(), _faults_fail():
            from scenarios.play.plan import PlanRequest, plan

            wanted = PlanRequest(
                targets=targets,
                seeds=seeds,
                first_seed=first_seed,
                detector=detector or preset,
                tracker=tracker or preset,
                settings=tuple(f"{key}={value}" for key, value in (settings or {}).items()),
                dataset=None if dataset is None else Path(dataset),
                keep_pictures=True,
            )
            _allow_plug_ins(wanted)
            jobs = plan(wanted)
            if asks and compared:
                baselines.check(name, jobs)
            workers = request.config.getoption("--pjpdaf-jobs")
            saved, origin = _play_and_save(
                wanted, jobs, preset, workers, tmp_path / "pjpdaf" / name
            )
            run = BenchRun(name, saved)
            request.node.add_report_section("call", f"pjpdaf-bench {name}", _report(run, origin))
        return run

    return play


@contextmanager
def _faults_fail() -> Iterator[None]:
    """A fault of the user's fails the test, in one line."""
    from pjpdaf.errors import BenchError

    try:
        yield
    except BenchError as fault:
        pytest.fail(str(fault), pytrace=False)


def _allow_plug_ins(request: PlanRequest) -> None:
    from pjpdaf.plugins.loading import allow_plug_ins_from_here

    allow_plug_ins_from_here(request.detector, request.tracker)


def _play_and_save(
    request: PlanRequest, jobs: list[Job], preset: str, workers: int | None, folder: Path
) -> tuple[SavedRun, str]:
    """Play a plan and save it; the run, and where its pictures came from.

    Raises BenchError, also for a failed episode.
    """
    from scenarios.cache.report import origin_line
    from scenarios.cache.settings import cache_settings
    from scenarios.execute.episodes import play_all
    from scenarios.execute.local import local_executor, worker_count
    from scenarios.play.footage import is_plugged_motion
    from scenarios.run.finish import refuse_failures
    from scenarios.run.save_run import save_run

    with local_executor(worker_count(workers)) as executor:
        played = play_all(jobs, executor)
    if played.interrupted:
        raise KeyboardInterrupt
    refuse_failures(played)
    saved = save_run(request, jobs, played, folder, preset=preset)
    plugged = sum(is_plugged_motion(job) for job in jobs)
    return saved, "" if request.dataset else origin_line(played.rows, cache_settings(), plugged)


def _report(run: BenchRun, origin: str) -> str:
    """What pytest prints of a run whose test fails."""
    from reports.summary.text import count, number, percent

    figures = (
        f"{count(run.overall.episodes, 'episode')} of "
        f"{count(len(run.summary.scenarios), 'scenario')}: {percent(run.within_100)} of "
        f"target-frames within 100 mm, median error {number(run.median_error_mm)} mm, hands "
        f"swapped in {run.swapped}, a target lost in {run.lost}"
    )
    return "\n".join(filter(None, (figures, origin, f"run: {run.saved.folder}")))


@dataclass(frozen=True)
class _Baselines:
    """The folder of the baselines, None where none is named, and whether they are written."""

    folder: Path | None
    update: bool

    @staticmethod
    def of(config: pytest.Config) -> _Baselines:
        named = config.getoption("--pjpdaf-baseline")
        update = bool(config.getoption("--pjpdaf-update-baseline"))
        return _Baselines(None if named is None else Path(named), update)

    def place(self, name: str) -> Path:
        """The folder of a baseline. Raises BenchError where no folder is named."""
        from pjpdaf.errors import BenchError

        if self.folder is None:
            raise BenchError("assert_no_regression needs --pjpdaf-baseline DIR")
        return self.folder / name

    def existing(self, name: str) -> Path:
        """The folder of a baseline that is there. Raises BenchError."""
        from pjpdaf.errors import BenchError

        place = self.place(name)
        if not (place / "run.json").is_file():
            raise BenchError(f"{place}: no baseline; make it with --pjpdaf-update-baseline")
        return place

    def check(self, name: str, jobs: list[Job]) -> None:
        """Raise BenchError where the baseline is missing, or of other episodes than `jobs`."""
        from pjpdaf.errors import BenchError
        from reports.run.load import load
        from scenarios.play.job import digest_of

        place = self.existing(name)
        wanted = {(job.name, job.seed): digest_of(job) for job in jobs}
        if load(place).digests != wanted:
            raise BenchError(
                f"{place}: is the baseline of other scenarios, seeds or settings; make it again "
                "with --pjpdaf-update-baseline"
            )


def checker(request: pytest.FixtureRequest) -> Check:
    """The value of the fixture `assert_no_regression`: a function that fails a worse run."""
    baselines = _Baselines.of(request.config)

    def check(run: BenchRun, margins: Mapping[str, float] | None = None) -> Verdict:
        with own_packages(), _faults_fail():
            return verdict_on(run, margins)

    def verdict_on(run: BenchRun, margins: Mapping[str, float] | None) -> Verdict:
        from reports.gate.gate import compare
        from reports.gate.markdown import markdown
        from reports.run.load import load
        from reports.run.save import save_slim

        if baselines.update:
            place = baselines.place(run.name)
            save_slim(run.saved, place, force=place.exists())
        else:
            place = baselines.existing(run.name)
        verdict = compare(load(place), run.saved, margins)
        if verdict.verdict != "pass":
            pytest.fail(f"{place}: {verdict.verdict}\n\n{markdown(verdict)}", pytrace=False)
        return verdict

    return check
