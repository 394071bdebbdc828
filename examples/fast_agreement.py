"""Compare `fast` with rendered episodes, case by case: which fail, with what, by how much they err.

    python examples/fast_agreement.py agreement.csv --episodes 600 --jobs 4 [--minutes 60]
    python examples/fast_agreement.py agreement.csv --episodes 0 --write

Cases of every family, half of them nominal draws, half uniform over the ranges that a search uses.
Each is rendered once, played with every preset, and painted. A line for each case and preset is in
the table as soon as it is played: the same command goes on, and --episodes 0 only reads. --write
puts each family's agreement into scenarios/play/fast_trust.json.
"""

from __future__ import annotations

import argparse
import csv
import json
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from reports.score.agreement import CaseAgreement, Confusion, case_agreement
from reports.score.robustness import GOALS, measures_of
from scenarios.execute.code_digest import NO_TRIAL, code_digest
from scenarios.execute.local import local_executor
from scenarios.play.fast import play_fast
from scenarios.play.fast_trust import FILE, FastTrust
from scenarios.play.job import Job, System
from scenarios.play.play import play
from scenarios.spec.cameras import rig_of
from scenarios.spec.draw import concrete, fault_of_draw, in_si, unjudged
from scenarios.stress.estimate.probability import clopper_pearson
from scenarios.stress.families import FAMILIES, find_family
from scenarios.stress.space import Space
from sim.contact.contact import Unposable
from sim.motion.stage import Value
from sim.processes import Lost
from sim.randomness import generator

KINDS = ("nominal", "range")
PRESETS = ("thesis", "default")
MOST_DRAWS = 50  # of a point of the ranges, until a person can perform it
TIME_LIMIT_S = 600.0  # of a case
_NUMBERS = ("full", "fast", "apart")
COLUMNS = (
    *("code", "preset", "family", "kind", "number", "seed", "values", "fails_full", "fails_fast"),
    *(f"{name}_{target}_mm" for name in _NUMBERS for target in TARGETS),
)
Row = dict[str, Any]


@dataclass(frozen=True)
class Task:
    """A case to compare: the family's draw of a kind by its number; frames: at most so many."""

    family: str
    kind: str
    number: int
    frames: int
    first_seed: int
    presets: tuple[str, ...]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", type=Path, help="CSV; what it has is not played again")
    parser.add_argument("--episodes", type=int, default=600, help="cases in all")
    parser.add_argument("--families", default=",".join(FAMILIES))
    parser.add_argument("--presets", default=",".join(PRESETS))
    parser.add_argument("--frames", type=int, default=48, help="of a case, at most")
    parser.add_argument("--first-seed", type=int, default=11000)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=1e6, help="no new case after these")
    parser.add_argument("--write", action="store_true")
    chosen = parser.parse_args()
    code = code_digest(NO_TRIAL)[:12]
    tasks = tasks_of(chosen)
    rows = read(chosen.table, code)
    played = {(row["family"], row["kind"], int(row["number"])) for row in rows}
    left = [t for t in tasks if (t.family, t.kind, t.number) not in played]
    if left:
        rows += play_all(left, code, chosen)
    for preset in dict.fromkeys(row["preset"] for row in rows):
        mine = [row for row in rows if row["preset"] == preset]
        print_tables(preset, mine)
        if chosen.write:
            write_trust(preset, mine)


