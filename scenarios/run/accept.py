"""The verb `baseline accept`: a run becomes the baseline that later runs are compared with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.filesize import decimal

from pjpdaf.errors import BenchError, NotComparable
from reports.gate.gate import check_base, compare
from reports.gate.pairing import episode_values
from reports.gate.verdict import Verdict
from reports.run.load import SavedRun, load
from reports.run.save import save_slim
from reports.summary.text import count
from scenarios.console.lines import print_line
from scenarios.console.tables import print_table
from scenarios.run.compare import verdict_table

FOLDER = Path("baselines")


@dataclass(frozen=True)
class AcceptRequest:
    """Arguments of `baseline accept`. out: None: `baselines/` and the names of what was played."""

    run: Path
    out: Path | None = None


def accept_baseline(request: AcceptRequest) -> None:
    """Put the part of a run that `compare` needs in the place of the accepted baseline.

    What was there is replaced as a whole, and the differences are printed. Raises BenchError for a
    run that nothing could be compared with.
    """
    run = load(request.run)
    out = request.out or FOLDER / _name(run)
    if not run.meta["complete"]:
        raise BenchError(f"{run.folder}: was interrupted; play it to its end first")
    check_base(run, episode_values(run))
    before = _accepted(out)
    save_slim(run, out, force=before is not None)
    console = Console()
    if before is not None:
        _print_changes(console, before, run)
    size = sum(path.stat().st_size for path in out.iterdir())
    lines = [f"accepted: {out} ({_contents(run)}, {decimal(size)}); commit it", *_doubts(run)]
    for line in lines:
        print_line(line, console)


def _name(run: SavedRun) -> str:
    request = run.meta.get("request")
    targets = (request["targets"] or [request.get("dataset")]) if request else [run.folder.name]
    return "+".join(Path(str(target)).stem for target in targets)[:60]


def _accepted(out: Path) -> SavedRun | None:
    """The run that was accepted before, None where there is none. Raises BenchError."""
    if not out.exists() or (out.is_dir() and not any(out.iterdir())):
        return None
    return load(out)


def _print_changes(console: Console, before: SavedRun, run: SavedRun) -> None:
    try:
        verdict = compare(before, run)
    except NotComparable as reason:
        line = f"other episodes than before ({_contents(before)}): {reason}"
        print_line(line, console)
        return
    if not verdict.identical:
        print_table(verdict_table(verdict), console, wider=verdict_table(verdict, wide=True))
    print_line(_change(verdict), console)


def _change(verdict: Verdict) -> str:
    if verdict.identical:
        return "no change: all episodes gave the same results as those accepted before"
    worse = [m.metric.name for m in verdict.metrics if m.verdict == "fail"]
    better = [m.metric.name for m in verdict.metrics if m.better]
    parts = [f"worse: {', '.join(worse)}"] if worse else []
    parts += [f"better: {', '.join(better)}"] if better else []
    return "; ".join(parts) or "no metric is clearly better or worse than what was accepted before"


def _contents(run: SavedRun) -> str:
    scenarios = run.meta["scenarios"]
    episodes = sum(len(scenario["seeds"]) for scenario in scenarios)
    return f"{count(len(scenarios), 'scenario')}, {count(episodes, 'episode')}"


def _doubts(run: SavedRun) -> Iterator[str]:
    made = run.meta["provenance"]
    if made["dirty"]:
        commit = str(made["commit"] or "unknown")[:12]
        yield f"note: made by commit {commit} with changes that were not committed"
