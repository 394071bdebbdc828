"""A verdict as Markdown for a forge."""

from __future__ import annotations

import re

from reports.gate.advice import advice_lines
from reports.gate.junit import clean
from reports.gate.metrics import REACH
from reports.gate.text import (
    cap_text,
    difference_text,
    interval_text,
    number,
    outcome_text,
    unit_text,
)
from reports.gate.verdict import Advice, EpisodeDifference, GroupDifference, MetricVerdict, Verdict
from reports.summary.text import count

MARKDOWN_LIMIT = 64_000  # bytes: forges drop longer summaries
SYMBOLS = {"pass": "✅", "fail": "❌", "inconclusive": "❔"}


def markdown(verdict: Verdict) -> str:
    """Summarise for a forge within MARKDOWN_LIMIT bytes.

    The verdict, a row per metric, the groups and episodes that got worse.
    """
    title = "identical" if verdict.identical else verdict.verdict
    share = f"{100 * (1 - verdict.alpha):.4g} %"
    lines = [
        f"## Tracking accuracy: {SYMBOLS[verdict.verdict]} {title}",
        "",
        f"{_code(verdict.new)} against {_code(verdict.base)}, "
        f"{count(verdict.episodes, 'paired episode')}.",
        "",
        f"| metric | base | new | difference ({share}) | margin | verdict |",
        "|---|---:|---:|---:|---:|---|",
        *(_metric_row(m) for m in verdict.metrics),
    ]
    if capped := [text for m in verdict.metrics if (text := cap_text(m))]:
        lines += ["", f"\\* {'; '.join(capped)}."]
    if verdict.advice is not None and verdict.verdict == "inconclusive":
        lines += _advice(verdict.advice)
    if verdict.left_out:
        lines += [
            "",
            f"Left out: {count(verdict.left_out, 'episode')} without a result in the base.",
        ]
    for note in verdict.notes:
        lines += ["", f"Note: {_code(note)}"]
    beyond = [g for g in verdict.groups if g.beyond]
    if beyond:
        lines += [
            "",
            "### Groups beyond a margin",
            "",
            "They show where to look; the verdict is that of all groups together.",
            "",
            "| group | metric | base | new | difference | episodes |",
            "|---|---|---:|---:|---:|---:|",
            *(_group_row(g) for g in beyond),
        ]
        if any(g.capped for g in beyond):
            lines += ["", f"\\* capped: an episode counts {REACH:g} default margins at most."]
    if verdict.worst:
        lines += [
            "",
            "### Episodes that got worse",
            "",
            "| scenario | seed | median error | new | play it again |",
            "|---|---:|---:|---|---|",
            *(_episode_row(e) for e in verdict.worst),
        ]
    return _within_limit(lines)


def _advice(advice: Advice) -> list[str]:
    """Why it is inconclusive, and the commands that would decide it."""
    lines = ["", *(f"{clean(line)[:2000]}  " for line in advice_lines(advice))]
    if advice.commands:
        lines += ["", "```sh", *(" ".join(clean(c).split("\n")) for c in advice.commands), "```"]
    return lines


def _within_limit(lines: list[str]) -> str:
    """Join as many lines as a forge takes."""
    cut = "\n(cut: too long)\n"
    text, size = "", 0
    for line in lines:
        size += len(line.encode()) + 1
        if size > MARKDOWN_LIMIT - len(cut):
            return text + cut
        text += line + "\n"
    return text


def _metric_row(judged: MetricVerdict) -> str:
    difference = f"{difference_text(judged)} ({interval_text(judged)})".replace("*", "\\*")
    return (
        f"| {judged.metric.name} | {number(judged.base)} | {number(judged.new)} | "
        f"{difference}{unit_text(judged.metric)} | {judged.metric.margin:g} | "
        f"{SYMBOLS[judged.verdict]} {outcome_text(judged)} |"
    )


def _group_row(difference: GroupDifference) -> str:
    unit, star = unit_text(difference.metric), "\\*" if difference.capped else ""
    return (
        f"| {_code(difference.group)} | {difference.metric.name} | {number(difference.base)}{unit} "
        f"| {number(difference.new)}{unit} | {number(difference.difference, '+')}{star}{unit} | "
        f"{difference.episodes} |"
    )


def _episode_row(episode: EpisodeDifference) -> str:
    least = "at least " if episode.capped else ""
    return (
        f"| {_code(episode.scenario)} | {episode.seed} | {least}{episode.error_mm:+.1f} mm | "
        f"{', '.join(episode.events) or '-'} | {_code(episode.replay) if episode.replay else '-'} |"
    )


def _code(text: str) -> str:
    """Quote text as Markdown code in a table's cell, without any mark-up."""
    plain = re.sub(r"\s+", " ", clean(text)).strip()[:1000].replace("|", "\\|")
    fence = "`" * (1 + max((len(run) for run in re.findall("`+", plain)), default=0))
    pad = " " if plain.startswith("`") or plain.endswith("`") or not plain else ""
    return f"{fence}{pad}{plain}{pad}{fence}"
