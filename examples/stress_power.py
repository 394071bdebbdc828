"""What search and estimate are worth: runs to the first swap, error of p, shrinking, equal results.

    python examples/stress_power.py swaps --family bounce --preset thesis --rate 1e-3 --jobs 4
    python examples/stress_power.py estimates --family examples/stress/quick_clasp.yaml \\
        --preset thesis --goal lost --set beard=no --plain 100000 --budget 3000 --campaigns 24
    python examples/stress_power.py shrink CASE.yaml... --jobs 4
    python examples/stress_power.py workers --family cross

swaps: --plain points, uniform over the ranges, give the share that swaps; --campaigns searches with
different seeds go to their first swap. The ranges are drawn in towards nominal by --scale, or by
the scale at which about --rate of the points swap: it is looked for first, with other points.
What the person is (a beard, say) is drawn from each point's seed, unless it is set.
estimates: --plain nominal draws give p; --campaigns estimates of --budget runs each, with different
seeds, give their error, and whether their intervals cover it.
shrink: runs, parameters left, and how many of --fresh further noise seeds fail, of each case.
workers: the same search with 1 and with 4 workers, compared byte for byte. All in fast. Answers are
in the file --kept as soon as they are there: the same command goes on.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from reports.score.robustness import GOALS
from scenarios.execute.code_digest import NO_TRIAL, code_digest
from scenarios.execute.journal import Journal
from scenarios.execute.local import local_executor
from scenarios.play.job import System
from scenarios.stress.case import Case
from scenarios.stress.case_file import case_of, load_case, system_of
from scenarios.stress.estimate.estimate import estimate
from scenarios.stress.estimate.outcomes import noise_seeds, normal_draws
from scenarios.stress.estimate.probability import clopper_pearson
from scenarios.stress.estimate_verb import outcomes_of
from scenarios.stress.families import find_family
from scenarios.stress.search.evaluation import Evaluator
from scenarios.stress.search.search import SearchPlan, search_family
from scenarios.stress.shrink import shrink
from scenarios.stress.space import Space
from scenarios.stress.trials import TrialRunner
from sim.processes import Answer
from sim.randomness import generator

CHUNK = 50  # points of a task
DRAWS = 500  # nominal draws of a task
STEPS, LOOKED_AT = 6, 1000  # bisections of the scale, and points of each
FIRST_SEED = 100  # of the campaigns: sizes of the search were chosen on seeds from 0
TIME_LIMIT_S = 3600.0


@dataclass(frozen=True)
class Here:
    """An executor without processes of its own."""

    def outcomes(self, function, tasks, limit_s, attempts=1):
        for index, task in tasks.items():
            yield index, Answer(function(task))

    def renderer(self):
        return ""

    def close(self):
        pass


@dataclass(frozen=True)
class Task:
    """A part of a measurement. stream, number: of a chunk of points or a campaign."""

    family: str
    preset: str
    scale: float
    stream: str
    number: int
    budget: int = 0
    goal: str = "swap"
    held: tuple[str, ...] = ()

    @property
    def key(self):
        return json.dumps([str(value) for value in vars(self).values()])


class Kept:
    """Answers to tasks, played by a pool, in a file of lines as soon as they are there."""

    def __init__(self, path, jobs):
        self.path, self.jobs = path, jobs
        self.code = code_digest(NO_TRIAL)[:12]
        self.answers = {}
        if path.exists():
            for line in path.read_text().splitlines():
                code, key, answer = json.loads(line)
                if code == self.code:
                    self.answers[key] = answer

    def of(self, function, tasks):
        left = dict(enumerate(task for task in tasks if task.key not in self.answers))
        if left:
            with local_executor(self.jobs) as pool, self.path.open("a") as file:
                for outcome in pool.outcomes(function, left, TIME_LIMIT_S):
                    if outcome is not None:
                        key, answer = left[outcome[0]].key, outcome[1].value
                        self.answers[key] = answer
                        file.write(json.dumps([self.code, key, answer]) + "\n")
                        file.flush()
        return [self.answers[task.key] for task in tasks]


def space_of(family, scale, held=()):
    """The space of a family whose ranges are drawn in towards nominal. held: texts NAME=VALUE."""
    fixed = dict(text.split("=", 1) for text in held)
    whole = Space.of(find_family(family), fixed=fixed)
    nominal, ranges = whole.nominal(), {}
    for axis in whole.axes:
        if not axis.choices:
            middle = float(nominal[axis.name])
            ends = (middle + scale * (end - middle) for end in (axis.low, axis.high))
            ranges[axis.name] = tuple(axis.rounded(end) for end in ends)
    return Space.of(find_family(family), fixed=fixed, ranges=ranges)


def evaluated(task, then):
    """Call with the space and the evaluator of a task; nothing is kept of its episodes."""
    with (
        tempfile.TemporaryDirectory() as folder,
        Journal.open(Path(folder) / "journal", "power") as journal,
    ):
        system = System(task.preset, task.preset)
        evaluator = Evaluator(TrialRunner(Here(), journal), system, "fast")
        return then(space_of(task.family, task.scale, task.held), evaluator)


def swapping(task):
    """Numbers of the points of a chunk that swap."""

    def play(space, evaluator):
        rng = generator(task.number, f"examples/stress_power/{task.stream}")
        points = rng.random((CHUNK, len(space.axes)))
        seeds = rng.integers(2**31, size=CHUNK).tolist()
        cases = [
            Case(task.family, space.values_of_unit(point), seed)
            for point, seed in zip(points, seeds, strict=True)
        ]
        evaluations = evaluator.evaluate(cases)
        return [n for n, e in enumerate(evaluations) if e.failures(("swap",))]

    return evaluated(task, play)


def first_swap(task):
    """How many points a search evaluates up to its first swap; None without any."""

    def play(space, evaluator):
        plan = SearchPlan(task.budget, ("swap",), FIRST_SEED + task.number, distinct=1)
        return search_family(space, evaluator.evaluate, plan).first_failure()

    return evaluated(task, play)


def points_that_swap(arguments, kept, scale, stream, count):
    """Numbers of the points that swap, of `count` points."""
    chunks = [
        Task(arguments.family, arguments.preset, scale, stream, number, held=tuple(arguments.set))
        for number in range(-(-count // CHUNK))
    ]
    found = kept.of(swapping, chunks)
    return [CHUNK * number + n for number, of in enumerate(found) for n in of]


def scale_of_rate(arguments, kept):
    """The scale at which about the rate of the points swap, by bisection."""
    low, high, scale = 0.0, 1.0, 1.0
    for _ in range(STEPS):
        hits = len(points_that_swap(arguments, kept, scale, "scale", LOOKED_AT))
        print(f"  ranges drawn in to {scale:.3f}: {hits} of {LOOKED_AT} points swap", flush=True)
        low, high = (low, scale) if hits > arguments.rate * LOOKED_AT else (scale, high)
        if low == 1.0:
            break
        scale = round((low + high) / 2, 4)
    return scale


def swaps(arguments, kept):
    scale = arguments.scale if arguments.rate is None else scale_of_rate(arguments, kept)
    family, preset, budget = arguments.family, arguments.preset, arguments.budget
    hits = points_that_swap(arguments, kept, scale, "plain", arguments.plain)
    low, high = clopper_pearson(len(hits), arguments.plain)
    print(
        f"{family}, {preset}, ranges drawn in to {scale:g}: {len(hits)} of {arguments.plain} "
        f"points swap, p = {len(hits) / arguments.plain:.2e} ({low:.2e} to {high:.2e})",
        flush=True,
    )
    whole = arguments.plain // budget
    blocks = {hit // budget for hit in hits if hit // budget < whole}
    print(
        f"chance: {len(blocks)} of {whole} blocks of {budget} points hold one; "
        f"median run {np.log(2) * arguments.plain / max(len(hits), 1):.0f}",
        flush=True,
    )
    tasks = [
        Task(family, preset, scale, "search", number, budget, held=tuple(arguments.set))
        for number in range(arguments.campaigns)
    ]
    found = kept.of(first_swap, tasks)
    runs = [budget + 1 if n is None else n for n in found]
    print(
        f"search: {sum(n is not None for n in found)} of {len(found)} campaigns of {budget} runs "
        f"find a swap; median run {np.median(runs):g}; {found}"
    )


def playing(goal):
    """What plays draws and asks for a goal, with the space and the evaluator of a task."""

    def of(space, evaluator):
        def play(latents, seeds):
            target = space.family.target
            cases = [
                Case(target, space.values_of_latent(z), int(seed))
                for z, seed in zip(latents, seeds, strict=True)
            ]
            return outcomes_of([e.result for e in evaluator.evaluate(cases)], goal)

        return play

    return of


def failing_draws(task):
    """How many of a chunk of nominal draws fail, and how many count."""

    def count(space, evaluator):
        latents = normal_draws(task.number, task.stream, DRAWS, len(space.axes))
        outcomes = playing(task.goal)(space, evaluator)(
            latents, noise_seeds(task.number, task.stream, DRAWS)
        )
        failed = outcomes.failed & outcomes.counted
        return [int(failed.sum()), int(outcomes.counted.sum())]

    return evaluated(task, count)


def estimated(task):
    """p, its interval, its verdict and method, of one estimate."""

    def once(space, evaluator):
        play = playing(task.goal)(space, evaluator)
        seed = FIRST_SEED + task.number
        of = estimate(play, len(space.axes), task.budget, seed, stream="power/")[0]
        return [of.p, of.low, of.high, of.verdict, of.method, of.ess, of.largest_weight]

    return evaluated(task, once)


def estimates(arguments, kept):
    family, preset, goal = arguments.family, arguments.preset, arguments.goal
    chunks = [
        Task(family, preset, 1.0, "nominal", number, goal=goal, held=tuple(arguments.set))
        for number in range(-(-arguments.plain // DRAWS))
    ]
    failed, counts = np.sum(kept.of(failing_draws, chunks), axis=0).tolist()
    truth, (low, high) = failed / counts, clopper_pearson(failed, counts)
    print(
        f"{family}, {preset}, P({goal}): {failed} of {counts} plain draws, "
        f"p = {truth:.2e} ({low:.2e} to {high:.2e})",
        flush=True,
    )
    tasks = [
        Task(family, preset, 1.0, "estimate", number, arguments.budget, goal, tuple(arguments.set))
        for number in range(arguments.campaigns)
    ]
    found = kept.of(estimated, tasks)
    for of in found:
        print("  {:.2e} ({:.2e} to {:.2e}) {} {}, ess {:.0f}, largest weight {:.3f}".format(*of))
    p, low, high = np.array([of[:3] for of in found]).T
    # The plain draws have an error of their own: an interval may miss the truth by that.
    error = np.sqrt(np.mean((p / truth - 1.0) ** 2))
    covers = int(np.sum((low <= truth) & (truth <= high)))
    print(
        f"{len(found)} estimates of {arguments.budget} runs: relative RMSE {error:.3f} "
        f"(plain draws of as many: {np.sqrt((1 - truth) / truth / arguments.budget):.3f}; "
        f"that of p itself: {np.sqrt((1 - truth) / max(failed, 1)):.3f}); "
        f"{covers} of {len(found)} intervals cover p; "
        f"{sum(of[3] == 'inconclusive' for of in found)} inconclusive"
    )


@dataclass(frozen=True)
class ShrinkTask:
    """A case to shrink."""

    path: str
    fresh: int
    seed: int

    @property
    def key(self):
        return json.dumps(["shrink", self.path, str(self.fresh), str(self.seed)])


def shrunk(task):
    record = load_case(Path(task.path))
    with (
        tempfile.TemporaryDirectory() as folder,
        Journal.open(Path(folder) / "journal", "power") as journal,
    ):
        evaluator = Evaluator(TrialRunner(Here(), journal), system_of(record), "fast")
        case = case_of(record)
        space = Space.of(find_family(record.family), ["fps"] if "fps" in case.values else [])
        done = shrink(space, case, record.event, evaluator.evaluate, task.fresh, task.seed)
    after = done.minimal_survival
    return {
        "case": record.name,
        "event": record.event,
        "survives": done.survival.text,
        "parameters": len(done.changed),
        "left": list(done.needed),
        "runs": done.runs,
        "again": None if after is None else [after.failed, after.of],
    }


def shrinks(arguments, kept):
    tasks = [ShrinkTask(str(path), arguments.fresh, arguments.seed) for path in arguments.cases]
    print("| case | event | survives | parameters | left | runs | fresh seeds that fail |")
    print("|---|---|---|---|---|---|---|")
    for done in kept.of(shrunk, tasks):
        left = f"{len(done['left'])} ({', '.join(done['left']) or 'nominal'})"
        again = "-" if done["again"] is None else "{} of {}".format(*done["again"])
        left = "-" if done["again"] is None else left
        print(
            f"| {done['case']} | {done['event']} | {done['survives']} | {done['parameters']} | "
            f"{left} | {done['runs']} | {again} |"
        )


def workers(arguments):
    with tempfile.TemporaryDirectory() as folder:
        contents = []
        for jobs in ("1", "4"):
            out = Path(folder) / jobs
            words = ["stress", arguments.family, "search", "--preset", arguments.preset]
            words += ["--budget", str(arguments.budget), "--confirm", "0", "--jobs", jobs]
            words += ["--out", str(out)]
            subprocess.run([sys.executable, "-m", "scenarios", *words], check=True)
            contents.append((out / "search.json").read_bytes())
        equal = "the same bytes" if contents[0] == contents[1] else "DIFFERENT"
        print(f"1 and 4 workers: {equal} ({len(contents[0])} bytes)")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("swaps", "estimates", "shrink", "workers"))
    parser.add_argument("cases", nargs="*", type=Path)
    parser.add_argument("--family", default="cross")
    parser.add_argument("--preset", default="default")
    parser.add_argument("--set", action="append", default=[], help="NAME=VALUE that does not vary")
    parser.add_argument("--goal", choices=GOALS, default="swap", help="of the estimates")
    parser.add_argument("--campaigns", type=int, default=20)
    parser.add_argument("--plain", type=int, default=20_000, help="points at random")
    parser.add_argument("--scale", type=float, default=1.0, help="of the ranges, about nominal")
    parser.add_argument("--rate", type=float, help="of points that swap, which gives the scale")
    parser.add_argument("--budget", type=int, default=500)
    parser.add_argument("--fresh", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0, help="of the shrinking")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--kept", type=Path, default=Path("stress-power.jsonl"))
    arguments = parser.parse_args()
    if arguments.what == "workers":
        workers(arguments)
        return
    kept = Kept(arguments.kept, arguments.jobs)
    {"swaps": swaps, "estimates": estimates, "shrink": shrinks}[arguments.what](arguments, kept)


if __name__ == "__main__":
    main()
