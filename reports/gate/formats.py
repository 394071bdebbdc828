"""A verdict in the forms that other tools read: JSON, JUnit XML, Markdown, a badge."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any
from xml.etree import ElementTree

from reports.gate.gate import EpisodeDifference, GroupDifference, Metric, MetricVerdict, Verdict
from reports.run.provenance import provenance

VERDICT_SCHEMA = 1
MARKDOWN_LIMIT = 64_000  # bytes: forges drop longer summaries
SYMBOLS = {"pass": "✅", "fail": "❌", "inconclusive": "❔"}
COLOURS = {"pass": "brightgreen", "fail": "red", "inconclusive": "yellow"}
_UNPRINTABLE = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def verdict_json(verdict: Verdict, argv: tuple[str, ...] = ()) -> str:
    """The verdict with all its figures and where it comes from; an open interval's end is null."""
    record: dict[str, Any] = {
        "kind": "pjpdaf-bench verdict",
        "schema_version": VERDICT_SCHEMA,
        **_plain(asdict(verdict)),
        "provenance": provenance(argv),
    }
    return json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    """JSON has no infinite numbers."""
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def badge_json(verdict: Verdict) -> str:
    """The end point format of shields: schemaVersion, label, message, colour."""
    message = "identical" if verdict.identical else verdict.verdict
    badge = {
        "schemaVersion": 1,
        "label": "tracking accuracy",
        "message": message,
        "color": COLOURS[verdict.verdict],
    }
    return json.dumps(badge) + "\n"


def junit_xml(verdict: Verdict) -> str:
    """JUnit XML: a suite per group of scenarios, a case per metric.

    A case fails where the metric fails and this group is beyond its margin; an inconclusive one is
    skipped, with the reason. Times are 0: nothing is played here. What Jenkins' xUnit plug-in
    (its junit-10 schema) and GitLab read; hence no `skipped` on `testsuites`, and the reason as
    text, since GitLab shows nothing else.
    """
    cases: dict[str, list[GroupDifference]] = {}
    for difference in verdict.groups:
        cases.setdefault(difference.group, []).append(difference)
    whole = _counts(verdict.groups)
    del whole["skipped"]
    root = ElementTree.Element("testsuites", {"name": "pjpdaf-bench", **whole, "time": "0"})
    for group, differences in cases.items():
        name = _clean(group)
        counts = _counts(differences)
        suite = ElementTree.SubElement(root, "testsuite", {"name": name, **counts, "time": "0"})
        properties = ElementTree.SubElement(suite, "properties")
        for key, value in (("base", verdict.base), ("new", verdict.new)):
            ElementTree.SubElement(properties, "property", {"name": key, "value": _clean(value)})
        for difference in differences:
            case = ElementTree.SubElement(
                suite,
                "testcase",
                {
                    "classname": f"pjpdaf_bench.{name}",
                    "name": difference.metric.name,
                    "time": "0",
                },
            )
            if difference.verdict != "pass":
                said = _sentence(difference)
                kind = "failure" if difference.verdict == "fail" else "skipped"
                part = ElementTree.SubElement(
                    case, kind, {"type": difference.verdict, "message": said}
                )
                part.text = said
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, "unicode") + "\n"


def markdown(verdict: Verdict) -> str:
    """A summary for a forge, at most MARKDOWN_LIMIT bytes.

    The verdict, a row per metric, the groups and episodes that got worse.
    """
    title = "identical" if verdict.identical else verdict.verdict
    share = f"{100 * (1 - verdict.alpha):.4g} %"
    lines = [
        f"## Tracking accuracy: {SYMBOLS[verdict.verdict]} {title}",
        "",
        f"{_code(verdict.new)} against {_code(verdict.base)}, {verdict.episodes} paired episodes.",
        "",
        f"| metric | base | new | difference ({share}) | margin | verdict |",
        "|---|---:|---:|---:|---:|---|",
        *(_metric_row(m) for m in verdict.metrics),
    ]
    if verdict.left_out:
        lines += ["", f"Left out: {verdict.left_out} episodes without a result in the base."]
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


def _within_limit(lines: list[str]) -> str:
    """As many lines as a forge takes."""
    cut = "\n(cut: too long)\n"
    text, size = "", 0
    for line in lines:
        size += len(line.encode()) + 1
        if size > MARKDOWN_LIMIT - len(cut):
            return text + cut
        text += line + "\n"
    return text


def _counts(differences: Sequence[GroupDifference]) -> dict[str, str]:
    words = [d.verdict for d in differences]
    return {
        "tests": str(len(words)),
        "failures": str(words.count("fail")),
        "errors": "0",
        "skipped": str(words.count("inconclusive")),
    }


def _sentence(difference: GroupDifference) -> str:
    metric = difference.metric
    return (
        f"{metric.name} {difference.verdict}: {number(difference.difference, '+')}"
        f"{unit_of(metric)} an episode (margin {metric.margin:g}; {number(difference.base)} to "
        f"{number(difference.new)}) over {difference.episodes} episodes of "
        f"{_clean(difference.group)}"
    )


def _metric_row(judged: MetricVerdict) -> str:
    return (
        f"| {judged.metric.name} | {number(judged.base)} | {number(judged.new)} | "
        f"{number(judged.difference.mean, '+')} ({interval(judged)}){unit_of(judged.metric)} | "
        f"{judged.metric.margin:g} | {SYMBOLS[judged.verdict]} {word(judged)} |"
    )


def _group_row(difference: GroupDifference) -> str:
    unit = unit_of(difference.metric)
    return (
        f"| {_code(difference.group)} | {difference.metric.name} | {number(difference.base)}{unit} "
        f"| {number(difference.new)}{unit} | {number(difference.difference, '+')}{unit} | "
        f"{difference.episodes} |"
    )


def _episode_row(episode: EpisodeDifference) -> str:
    return (
        f"| {_code(episode.scenario)} | {episode.seed} | {episode.error_mm:+.1f} mm | "
        f"{', '.join(episode.events) or '-'} | {_code(episode.replay) if episode.replay else '-'} |"
    )


def word(judged: MetricVerdict) -> str:
    """The verdict of a metric in one word, or two."""
    return "pass (better)" if judged.better else judged.verdict


def interval(judged: MetricVerdict) -> str:
    """The interval of a metric's difference, without its unit."""
    d = judged.difference
    if not math.isfinite(d.low):
        return "unknown"
    return f"{number(d.low, '+')} to {number(d.high, '+')}"


def unit_of(metric: Metric) -> str:
    """What stands behind a number of this metric."""
    return "" if metric.unit == "1" else f" {metric.unit}"


def number(value: float, sign: str = "") -> str:
    """Three digits."""
    return f"{value:{sign}.3g}" if value else "0"


def _code(text: str) -> str:
    """Text as Markdown code in a table's cell: nothing in it means anything."""
    plain = re.sub(r"\s+", " ", _clean(text)).strip()[:1000].replace("|", "\\|")
    fence = "`" * (1 + max((len(run) for run in re.findall("`+", plain)), default=0))
    pad = " " if plain.startswith("`") or plain.endswith("`") or not plain else ""
    return f"{fence}{pad}{plain}{pad}{fence}"


def _clean(text: str) -> str:
    """Text without the characters that XML cannot carry."""
    return _UNPRINTABLE.sub("?", text)
