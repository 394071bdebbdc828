"""The ladder from clean to real: the same poses, each rung with one more effect of real cameras."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from pjpdaf.errors import BenchError
from scenarios.play.job import Job

# Values that each rung sets in addition to the rungs before it. The first removes all effects.
_CLEAN: Mapping[str, float] = {
    "noise_sd": 0.0,
    "shot_noise": 0.0,
    "jpeg_quality": 100.0,
    "exposure_time": 0.0,
    "exposure": 0.0,
    "white_balance": 6500.0,
    "flicker": 0.0,
    "lens_k1": 0.0,
    "lens_k2": 0.0,
    "skin_ita": 32.0,
    "light_temperature": 6500.0,
    "light_gain": 1.0,
}
STEPS: Mapping[str, Mapping[str, float]] = {
    "clean": _CLEAN,
    "noise": {"noise_sd": 4.0, "shot_noise": 4.0},
    "blur": {"exposure_time": 33.0},
    "lens": {"lens_k1": -0.15, "lens_k2": 0.03},
    "shift": {"skin_ita": -15.0, "light_temperature": 3800.0, "light_gain": 0.8},
}
RUNGS = tuple(STEPS)


def rungs_of(job: Job) -> dict[str, Job]:
    """The job at each rung, by the rung's name; motion, seeds and the poses in labels are the same.

    Pixel labels are the same bytes in clean, noise and blur, and in lens and shift. Raises
    BenchError where the job sets what the ladder sets.
    """
    taken = sorted(set(job.overrides) & set(_CLEAN))
    if taken:
        raise BenchError(f"{job.name}: the ladder sets {', '.join(taken)}; leave them out")
    rungs, changes = {}, dict[str, float]()
    for rung, step in STEPS.items():
        changes |= step
        overrides = {**job.overrides, **changes}
        rungs[rung] = replace(job, overrides=overrides, label=f"{job.name}+{rung}")
    return rungs
