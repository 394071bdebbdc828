"""Commands that play episodes of a run again."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

from pjpdaf.presets.names import DEFAULT_PRESET


def replay_command(meta: Mapping[str, Any], name: str, seed: int) -> str:
    """The command that plays one episode of a run again, name being its name in the results.

    "" where run.json does not have the request.
    """
    request = meta.get("request")
    if not request:
        return ""
    command = ["pjpdaf-bench", "run", *request["targets"]]
    command += ["--only", name, "--first-seed", str(seed), "--seeds", "1"]
    command += system_options(meta)
    return shlex.join(command)


def system_options(meta: Mapping[str, Any]) -> list[str]:
    """The options of `run` that name the system under test, from run.json."""
    command: list[str] = []
    preset = str(meta["preset"])
    command += ["--preset", preset] if preset != DEFAULT_PRESET else []
    for part in ("detector", "tracker"):
        command += [f"--{part}", str(meta[part])] if meta[part] != preset else []
    command += ["--lag", str(meta["lag_frames"])] if meta.get("lag_frames") else []
    for pair in meta["request"]["settings"]:
        command += ["--set", str(pair)]
    return command
