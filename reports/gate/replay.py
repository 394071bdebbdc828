"""Commands that play episodes of a run again."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

from pjpdaf.presets.names import DEFAULT_PRESET


def replay_command(meta: Mapping[str, Any], name: str, seed: int) -> str:
    """The command that plays one episode of a run again, name being its name in the results.

    "" where run.json does not have the request. Paths are those of the command that made the run.
    """
    request = meta.get("request")
    if not request:
        return ""
    first = seed
    if not request.get("dataset"):
        # A suite may start the seeds of an entry elsewhere, and adds --first-seed to that.
        seeds = next((s["seeds"] for s in meta["scenarios"] if s["name"] == name), [seed])
        first = int(request["first_seed"]) + seed - int(seeds[0])
    command = ["pjpdaf-bench", "run", *targets_of(meta), "--only", name]
    command += ["--first-seed", str(first), "--seeds", "1", *system_options(meta)]
    return shlex.join(command)


def targets_of(meta: Mapping[str, Any]) -> list[str]:
    """The words of `run` that say what is played: scenarios and suites, or a data set."""
    request = meta["request"]
    dataset = request.get("dataset")
    return ["--from", str(dataset)] if dataset else [str(name) for name in request["targets"]]


def system_options(meta: Mapping[str, Any]) -> list[str]:
    """The options of `run` that name the system under test, from run.json."""
    command: list[str] = []
    preset, detections = str(meta["preset"]), meta["request"].get("detections")
    command += ["--preset", preset] if preset != DEFAULT_PRESET else []
    for part in ("detector", "tracker"):
        if part == "detector" and detections:
            command += ["--detections", str(detections)]
        elif meta[part] != preset:
            command += [f"--{part}", str(meta[part])]
    command += ["--lag", str(meta["lag_frames"])] if meta.get("lag_frames") else []
    for pair in meta["request"]["settings"]:
        command += ["--set", str(pair)]
    return command
