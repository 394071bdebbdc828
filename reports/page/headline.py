"""The verdict on a run in words, for the first screen of its page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from reports.page.run_entries import RunEntry, worst_entries
from reports.page.run_report import RunReport
from reports.summary.text import count, number, percent

MOST_NAMES = 3  # scenarios named in the sentence; more are counted

Outcome = Literal["good", "bad", "none"]


@dataclass(frozen=True)
class Headline:
    """What a run is about and how it went.

    run: its name; outcome: "bad" where an episode went wrong, "none" where there is no result;
    summary: that in a few words; played, quality, failed: a sentence each, failed "" where there is
    no result; worst: the worst of the episodes that went wrong.
    """

    run: str
    outcome: Outcome
    summary: str
    played: str
    quality: str
    failed: str
    worst: RunEntry | None


def headline(report: RunReport, entries: Sequence[RunEntry]) -> Headline:
    """The headline of a run. entries: its episodes with a result."""
    overall = report.summary.overall
    wrong = [entry for entry in entries if entry.went_wrong]
    outcome: Outcome = "bad" if wrong or overall.failed else "good"
    if overall.frames == 0:
        outcome = "none"
    return Headline(
        run=report.run.name,
        outcome=outcome,
        summary=_summary(len(wrong), len(entries), overall.failed),
        played=_played(report),
        quality="" if outcome == "none" else _quality(report),
        failed="" if outcome == "none" else _failed(report, wrong),
        worst=next(iter(worst_entries(entries)), None),
    )


def _summary(wrong: int, judged: int, failed: int) -> str:
    if not judged:
        return f"{count(failed, 'episode')}, none with a result" if failed else "No episode"
    texts = [f"{wrong} of {count(judged, 'episode')} went wrong"] if wrong else []
    texts += [f"{failed} without a result"] if failed else []
    return ", ".join(texts) or f"Nothing went wrong in {count(judged, 'episode')}"


def _played(report: RunReport) -> str:
    names = report.summary.scenarios
    meta = report.run.meta
    if not names:
        return "Nothing was played."
    what = _listed(names) if len(names) <= MOST_NAMES else count(len(names), "scenario")
    system = " and ".join(
        dict.fromkeys(str(meta[k]) for k in ("detector", "tracker") if meta.get(k))
    )
    frames = report.total.frames
    return (
        f"Played: {count(report.summary.overall.episodes, 'episode')} of {what}, "
        f"{count(frames, 'stereo frame')}{f', tracker {system}' if system else ''}."
    )


def _quality(report: RunReport) -> str:
    overall = report.summary.overall
    return (
        f"{percent(overall.within_100)} of the estimates are within 100 mm of the truth, "
        f"the median error is {number(overall.median_mm)} mm."
    )


def _failed(report: RunReport, wrong: Sequence[RunEntry]) -> str:
    """What went wrong, and in how many episodes. wrong: those that did."""
    overall = report.summary.overall
    far = sum(not entry.flags for entry in wrong)
    kinds = (("hands swapped", overall.swapped or 0), ("a target lost", overall.lost))
    if any(n for _, n in kinds):
        parts = [
            f"{words} in {n} of {overall.episodes}" if n else f"{words} in none"
            for words, n in kinds
        ]
    else:
        parts = ["no hands swapped, no target lost"]
    if overall.captured:
        parts.append(f"a target captured by another in {overall.captured} of {overall.episodes}")
    if far:
        many = f"{far} of {overall.episodes}" if far == len(wrong) else f"{far} more"
        parts.append(f"under 95 % of the estimates within 100 mm in {many}")
    text = "; ".join(parts)
    return f"{text[0].upper()}{text[1:]}."


def _listed(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
