"""The lock of the shipped suites: digests of all that a version such as `core@1` plays.

`python -m scenarios.play.suite_lock` brings `suites/lock.json` up to date. A locked version never
changes: results that carry its name stay comparable.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from pjpdaf.errors import BenchError
from reports.run.schema import METRICS_VERSION
from scenarios.play.job import digest_of
from scenarios.play.targets import PlannedScenario, expand_suite
from scenarios.spec.names import load_suite, suite_names
from scenarios.spec.suite import Suite

COMMAND = "python -m scenarios.play.suite_lock"
FILE = "scenarios/suites/lock.json"
# How an episode without a result counts; part of what a suite's figures mean.
CRASH_POLICY = "worst"

Lock = Mapping[str, Mapping[str, Any]]


def suite_record(suite: Suite) -> dict[str, Any]:
    """The record of a suite in run.json and in the lock.

    Keys: name, version, digest; metrics_version; entries: label -> 'scenario@version xSEEDS
    digest', in order. The digest is of the entries' digests, the metrics and the crash policy.
    """
    entries = {planned.label: _entry_record(planned) for planned in expand_suite(suite)}
    whole = [list(entries.items()), METRICS_VERSION, CRASH_POLICY]
    return {
        "name": suite.name,
        "version": suite.version,
        "metrics_version": METRICS_VERSION,
        "digest": hashlib.sha256(json.dumps(whole).encode()).hexdigest(),
        "entries": entries,
    }


def _entry_record(planned: PlannedScenario) -> str:
    first = planned.first_seed
    digests = [digest_of(planned.job(seed)) for seed in range(first, first + planned.seeds)]
    digest = hashlib.sha256("\n".join(digests).encode()).hexdigest()
    return f"{planned.scenario.name}@{planned.scenario.version} x{planned.seeds} {digest}"


def shipped_records() -> dict[str, dict[str, Any]]:
    """name@version -> record, of all shipped suites."""
    records = [suite_record(load_suite(name)) for name in suite_names()]
    return {f"{record['name']}@{record['version']}": record for record in records}


def read_lock() -> Lock:
    """The shipped lock; empty where there is none yet."""
    file = files("scenarios") / "suites" / "lock.json"
    lock: Lock = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    return lock


def faults(lock: Lock, records: Lock) -> list[str]:
    """The suites that differ from the lock: a line for each, with its remedy."""
    lines = []
    for name, now in records.items():
        locked = lock.get(name)
        if locked is None:
            lines.append(f"{name} is not locked: run `{COMMAND}` and commit {FILE}")
        elif locked["entries"] != now["entries"]:
            lines.append(_change_message(name, locked, now))
        elif locked["digest"] != now["digest"]:
            lines.append(
                f"{name} was locked with metrics version {locked['metrics_version']}, now it is "
                f"{now['metrics_version']}: run `{COMMAND}` and commit {FILE}"
            )
    return lines


def _change_message(name: str, locked: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    suite = name.partition("@")[0]
    before, after = locked["entries"], now["entries"]
    labels = [label for label in {**before, **after} if before.get(label) != after.get(label)]
    # The order of the entries is all that can differ else.
    changed = ", ".join(labels[:5]) + (", ..." if len(labels) > 5 else "") or "the order"
    kept = sorted(
        {
            str(after[label]).partition("@")[0]
            for label in labels
            if label in before
            and label in after
            and before[label].split()[0] == after[label].split()[0]
        }
    )
    raised = f"raise `version` of {', '.join(kept[:5])} in scenarios/catalog/, " if kept else ""
    return (
        f"{name} is locked, but has changed ({changed}): {raised}set "
        f"`version: {now['version'] + 1}` in scenarios/suites/{suite}.yaml, "
        f"run `{COMMAND}` and commit {FILE}"
    )


def updated_lock(lock: Lock, records: Lock, *, replace: bool = False) -> dict[str, Any]:
    """The lock with all suites of today; older versions stay.

    Raises BenchError where a locked version has changed, unless `replace`: for a version of which
    nobody has results yet.
    """
    changed = [
        name
        for name in records
        if name in lock and lock[name]["entries"] != records[name]["entries"]
    ]
    if changed and not replace:
        raise BenchError(_change_message(changed[0], lock[changed[0]], records[changed[0]]))
    return {name: dict(one) for name, one in sorted({**lock, **records}.items())}


def write_lock(folder: Path, *, replace: bool = False) -> Path:
    """Bring lock.json in the folder of the suites up to date. Raises BenchError."""
    path = folder / "lock.json"
    whole = updated_lock(read_lock(), shipped_records(), replace=replace)
    path.write_text(json.dumps(whole, indent=1) + "\n", encoding="utf-8")
    return path


def main(words: list[str] | None = None) -> int:
    """The command of this module; its exit code."""
    parser = argparse.ArgumentParser(prog=COMMAND, description="Lock the shipped suites.")
    parser.add_argument(
        "--replace",
        action="store_true",
        help="also locked versions that have changed: only where nobody has results of them",
    )
    replace = bool(parser.parse_args(words).replace)
    try:
        path = write_lock(Path(__file__).parents[1] / "suites", replace=replace)
    except BenchError as fault:
        sys.stderr.write(f"{fault}; or, if nobody has results of it, `{COMMAND} --replace`\n")
        return fault.exit_code
    sys.stdout.write(f"locked: {path}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