def tasks_of(chosen: argparse.Namespace) -> list[Task]:
    """Cases in turn of every family and kind: a part of them is a fair sample too."""
    families, presets = chosen.families.split(","), tuple(chosen.presets.split(","))
    numbers = range(-(-chosen.episodes // (len(families) * len(KINDS))))
    tasks = [
        Task(family, kind, number, chosen.frames, chosen.first_seed, presets)
        for number in numbers
        for kind in KINDS
        for family in families
    ]
    return tasks[: chosen.episodes]


def play_all(tasks: Sequence[Task], code: str, chosen: argparse.Namespace) -> list[Row]:
    rows: list[Row] = []
    started, lost = time.monotonic(), 0
    is_new = not chosen.table.exists()
    with chosen.table.open("a", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS)
        if is_new:
            table.writeheader()
        with local_executor(chosen.jobs) as executor:
            for outcome in executor.outcomes(compared, dict(enumerate(tasks)), TIME_LIMIT_S):
                if outcome is not None and isinstance(outcome[1], Lost):
                    lost += 1
                elif outcome is not None:
                    made = [{"code": code, **row} for row in outcome[1].value]
                    table.writerows(made)
                    file.flush()
                    rows += made
                if time.monotonic() - started > 60 * chosen.minutes:
                    break
    print(f"{len(rows)} rows in {time.monotonic() - started:.0f} s, {lost} cases without a result")
    return rows


def compared(task: Task) -> list[Row]:
    """A row for each preset; none where no draw of the ranges can be performed."""
    values, seed = drawn(task)
    if values is None:
        return []
    rows = []
    for preset in task.presets:
        job = job_of(task, values, seed, System(preset, preset))
        full = play(job)
        case = case_agreement(full, play_fast(job, full.redrawn))
        numbers = (case.errors_a_m, case.errors_b_m, case.apart_m)
        row = {
            "preset": preset,
            "family": task.family,
            "kind": task.kind,
            "number": task.number,
            "seed": seed,
            "values": json.dumps(values),
            "fails_full": " ".join(case.failed_a),
            "fails_fast": " ".join(case.failed_b),
        }
        for name, of_targets in zip(_NUMBERS, numbers, strict=True):
            for target, length_m in zip(TARGETS, of_targets.tolist(), strict=True):
                row[f"{name}_{target}_mm"] = f"{1e3 * length_m:.1f}"
        rows.append(row)
    return rows


def drawn(task: Task) -> tuple[dict[str, Value] | None, int]:
    """Values and seed of a task; None where none of the draws can be performed."""
    seed = task.first_seed + task.number
    if task.kind == "nominal":
        return {}, seed
    space = Space.of(find_family(task.family))
    rng = generator(seed, f"examples/fast_agreement/{task.family}")
    for _ in range(MOST_DRAWS):
        values = space.values_of_unit(rng.random(len(space.axes)))
        if is_possible(job_of(task, values, seed, System())):
            return values, seed
    return None, seed


def is_possible(job: Job) -> bool:
    """Whether a person can perform it, and the cameras can film it."""
    try:
        rig_of(in_si(job.scenario, concrete(job.scenario, job.seed, job.overrides)))
        unjudged(job.scenario, job.seed, job.overrides)
    except (BenchError, Unposable):
        return False
    return fault_of_draw(job.scenario, job.seed, job.overrides) is None


def job_of(task: Task, values: Mapping[str, Value], seed: int, system: System) -> Job:
    scenario = find_family(task.family).scenario
    frames = float(min(scenario.frames, task.frames))
    return Job(scenario, seed, {**values, "frames": frames}, system, label=task.family)


def read(table: Path, code: str) -> list[Row]:
    """The rows of this code; a line that was cut off is none."""
    if not table.exists():
        return []
    with table.open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if None not in row.values()]
    mine = [row for row in rows if row["code"] == code]
    if len(mine) < len(rows):
        print(f"{len(rows) - len(mine)} rows of other code are left out")
    return mine


def cases_of(rows: Iterable[Row]) -> list[CaseAgreement]:
    cases = []
    for row in rows:
        full, fast, apart = (
            np.array([float(row[f"{name}_{target}_mm"]) / 1e3 for target in TARGETS])
            for name in _NUMBERS
        )
        fails = (tuple(row[f"fails_{way}"].split()) for way in ("full", "fast"))
        cases.append(CaseAgreement(row["family"], int(row["seed"]), *fails, full, fast, apart))
    return cases


def print_tables(preset: str, rows: Sequence[Row]) -> None:
    """Markdown: by family, by kind of draw, and by event."""
    by_family = defaultdict(list)
    for row in rows:
        by_family[row["family"]].append(row)
    print(f"\n`{preset}`, {len(rows)} episodes, code {rows[0]['code']}:\n")
    print(
        "| family | episodes | both fail | only rendered | only fast | neither | agree "
        "| error [mm] rendered | fast | apart [mm] | trusted |"
    )
    print("|---|" + "---|" * 10)
    for family, mine in sorted(by_family.items()):
        print(f"| {family} {_line(cases_of(mine))} {trust_word(trust_of(cases_of(mine)))} |")
    for kind in KINDS:
        if mine := [row for row in rows if row["kind"] == kind]:
            print(f"| all, {kind} draws {_line(cases_of(mine))} |")
    print(f"| **all** {_line(cases_of(rows))} |")
    cases = cases_of(rows)
    c = Confusion.of(cases)
    low, high = clopper_pearson(c.both + c.none, c.cases)
    print(f"\nAgree: {c.share:.1%} (95 %: {low:.1%} to {high:.1%}); kappa {c.kappa:.2f};", end=" ")
    print(f"correlation of the logarithms of the targets' median errors {_correlation(cases):.2f}.")
    print("\n| event | both | only rendered | only fast | neither | agree |")
    print("|---|---|---|---|---|---|")
    for goal in GOALS:
        names = set(measures_of((goal,)))
        seen = Counter((bool(names & {*c.failed_a}), bool(names & {*c.failed_b})) for c in cases)
        both, full, fast = seen[True, True], seen[True, False], seen[False, True]
        none = seen[False, False]
        share = (both + none) / len(cases)
        print(f"| {goal} | {both} | {full} | {fast} | {none} | {share:.2f} |")


def _correlation(cases: Sequence[CaseAgreement]) -> float:
    full, fast = (
        np.concatenate([getattr(c, n) for c in cases]) for n in ("errors_a_m", "errors_b_m")
    )
    known = np.isfinite(full) & np.isfinite(fast)
    return float(np.corrcoef(np.log(full[known] + 1e-3), np.log(fast[known] + 1e-3))[0, 1])


def _line(cases: Sequence[CaseAgreement]) -> str:
    c = Confusion.of(cases)
    full, fast, apart = (
        1e3 * float(np.nanmedian([getattr(case, n) for case in cases]))
        for n in ("errors_a_m", "errors_b_m", "apart_m")
    )
    return (
        f"| {c.cases} | {c.both} | {c.only_a} | {c.only_b} | {c.none} | {c.share:.2f} | "
        f"{full:.0f} | {fast:.0f} | {apart:.0f} |"
    )


def trust_of(cases: Sequence[CaseAgreement]) -> FastTrust:
    c = Confusion.of(cases)
    return FastTrust(c.cases, c.both, c.only_a, c.only_b)


def trust_word(trust: FastTrust) -> str:
    return "yes" if trust.trusted else "**no**"


def write_trust(preset: str, rows: Sequence[Row]) -> None:
    record = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {"systems": {}}
    groups = defaultdict(list)
    for case in cases_of(rows):
        groups[case.scenario].append(case)
    measured = {name: vars(trust_of(group)) for name, group in groups.items()}
    record["systems"].setdefault(preset, {}).update(measured)
    FILE.write_text(json.dumps(record, indent=2, sort_keys=True) + "\n", encoding="utf-8")
    print(f"written: {FILE}")


if __name__ == "__main__":
    main()
