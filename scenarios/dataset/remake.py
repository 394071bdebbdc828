"""Makes a sequence of a data set, or a frame of it, again from its recipe."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pjpdaf.errors import BenchError
from scenarios.console.folder import written_whole
from scenarios.dataset.sequence_plan import sequence_entry
from scenarios.dataset.sequence_task import library_versions, write_recipe
from scenarios.play.recipe import read_recipe
from sim import gl
from sim.dataset.files.reading import read_json
from sim.dataset.writer import write_frame
from sim.files import disk_faults
from sim.processes import WORKER_ENVIRONMENT
from sim.sequence import Simulation


def remake_sequence(path: Path, out: Path, frame: int | None = None) -> str:
    """Make a sequence, or a single frame of it, again in `out`; returns the message to print.

    The bytes are the same where OpenGL library and versions are; where these differ, the message
    names them. Raises BenchError, Unposable.
    """
    for name, value in WORKER_ENVIRONMENT.items():
        os.environ.setdefault(name, value)
    recipe = read_recipe(read_json(path), path.absolute().parent)
    frames = sequence_entry(0, recipe).frames
    if frame is not None and not 0 <= frame < frames:
        raise BenchError(f"--frame {frame}: the sequence has the frames 0 to {frames - 1}")
    gl.prepare()
    made_with = {"renderer": gl.describe(), "versions": library_versions()}
    with written_whole(out) as part, disk_faults(out, "the sequence"):
        if frame is None:
            write_recipe(replace(recipe, made_with=made_with), part)
        else:
            with Simulation(recipe.performance()) as simulation:
                write_frame(simulation, part, recipe.settings.labels, frame)
    message = f"{'sequence' if frame is None else f'frame {frame}'}: {out}"
    if recipe.made_with and recipe.made_with != made_with:
        changed = _differences(recipe.made_with, made_with)
        message += f"\nmade with {changed}: bytes may differ"
    return message


def _differences(then: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    if then.get("renderer") != now["renderer"]:
        return f"{now['renderer']}, once with {str(then.get('renderer'))[:100]}"
    old = then.get("versions")
    changed = [
        f"{name} {version}, once {old.get(name) if isinstance(old, Mapping) else None}"
        for name, version in now["versions"].items()
        if not isinstance(old, Mapping) or old.get(name) != version
    ]
    return "; ".join(changed)
