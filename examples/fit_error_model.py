"""Fit the error model of `fast` to the real detectors on rendered pictures.

python examples/fit_error_model.py [--seeds N] [--first-seed S] [SCENARIO ...]

Plays each episode rendered and painted (without errors), compares the centres of single blobs with
the centroids of the visible skin, prints the residuals and writes sim/silhouettes/error_model.json.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import asdict, replace
from itertools import product

import numpy as np

from pjpdaf.targets import TARGETS
from reports.score.records import Episode
from scenarios.play.fast import play_fast
from scenarios.play.job import Job
from scenarios.play.plan import PlanRequest, plan
from scenarios.play.play import play
from sim.silhouettes.error_model import FILE, ErrorModel

FAMILIES = (
    *("cross", "bounce", "merge_and_hold", "drink", "both_hands_to_head", "mirror", "parallel"),
    *("fast_finish", "one_view_occluder", "object_splits_hand", "roll_forearms", "recorded"),
    "natural_table",
)
NEAR_PX = 12.0  # a blob farther from a target is not its
WHOLE = 0.97  # of a target's pixels, to be measured
NO_ERRORS = ErrorModel(own_px=0.0, shared_px=0.0)
Pair = tuple[Episode, Episode]  # rendered, painted
Residuals = dict[tuple[int, int, int], np.ndarray]  # frame, view, target -> (2,) px


def pairs_of(jobs: Iterable[Job]) -> list[Pair]:
    pairs = []
    for job in jobs:
        full = play(job)
        pairs.append((full, play_fast(job, full.redrawn, NO_ERRORS)))
        print(job.name, job.seed, flush=True)
    return pairs


def residuals(episode: Episode) -> Residuals:
    """Centres of single, whole blobs less the centroids of what is visible of their targets."""
    out = {}
    frames = enumerate(episode.frames)
    for (i, outcome), view, target in product(frames, (0, 1), range(len(TARGETS))):
        truth, seen = outcome.truth.views[view], outcome.detections[view]
        whole = truth.visible_fractions[target] >= WHOLE and not truth.merged[target].any()
        if whole and len(seen):
            offsets = seen.centres_px - truth.centroids_px[target]
            nearest = int(np.linalg.norm(offsets, axis=1).argmin())
            if np.linalg.norm(offsets[nearest]) < NEAR_PX:
                out[i, view, target] = offsets[nearest]
    return out


def noise(all_residuals: Iterable[Residuals]) -> tuple[float, float]:
    """White noise [px] of each view by itself, and of both together.

    Of differences from frame to frame, robust: what stays from frame to frame is no noise.
    """
    own, both = [], []
    for found in all_residuals:
        for frame, view, target in found:
            four = [(frame + i, v, target) for i in (0, 1) for v in (0, 1)]
            if view == 0 and all(key in found for key in four):
                now, now_right, then, then_right = (found[key] for key in four)
                own.append((now - now_right) - (then - then_right))
                both.append((now + now_right) - (then + then_right))
    # Each is a sum of four draws of the own noise, and of no or eight shares of the common noise.
    own_px = _deviation(own) / 2.0
    shared_px = max(_deviation(both) ** 2 / 4.0 - own_px**2, 0.0) ** 0.5 / 2.0**0.5
    return own_px, shared_px


def _deviation(values: list[np.ndarray]) -> float:
    return float(1.4826 * np.median(np.abs(np.array(values))))


def fitted(pairs: list[Pair]) -> ErrorModel:
    """What the real detector's noise has beyond that of painting."""
    real = noise([residuals(full) for full, _ in pairs])
    painted = noise([residuals(fast) for _, fast in pairs])
    left = [max(a * a - b * b, 0.0) ** 0.5 for a, b in zip(real, painted, strict=True)]
    print(f"noise [px], own and shared: real {real}, painted {painted}, fitted {left}")
    return ErrorModel(*(round(value, 3) for value in left))


def print_table(pairs: list[Pair]) -> None:
    """Residuals of painted against rendered blobs: centres, areas, numbers of blobs."""
    apart: dict[int, list[np.ndarray]] = defaultdict(list)
    ratios: dict[int, list[float]] = defaultdict(list)
    counts: Counter[tuple[int, int]] = Counter()
    for full, fast in pairs:
        real, painted = residuals(full), residuals(fast)
        for key in real.keys() & painted.keys():
            frame, view, target = key
            a, b = full.frames[frame].truth.views[view], fast.frames[frame].truth.views[view]
            moved = (real[key] + a.centroids_px[target]) - (painted[key] + b.centroids_px[target])
            apart[target].append(moved)
            ratios[target].append(b.visible_px[target] / a.visible_px[target])
        for one, other in zip(full.frames, fast.frames, strict=True):
            for view in (0, 1):
                counts[len(one.detections[view]), len(other.detections[view])] += 1
    print("target       n      centre, real less painted [px]           visible pixels,")
    print("                    median         deviation     root mean sq.  painted / real")
    for target, moved in sorted(apart.items()):
        e = np.array(moved)
        middle = np.median(e, axis=0)
        spread = 1.4826 * np.median(np.abs(e - middle), axis=0)
        rms = np.sqrt((e * e).mean(axis=0))
        ratio = np.array(ratios[target])
        print(
            f"{TARGETS[target]:10s} {len(e):5d}  {middle[0]:+5.2f} {middle[1]:+5.2f}   "
            f"{spread[0]:5.2f} {spread[1]:5.2f}   {rms[0]:5.2f} {rms[1]:5.2f}   "
            f"{np.median(ratio):5.3f} +- {ratio.std():.3f}"
        )
    total = sum(counts.values())
    same = sum(n for (a, b), n in counts.items() if a == b)
    print(f"number of blobs the same in {same} of {total} views ({same / total:.1%}); else:")
    for (a, b), n in counts.most_common():
        if a != b:
            print(f"  real {a}, painted {b}: {n}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="*", default=FAMILIES)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--first-seed", type=int, default=8000)
    chosen = parser.parse_args()
    request = PlanRequest(tuple(chosen.scenarios), chosen.seeds, chosen.first_seed)
    models = {}
    for preset in ("thesis", "default"):
        jobs = plan(replace(request, detector=preset, tracker=preset))
        models[preset] = report(preset, pairs_of(jobs))
    write(models)


def report(preset: str, pairs: list[Pair]) -> ErrorModel:
    print(f"{preset}: {len(pairs)} episodes")
    print_table(pairs)
    return fitted(pairs)


def write(models: dict[str, ErrorModel]) -> None:
    record = {"models": {name: asdict(model) for name, model in models.items()}}
    FILE.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")
    print(f"written: {FILE}")


if __name__ == "__main__":
    main()
