"""A system under test, and a command, in words."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

from scenarios.play.job import System
from scenarios.spec.motion.plugged import TRUSTED_VARIABLE, is_code
from scenarios.stress.case import Case, Trial


def system_text(system: System) -> str:
    """Such as "thesis", "default with tracker mine:make", "thesis, tracker.gate=12"."""
    name = system.tracker
    if system.detector != system.tracker:
        name = f"{system.detector} with tracker {system.tracker}"
    changes = [f"detector.{k}={v}" for k, v in system.detector_settings.items()]
    changes += [f"tracker.{k}={v}" for k, v in system.tracker_settings.items()]
    return ", ".join([name, *changes])


def command_text(argv: Sequence[str]) -> str:
    """The command line of these arguments; "" without any."""
    return f"pjpdaf-bench {shlex.join(argv)}" if argv else ""


def case_command(path: Path, case: Case, system: System) -> str:
    """The command that replays a case file; what a file alone does not start is named in it."""
    words = ["pjpdaf-bench", "stress", str(path), "replay"]
    for kind, name in (("tracker", system.tracker), ("detector", system.detector)):
        if is_code(name):
            words += [f"--{kind}", name]
    trusted = f"{TRUSTED_VARIABLE}={shlex.quote(case.family)} " if is_code(case.family) else ""
    return trusted + shlex.join(words)


def replay_command(trial: Trial) -> str:
    """The command that plays a trial again, in its own fidelity."""
    case, system = trial.case, trial.system
    words = ["pjpdaf-bench", "stress", case.family, "replay", "--seed", str(case.seed)]
    words += ["--tracker", system.tracker]
    if system.detector != system.tracker:
        words += ["--detector", system.detector]
    if trial.fidelity == "fast":
        words += ["--fidelity", "fast"]
    changes = {f"detector.{k}": v for k, v in system.detector_settings.items()}
    changes |= {f"tracker.{k}": v for k, v in system.tracker_settings.items()}
    for name, value in {**case.values, **changes}.items():
        words += ["--set", f"{name}={value}"]
    return shlex.join(words)
