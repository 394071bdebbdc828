"""A verdict as JUnit XML."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree import ElementTree

from reports.gate.advice import advice_lines
from reports.gate.text import cap_text, number, unit_text
from reports.gate.verdict import GroupDifference, Verdict
from reports.summary.text import count

_UNPRINTABLE = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit_xml(verdict: Verdict) -> str:
    """Write JUnit XML: a suite per group of scenarios, a case per metric.

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
        name = clean(group)
        counts = _counts(differences)
        suite = ElementTree.SubElement(root, "testsuite", {"name": name, **counts, "time": "0"})
        properties = ElementTree.SubElement(suite, "properties")
        for key, value in (("base", verdict.base), ("new", verdict.new)):
            ElementTree.SubElement(properties, "property", {"name": key, "value": clean(value)})
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
                message = _sentence(difference)
                if difference.verdict == "inconclusive" and verdict.advice is not None:
                    message += "".join(f"; {clean(s)}" for s in advice_lines(verdict.advice))
                kind = "failure" if difference.verdict == "fail" else "skipped"
                part = ElementTree.SubElement(
                    case, kind, {"type": difference.verdict, "message": message}
                )
                part.text = message
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, "unicode") + "\n"


def _counts(differences: Sequence[GroupDifference]) -> dict[str, str]:
    outcomes = [d.verdict for d in differences]
    return {
        "tests": str(len(outcomes)),
        "failures": str(outcomes.count("fail")),
        "errors": "0",
        "skipped": str(outcomes.count("inconclusive")),
    }


def _sentence(difference: GroupDifference) -> str:
    metric = difference.metric
    return (
        f"{metric.name} {difference.verdict}: {number(difference.difference, '+')}"
        f"{unit_text(metric)} an episode (margin {metric.margin:g}; {number(difference.base)} to "
        f"{number(difference.new)}) over {count(difference.episodes, 'episode')} of "
        f"{clean(difference.group)}" + (f"; {capped}" if (capped := cap_text(difference)) else "")
    )


def clean(text: str) -> str:
    """Replace the characters that XML cannot carry."""
    return _UNPRINTABLE.sub("?", text)
