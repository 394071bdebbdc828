"""Episodes detected once and tracked many times: what ablation.py and ceilings.py share."""

from __future__ import annotations

import itertools
import json
import multiprocessing
from argparse import ArgumentParser
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from pjpdaf.follow import follow
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND
from reports.gate.statistics import clustered_bootstrap
from reports.score.events import find_events
from reports.score.records import Episode, FrameOutcome
from scenarios.play.footage import Footage, open_footage
from scenarios.play.job import Job, System
from scenarios.play.oracle import Oracle, track_again
from scenarios.play.plan import PlanRequest, plan
from scenarios.play.play import make_system
from sim.randomness import generator

WITHIN_M = 0.1
NO_ORACLE = Oracle()
Seen = list[tuple[Detections, ...]]


@dataclass(frozen=True)
class Variant:
    """A system and an oracle under a name of their own; groups: where it is tried, () everywhere.

    Systems of one detector share its detections, which are those that the first of them led to.
    """

    name: str
    system: System
    oracle: Oracle = NO_ORACLE
    groups: tuple[str, ...] = ()


@dataclass(frozen=True)
class Result:
    """What a variant makes of an episode; head_mm, hands_mm: median errors."""

    variant: str
    scenario: str
    group: str
    seed: int
    target_frames: int
    within: int
    head_mm: float
    hands_mm: float
    swapped: bool
    lost: bool

    @property
    def share(self) -> float:
        """Share of target-frames within 100 mm."""
        return self.within / self.target_frames


def detector_key(system: System) -> str:
    """The detector of a system and its parameters, as text."""
    return f"{system.detector} {json.dumps(dict(system.detector_settings), sort_keys=True)}"


def watch(
    job: Job, footage: Footage, systems: Iterable[System], most_frames: int | None
) -> tuple[Episode, dict[str, Seen]]:
    """Show the frames, the first most_frames of them, to the detector of each system once.

    Returns the episode without estimates, and by `detector_key` the detections with their looks.
    """
    first = {detector_key(system): system for system in reversed(list(systems))}
    background = footage.background()
    tees = itertools.tee(itertools.islice(footage.frames(), most_frames), len(first) + 1)
    steps = []
    for system, frames in zip(first.values(), tees[1:], strict=True):
        detector, tracker = make_system(system, footage.calibration)
        steps.append(follow((frame for frame, _ in frames), detector.learn(background), tracker))
    seen: dict[str, Seen] = {key: [] for key in first}
    truths = []
    for (_, truth), *frame_steps in zip(tees[0], *steps, strict=True):  # one frame at a time
        truths.append(truth)
        for key, step in zip(first, frame_steps, strict=True):
            seen[key].append(tuple(replace(view, mask=None) for view in step.detections))
    nothing = (Detections.none(), Detections.none())
    frames = tuple(FrameOutcome(truth, Estimates.waiting(), nothing) for truth in truths)
    group = job.scenario.group
    cameras = footage.rig.cameras
    return Episode(job.name, group, job.seed, footage.fps, cameras, frames), seen


def results(
    job: Job, footage: Footage, variants: Sequence[Variant], most_frames: int | None = None
) -> list[Result]:
    """Try the variants on one episode, on its first most_frames."""
    mine = [v for v in variants if not v.groups or job.scenario.group in v.groups]
    episode, seen = watch(job, footage, [v.system for v in mine], most_frames)
    cameras = footage.calibration.cameras
    found = []
    for variant in mine:
        _, tracker = make_system(variant.system, footage.calibration)
        detections = seen[detector_key(variant.system)]
        tracked = track_again(episode, cameras, tracker, variant.oracle, detections)
        found.append(scored(variant.name, tracked))
    return found


def scored(name: str, episode: Episode) -> Result:
    """Score an episode of a variant."""
    centres = np.stack([outcome.truth.centres_m for outcome in episode.frames])
    estimates = np.stack([outcome.estimates.positions_m for outcome in episode.frames])
    errors = np.nan_to_num(np.linalg.norm(estimates - centres, axis=2), nan=np.inf)
    kinds = {event.kind for event in find_events(episode)}
    return Result(
        name,
        episode.scenario,
        episode.group,
        episode.seed,
        errors.size,
        int((errors < WITHIN_M).sum()),
        1e3 * float(np.median(errors[:, HEAD])),
        1e3 * float(np.median(errors[:, [RIGHT_HAND, LEFT_HAND]])),
        "swap" in kinds,
        "lost" in kinds,
    )


def _results_of(job: Job, variants: Sequence[Variant], most_frames: int | None) -> list[Result]:
    with open_footage(job) as footage:
        return results(job, footage, variants, most_frames)


