"""Scenarios whose motion is a script, from a few lines."""

from __future__ import annotations

from scenarios.spec.loader import parse
from scenarios.spec.scenario import Scenario

HEAD = """\
name: mine
group: script
family: mine
summary: Mine.
frames: {frames}
motion:
  kind: script
  objects:
    can: {{kind: can, at: [0.4, 0.0]}}
    screen: {{kind: box, at: [0.52, 0.12], size: [0.05, 0.18, 0.2]}}
  steps:
"""
FIRST_STEP = HEAD.count("\n") + 1  # its line


def script_text(steps, parameters="{}", frames=45):
    """YAML text of a script. steps: a line each; parameters: of the scenario, as YAML."""
    lines = "".join(f"    - {step}\n" for step in steps)
    return HEAD.format(frames=frames) + lines + f"parameters: {parameters}\n"


def script(*steps, parameters="{}", frames=45):
    """The scenario of such a text."""
    return parse(script_text(steps, parameters, frames), "mine.yaml", Scenario)
