"""The line of `scenarios validate`: a file is sound, and its script can be played."""

from __future__ import annotations

from pathlib import Path

from reports.summary.text import count
from scenarios.spec.draw import fault_of_draw, perform
from scenarios.spec.loader import load_scenario_file
from scenarios.spec.motion.script import ScriptMotion
from scenarios.spec.scenario import Scenario
from sim.contact.contact import Unposable
from sim.motion.motion import performer_of

SEED = 0


def validated(file: Path) -> str:
    """What is said of a sound file. Raises BenchError with the place of its first fault.

    A script must have a draw of seed 0 that a person can perform.
    """
    scenario = load_scenario_file(file)
    told = f"{file}: ok ({scenario.name}, {count(len(scenario.parameters), 'parameter')}"
    if isinstance(scenario.motion, ScriptMotion):
        told += f"; {_script_told(scenario, scenario.motion)}"
    return f"{told})"


def _script_told(scenario: Scenario, motion: ScriptMotion) -> str:
    try:
        performance = perform(scenario, SEED)
    except Unposable as fault:
        # The first draw's reason begins with the place in the file.
        raise Unposable(fault_of_draw(scenario, SEED) or str(fault)) from None
    over_s = max(step.to_s for step in performer_of(performance.script).plan.steps)
    length_s = performance.frames / performance.fps
    told = f"{count(len(motion.steps), 'step')}, over at {over_s:.1f} s of {length_s:.1f} s"
    return told if over_s <= length_s else f"{told}: the end is cut off"