def all_results(
    jobs: Sequence[Job],
    variants: Sequence[Variant],
    most_frames: int | None,
    workers: int,
    out: Path | None,
) -> list[Result]:
    """Results of all episodes; kept in a file as they come, those in it already are not repeated.

    out: JSON lines. Delete the file where detector, tracker or most_frames have changed since.
    """
    known = read(out) if out is not None and out.exists() else []
    done = {(r.scenario, r.seed) for r in known}
    left = [job for job in jobs if (job.name, job.seed) not in done]
    context = multiprocessing.get_context("spawn")
    same = itertools.repeat(variants), itertools.repeat(most_frames)
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        for job, new in zip(left, pool.map(_results_of, left, *same), strict=True):
            print(f"{job.name} seed {job.seed}", flush=True)
            known += new
            if out is not None:
                write(out, new)
    return known


def read(path: Path) -> list[Result]:
    """Read results from JSON lines."""
    return [Result(**json.loads(line)) for line in path.read_text().splitlines()]


def write(path: Path, new: Iterable[Result]) -> None:
    """Add results to a file of JSON lines."""
    with path.open("a") as file:
        file.writelines(json.dumps(asdict(result)) + "\n" for result in new)


def interval(values: Sequence[float], of: Sequence[Result]) -> tuple[float, float, float]:
    """Mean and 95 % interval of a value an episode, resampled within the scenarios."""
    draws = [(result.scenario, result.seed) for result in of]
    strata = [result.scenario for result in of]
    found = clustered_bootstrap(
        np.array(values), draws, strata, generator(0, "examples: interval"), resamples=2000
    )
    return found.mean, found.low, found.high


def by_group(found: Iterable[Result]) -> Iterator[tuple[str, list[Result]]]:
    """The groups in order, then all together."""
    every = list(found)
    for group in dict.fromkeys(result.group for result in every):
        yield group.replace("_", " "), [result for result in every if result.group == group]
    yield "all", every


def outcome(found: Sequence[Result]) -> str:
    """Medians of head / hands, episodes swapped, lost: "13.1 / 12.9, 1, 2"."""
    swapped, lost = sum(r.swapped for r in found), sum(r.lost for r in found)
    head, hands = (
        float(np.median(v)) for v in zip(*((r.head_mm, r.hands_mm) for r in found), strict=True)
    )
    return f"{head:.1f} / {hands:.1f}, {swapped}, {lost}"


def share(found: Sequence[Result]) -> str:
    """Mean share within 100 mm with its interval, in per cent; no interval of one episode."""
    mean, low, high = interval([r.share for r in found], found)
    if len(found) == 1:
        return f"{100 * mean:.1f}"
    return f"{100 * mean:.1f} ({100 * max(low, 0.0):.1f}-{100 * min(high, 1.0):.1f})"


def change(found: Sequence[Result], base: Mapping[tuple[str, int], Result]) -> str:
    """Paired difference of the share from a base, in points; bold where it is not 0 for certain."""
    differences = [r.share - base[r.scenario, r.seed].share for r in found]
    mean, low, high = (100 * value for value in interval(differences, found))
    if len(found) == 1 or not any(differences):
        return f"{mean:+.1f}"
    text = f"{mean:+.1f} ({low:+.1f} to {high:+.1f})"
    return f"**{text}**" if low > 0 or high < 0 else text


def main(
    variants: Mapping[str, Sequence[Variant]],
    show: Callable[[list[Result]], None],
    purpose: str,
) -> None:
    """Read the command line, try the variants, print their tables.

    variants: by the name of their set; `all` is the default.
    """
    parser = ArgumentParser(description=purpose)
    parser.add_argument("--variants", choices=sorted(variants), default="all")
    parser.add_argument("--groups", nargs="+", default=[], help="groups of scenarios, e.g. fast")
    parser.add_argument("targets", nargs="*", default=[], help="scenarios or suites to render")
    parser.add_argument("--from", dest="dataset", type=Path, help="a data set to read instead")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--frames", type=int, help="at most so many of an episode, its first")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--out", type=Path, help="JSON lines; goes on with it if it is there")
    given = parser.parse_args()
    request = PlanRequest(
        targets=() if given.dataset else tuple(given.targets) or ("core",),
        seeds=None if given.dataset else given.seeds,
        first_seed=given.first_seed,
        dataset=given.dataset,
    )
    jobs = [j for j in plan(request) if not given.groups or j.scenario.group in given.groups]
    tried = variants[given.variants]
    show(all_results(jobs, tried, given.frames, given.jobs, given.out))
