"""The verb `compare`: the gate's verdict on two saved runs, printed and written down."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from pjpdaf.errors import BenchError
from reports.gate.advice import advice_lines
from reports.gate.formats import badge_json, verdict_json
from reports.gate.gate import compare
from reports.gate.junit import junit_xml
from reports.gate.markdown import markdown
from reports.gate.text import (
    cap_text,
    difference_text,
    interval_text,
    number,
    outcome_text,
    verdict_sentence,
)
from reports.gate.verdict import MetricVerdict, Verdict
from reports.run.load import SavedRun, load
from reports.run.provenance import provenance
from reports.summary.plain_table import plain_table
from scenarios.console.interrupts import interrupts
from scenarios.console.lines import print_command, print_line
from scenarios.console.progress import progress
from scenarios.console.tables import print_table
from scenarios.run.margins import load_margins, read_margins
from sim.files import disk_faults, written_whole_file

EXIT_CODES = {"pass": 0, "fail": 1, "inconclusive": 3}
FILES = ("verdict.json", "junit.xml", "summary.md", "badge.json")
STYLES = {"pass": "green", "fail": "bold red", "inconclusive": "yellow"}


@dataclass(frozen=True)
class CompareRequest:
    """Arguments of `compare`; None: not given.

    Of an escalation: jobs, its worker processes; plug_ins, detectors and trackers that it may
    import.
    """

    base: Path
    new: Path
    margins_file: Path | None
    margins: tuple[str, ...]
    out: Path | None
    escalate: bool
    jobs: int | None
    argv: tuple[str, ...]
    plug_ins: tuple[str, ...] = ()


def compare_runs(request: CompareRequest) -> int:
    """Compare, print, write verdict.json, junit.xml, summary.md and badge.json; the exit code.

    Raises NotComparable, BenchError.
    """
    margins: dict[str, float] = {}
    if request.margins_file is not None:
        margins |= load_margins(request.margins_file)
    margins |= read_margins(request.margins)
    base, new = load(request.base), load(request.new)
    out = request.out or request.new
    if out.exists() and not out.is_dir():
        raise BenchError(f"{out}: is a file; give --out a folder.")
    refused = ""
    if request.escalate:
        verdict, refused = _escalated(base, new, margins, request, out / "reserve")
    else:
        verdict = compare(base, new, margins)
    write_verdict(verdict, out, request.argv)
    console = Console()
    print_table(verdict_table(verdict), console, wider=verdict_table(verdict, wide=True))
    for text in filter(None, map(cap_text, verdict.metrics)):
        print_line(f"* {text}", console)
    for note in verdict.notes:
        print_line(f"note: {note}", console)
    print_line(sentence(verdict), console, STYLES[verdict.verdict])
    if verdict.advice is not None and verdict.verdict == "inconclusive":
        advice = verdict.advice
        for line in advice_lines(advice):
            print_line(line, console)
        for command in advice.commands:
            print_command(f"  {command}", console)
    if len(new.frames) and not verdict.identical:
        words = ["pjpdaf-bench", "report", str(request.new), "--baseline", str(request.base)]
        print_command(f"to see where: {shlex.join(words)}", console)
    print_line(f"written: {', '.join(str(out / name) for name in FILES)}", console)
    if refused:
        sys.stderr.write(f"pjpdaf-bench: {refused}\n")
    return EXIT_CODES[verdict.verdict]


def _escalated(
    base: SavedRun,
    new: SavedRun,
    margins: Mapping[str, float],
    request: CompareRequest,
    folder: Path,
) -> tuple[Verdict, str]:
    """The verdict after as many reserve rounds as needed, and why they cannot be played here."""
    # Late: to play takes many imports that comparing does not need.
    from scenarios.execute.local import local_executor, worker_count
    from scenarios.play.job import Job
    from scenarios.run.escalate import LOOKS, ROUNDS, CannotEscalate, OnDone, escalate

    workers = worker_count(request.jobs)
    first = compare(base, new, margins, looks=LOOKS)
    if first.verdict != "inconclusive":
        return first, ""
    with (
        interrupts() as arrived,
        arrived.raising(),
        local_executor(workers) as executor,
        progress(running=executor.running_steps) as meter,
    ):

        def on_round(number: int, jobs: Sequence[Job]) -> OnDone:
            meter.begin(f"reserve {number + 1} of {len(ROUNDS)}", sum(job.frames for job in jobs))
            return lambda index, rows: meter.finish(jobs[index].frames)

        try:
            here = provenance()
            allowed = request.plug_ins
            return escalate(base, new, margins, executor, folder, on_round, here, allowed), ""
        except CannotEscalate as fault:
            return first, str(fault)


def write_verdict(verdict: Verdict, folder: Path, argv: tuple[str, ...] = ()) -> None:
    """All four files into a folder, made where it is not there. Raises BenchError."""
    texts: Mapping[str, str] = {
        "verdict.json": verdict_json(verdict, argv),
        "junit.xml": junit_xml(verdict),
        "summary.md": markdown(verdict),
        "badge.json": badge_json(verdict),
    }
    with disk_faults(folder, "the verdict"):
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            with written_whole_file(folder / name, "the verdict", replace=True) as part:
                part.write_text(text, encoding="utf-8")


def sentence(verdict: Verdict) -> str:
    """The outcome in one line, for the terminal."""
    return verdict_sentence(verdict, verdict.verdict, lambda metric: metric.name)


def verdict_table(verdict: Verdict, *, wide: bool = False) -> Table:
    """A row per metric, for the terminal; wide: with what each metric means."""
    table = plain_table(f"{verdict.new} against {verdict.base}")
    table.add_column("metric", no_wrap=True)
    share = f"{100 * (1 - verdict.alpha):.4g} %"
    for heading in ("base", "new", "difference", share, "margin"):
        table.add_column(heading, justify="right", no_wrap=True)
    for heading in ("verdict", *(("meaning",) if wide else ())):
        table.add_column(heading, no_wrap=True)
    for judged in verdict.metrics:
        outcome = Text(outcome_text(judged), style=STYLES[judged.verdict])
        meaning = (Text(judged.metric.meaning),) if wide else ()
        table.add_row(*_cells(judged), outcome, *meaning)
    return table


def _cells(judged: MetricVerdict) -> tuple[str, ...]:
    return (
        judged.metric.name,
        number(judged.base),
        number(judged.new),
        difference_text(judged),
        interval_text(judged),
        f"{judged.metric.margin:g}",
    )
