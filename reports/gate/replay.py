"""Commands that play episodes of a run again."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any


def replay_command(meta: Mapping[str, Any], name: str, seed: int) -> str:
    """The command that plays one episode of a run again, name being its name in the results.

    "" where run.json does not have the request.
    """
    request = meta.get("request")
    if not request:
        return ""
    words = ["pjpdaf-bench", "run", *request["targets"]]
    words += ["--only", name, "--first-seed", str(seed), "--seeds", "1"]
    words += system_options(meta)
    return shlex.join(words)


def system_options(meta: Mapping[str, Any]) -> list[str]:
    """The options of `run` that name the system under test, from run.json."""
    words: list[str] = []
    preset = str(meta["preset"])
    words += ["--preset", preset] if preset != "thesis" else []
    for part in ("detector", "tracker"):
        words += [f"--{part}", str(meta[part])] if meta[part] != preset else []
    for pair in meta["request"]["settings"]:
        words += ["--set", str(pair)]
    return words
