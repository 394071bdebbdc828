"""Compare `fast` with rendered episodes, case by case.

python examples/fast_agreement.py [--seeds N] [--first-seed S] [--preset P] [SCENARIO ...]

Plays each case rendered and painted, prints who fails where, and writes the agreement of each
scenario to scenarios/play/fast_trust.json.
"""

from __future__ import annotations

import argparse
import json
from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from reports.score.agreement import CaseAgreement, Confusion, case_agreement
from scenarios.play.fast import play_fast
from scenarios.play.fast_trust import FILE, FastTrust
from scenarios.play.plan import PlanRequest, plan
from scenarios.play.play import play

FAMILIES = (
    *("cross", "bounce", "merge_and_hold", "drink", "both_hands_to_head", "mirror", "parallel"),
    *("fast_finish", "one_view_occluder", "object_splits_hand", "roll_forearms", "recorded"),
    "natural_table",
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="*", default=FAMILIES)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--first-seed", type=int, default=8000)
    parser.add_argument("--preset", default="thesis")
    chosen = parser.parse_args()
    preset = chosen.preset
    request = PlanRequest(
        tuple(chosen.scenarios), chosen.seeds, chosen.first_seed, detector=preset, tracker=preset
    )
    cases = []
    for job in plan(request):
        full = play(job)
        cases.append(case_agreement(full, play_fast(job, full.redrawn)))
        print(job.name, job.seed, cases[-1].failed_a, cases[-1].failed_b, flush=True)
    print_table(preset, cases)
    write(preset, cases)


def by_scenario(cases: Sequence[CaseAgreement]) -> dict[str, list[CaseAgreement]]:
    groups = defaultdict(list)
    for case in cases:
        groups[case.scenario].append(case)
    return dict(sorted(groups.items()))


def print_table(preset: str, cases: Sequence[CaseAgreement]) -> None:
    print(f"{preset}: failures of the same cases, rendered (full) and painted (fast)")
    print("scenario              n  both full fast none agree  error [mm]   apart  trusted")
    print("                              only only            full   fast   [mm]")
    for name, group in by_scenario(cases).items():
        trust = trust_of(group)
        print(f"{name:20s} {_line(group)}  {'yes' if trust.trusted else 'no'}")
    print(f"{'all':20s} {_line(cases)}  kappa {Confusion.of(cases).kappa:.2f}")
    full, fast = (
        np.concatenate([getattr(c, n) for c in cases]) for n in ("errors_a_m", "errors_b_m")
    )
    known = np.isfinite(full) & np.isfinite(fast)
    r = np.corrcoef(np.log(full[known] + 1e-3), np.log(fast[known] + 1e-3))[0, 1]
    print(f"correlation of the logarithms of the targets' median errors: {r:.3f}")


def _line(cases: Sequence[CaseAgreement]) -> str:
    c = Confusion.of(cases)
    full, fast, apart = (
        1e3 * float(np.nanmedian([getattr(case, n) for case in cases]))
        for n in ("errors_a_m", "errors_b_m", "apart_m")
    )
    return (
        f"{c.cases:3d}  {c.both:4d} {c.only_a:4d} {c.only_b:4d} {c.none:4d}  {c.share:4.2f}"
        f" {full:6.0f} {fast:6.0f} {apart:6.0f}"
    )


def trust_of(cases: Sequence[CaseAgreement]) -> FastTrust:
    c = Confusion.of(cases)
    return FastTrust(c.cases, c.both, c.only_a, c.only_b)


def write(preset: str, cases: Sequence[CaseAgreement]) -> None:
    record = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {"systems": {}}
    measured = {name: vars(trust_of(group)) for name, group in by_scenario(cases).items()}
    record["systems"].setdefault(preset, {}).update(measured)
    FILE.write_text(json.dumps(record, indent=2, sort_keys=True) + "\n", encoding="utf-8")
    print(f"written: {FILE}")


if __name__ == "__main__":
    main()
