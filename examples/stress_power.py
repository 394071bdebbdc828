"""What the search is worth: runs to the first swap against chance, shrinking, and equal results.

    python examples/stress_power.py swaps --family cross --preset default --campaigns 20
    python examples/stress_power.py shrink CASE.yaml...
    python examples/stress_power.py workers --family cross

swaps: so many campaigns with different seeds, each up to its first swap, and --random many with
random points, uniform over the same ranges, and nominal draws. shrink: runs, parameters left and
survival of each case. workers: the same search with 1 and with 4 workers, compared byte for byte.
Episodes are kept in --journal, so that a measurement that was stopped goes on.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scenarios.execute.journal import Journal
from scenarios.play.job import System
from scenarios.stress.campaign import CampaignRequest
from scenarios.stress.case import Case
from scenarios.stress.case_file import case_of, load_case, system_of
from scenarios.stress.families import find_family
from scenarios.stress.search.evaluation import Evaluator
from scenarios.stress.search.search import SearchPlan, search_family
from scenarios.stress.shrink import shrink
from scenarios.stress.space import Space
from scenarios.stress.trials import TrialRunner
from sim.processes import Answer
from sim.randomness import generator

CHUNK = 16


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


def first_at_random(space, evaluator, budget, seed, kind):
    """How many random points up to the first swap, None without any in the budget.

    kind: "uniform" over the ranges, or "nominal" draws.
    """
    rng = generator(seed, f"examples/stress_power/{kind}")
    draw = {
        "uniform": lambda: space.values_of_unit(rng.random(len(space.axes))),
        "nominal": lambda: space.values_of_latent(rng.normal(size=len(space.axes))),
    }[kind]
    for start in range(0, budget, CHUNK):
        count = min(CHUNK, budget - start)
        cases = [Case(space.family.name, draw(), int(rng.integers(2**31))) for _ in range(count)]
        for number, evaluation in enumerate(evaluator.evaluate(cases), start=start + 1):
            if evaluation.failures(("swap",)):
                return number
    return None


def swaps(arguments, runner):
    space = Space.of(find_family(arguments.family))
    system = System(arguments.preset, arguments.preset)
    evaluator = Evaluator(runner, system, "fast")
    for kind in ("search", "uniform", "nominal"):
        found = []
        started = time.process_time()
        for seed in range(arguments.campaigns if kind == "search" else arguments.random):
            if kind == "search":
                plan = SearchPlan(arguments.budget, ("swap",), seed, distinct=1)
                found.append(search_family(space, evaluator.evaluate, plan).first_failure())
            else:
                found.append(first_at_random(space, evaluator, arguments.budget, seed, kind))
            print(f"  {kind} seed {seed}: {found[-1]}", flush=True)
        numbers = [arguments.budget + 1 if n is None else n for n in found]
        hits = sum(n is not None for n in found)
        runs = sum(min(n, arguments.budget) for n in numbers)
        print(
            f"{arguments.family}, {arguments.preset}, {kind}: {hits} of {len(found)} campaigns of "
            f"{arguments.budget} runs find a swap; median run {np.median(numbers):g}; "
            f"{1e3 * hits / runs:.1f} a thousand runs; {time.process_time() - started:.0f} s CPU"
        )


def shrinks(arguments, runner):
    for path in arguments.cases:
        record = load_case(path)
        evaluator = Evaluator(runner, system_of(record), "fast")
        space = Space.of(find_family(record.family))
        done = shrink(space, case_of(record), record.event, evaluator.evaluate, arguments.fresh)
        left = ", ".join(done.needed) or "-"
        after = "" if done.minimal_survival is None else done.minimal_survival.text
        print(
            f"{record.name}: survives {done.survival.text}; {len(done.changed)} parameters -> "
            f"{len(done.needed)} ({left}) in {done.runs} runs; minimal fails again {after}",
            flush=True,
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
    parser.add_argument("what", choices=("swaps", "shrink", "workers"))
    parser.add_argument("cases", nargs="*", type=Path)
    parser.add_argument("--family", default="cross")
    parser.add_argument("--preset", default="default")
    parser.add_argument("--campaigns", type=int, default=20)
    parser.add_argument("--random", type=int, default=20, help="campaigns at random")
    parser.add_argument("--budget", type=int, default=500)
    parser.add_argument("--fresh", type=int, default=100)
    parser.add_argument("--journal", type=Path, default=Path("runs/stress-power"))
    arguments = parser.parse_args()
    if arguments.what == "workers":
        workers(arguments)
        return
    with Journal.open(arguments.journal, CampaignRequest("power", "").code()) as journal:
        runner = TrialRunner(Here(), journal)
        (swaps if arguments.what == "swaps" else shrinks)(arguments, runner)


if __name__ == "__main__":
    main()
