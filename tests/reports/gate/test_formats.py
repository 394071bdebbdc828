"""The verdict's files against the rules of those who read them."""

import json
import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest

from reports.gate.formats import badge_json, verdict_json
from reports.gate.junit import junit_xml
from reports.gate.markdown import MARKDOWN_LIMIT, markdown
from reports.gate.metrics import METRICS
from reports.gate.statistics import Difference
from reports.gate.verdict import Advice, EpisodeDifference, GroupDifference, MetricVerdict, Verdict

# What Jenkins' xUnit plug-in accepts (its schema junit-10), as element -> (required attributes,
# optional attributes, children, text allowed). Numbers must be numbers: the schema takes any text,
# but Jenkins' own publisher and GitLab do not.
RULES = {
    "testsuites": ((), ("name", "time", "tests", "failures", "errors"), ("testsuite",), False),
    "testsuite": (
        ("name", "tests", "failures", "errors"),
        (
            *("group", "time", "skipped", "timestamp", "hostname"),
            *("id", "package", "file", "log", "url"),
        ),
        ("testsuite", "properties", "testcase", "system-out", "system-err"),
        False,
    ),
    "properties": ((), (), ("property",), False),
    "property": (("name", "value"), (), (), False),
    "testcase": (
        ("name",),
        ("time", "classname", "group"),
        ("skipped", "error", "failure", "system-out", "system-err"),
        False,
    ),
    "failure": ((), ("type", "message"), (), True),
    "error": ((), ("type", "message"), (), True),
    "skipped": ((), ("type", "message"), (), True),
}
TIME = re.compile(r"(([0-9]{0,3},)*[0-9]{3}|[0-9]{0,3})*(\.[0-9]*)?")


def faults_of(element):
    """Every breach of the rules, as text."""
    tag = element.tag
    if tag not in RULES:
        return [f"{tag}: unknown element"]
    required, optional, children, text = RULES[tag]
    found = [f"{tag}: lacks {name}" for name in required if name not in element.attrib]
    found += [f"{tag}: {n} not allowed" for n in element.attrib if n not in required + optional]
    for name in ("tests", "failures", "errors", "skipped"):
        if name in element.attrib and not re.fullmatch(r"\d+", element.attrib[name]):
            found.append(f"{tag}: {name} is no number")
    if not TIME.fullmatch(element.attrib.get("time", "0")):
        found.append(f"{tag}: time is no time")
    words = [element.text, *(child.tail for child in element)]
    if not text and any((word or "").strip() for word in words):
        found.append(f"{tag}: has text")
    for child in element:
        if child.tag not in children:
            found.append(f"{tag}: {child.tag} not allowed in it")
        found += faults_of(child)
    if tag == "testsuite":
        cases = element.findall("testcase")
        kinds = {"failures": "failure", "errors": "error", "skipped": "skipped"}
        counts = {"tests": len(cases)}
        counts |= {k: sum(c.find(v) is not None for c in cases) for k, v in kinds.items()}
        for name, count in counts.items():
            if name in element.attrib and element.attrib[name] != str(count):
                found.append(f"{tag}: {name} is {element.attrib[name]}, there are {count}")
        names = [(c.get("classname"), c.get("name")) for c in cases]
        if len(set(names)) < len(names):
            found.append(f"{tag}: two cases of one name; GitLab drops the second")
    return found


def judged(metric, word, difference=None):
    return MetricVerdict(metric, word, 30.0, 42.0, difference or Difference(12, 9, 15, 24, 24), 0.0)


def verdict_of(word="fail", groups=("baseline", "hand_and_hand"), **changes):
    """A verdict in which the first metric has this word, in the first group."""
    metrics = tuple(judged(m, word if k == 0 else "pass") for k, m in enumerate(METRICS))
    differences = tuple(
        GroupDifference(g, m, word if (g, k) == (groups[0], 0) else "pass", 30.0, 42.0, 12.0, 9)
        for g in groups
        for k, m in enumerate(METRICS)
    )
    whole = Verdict(
        base="main",
        new="mine",
        verdict=word,
        identical=False,
        episodes=24,
        left_out=0,
        looks=1,
        alpha=0.05,
        metrics=metrics,
        groups=differences,
        worst=(EpisodeDifference("drink+dim", 3, 21.0, ("swapped",), "pjpdaf-bench run core"),),
        notes=(),
    )
    return replace(whole, **changes)


HOSTILE = "a|b`c\x07<&>\"'\ud800 ]]> ``x`` <img src=x>\nnext"


@pytest.mark.parametrize("word", ["pass", "fail", "inconclusive"])
@pytest.mark.parametrize("groups", [("baseline",), ("baseline", "hand_and_hand"), (HOSTILE, "b")])
def test_junit_keeps_the_rules_of_its_readers(word, groups):
    text = junit_xml(verdict_of(word, groups))
    assert text.startswith('<?xml version="1.0" encoding="UTF-8"?>\n')
    root = ElementTree.fromstring(text.encode())
    assert root.tag == "testsuites"
    assert faults_of(root) == []
    assert root.get("tests") == str(len(groups) * len(METRICS))
    assert root.get("failures") == str(int(word == "fail"))
    kind = {"fail": "failure", "inconclusive": "skipped", "pass": None}[word]
    said = [e for e in root.iter() if e.tag in ("failure", "skipped")]
    assert [e.tag for e in said] == ([kind] if kind else [])
    # GitLab shows the text, Jenkins the message.
    assert all(
        e.text == e.get("message")
        and "+12 mm an episode (margin 3; 30 to 42) over 9 episodes" in e.text
        for e in said
    )


def test_the_rules_notice_what_breaks_them():
    good = ElementTree.fromstring(junit_xml(verdict_of("fail")))
    suite = good.find("testsuite")
    for change, fault in (
        (lambda: good.set("skipped", "1"), "testsuites: skipped not allowed"),
        (lambda: suite.attrib.pop("errors"), "testsuite: lacks errors"),
        (lambda: suite.set("failures", "7"), "testsuite: failures is 7, there are 1"),
        (lambda: suite.set("time", "soon"), "testsuite: time is no time"),
        (lambda: suite.insert(0, ElementTree.Element("failure")), "failure not allowed in it"),
        (lambda: suite.find("testcase").attrib.pop("name"), "testcase: lacks name"),
        (lambda: suite.append(suite.findall("testcase")[1]), "two cases of one name"),
    ):
        change()
        assert any(fault in found for found in faults_of(good)), fault


def test_json_has_every_figure_and_null_for_an_open_interval():
    open_ = Difference(3.0, float("-inf"), float("inf"), 1, 1)
    metrics = (judged(METRICS[0], "inconclusive", open_),)
    text = verdict_json(verdict_of("inconclusive", metrics=metrics), ("compare", "a", "b"))
    record = json.loads(text, parse_constant=pytest.fail)
    assert record["kind"] == "pjpdaf-bench verdict"
    assert record["provenance"]["argv"] == ["compare", "a", "b"]
    assert record["metrics"][0]["difference"] == {
        "mean": 3.0, "low": None, "high": None, "n": 1, "draws": 1,
    }  # fmt: skip
    assert record["worst"][0]["replay"] == "pjpdaf-bench run core"


@pytest.mark.parametrize(
    ("word", "colour"), [("pass", "brightgreen"), ("fail", "red"), ("inconclusive", "yellow")]
)
def test_the_badge_is_what_shields_reads(word, colour):
    assert json.loads(badge_json(verdict_of(word))) == {
        "schemaVersion": 1, "label": "tracking accuracy", "message": word, "color": colour,
    }  # fmt: skip
    assert json.loads(badge_json(verdict_of("pass", identical=True)))["message"] == "identical"


def cells(line):
    """The cells of a table's row, as a forge splits them."""
    return re.split(r"(?<!\\)\|", line)[1:-1]


def test_the_summary_says_what_failed_where_and_how_to_play_it_again():
    text = markdown(verdict_of("fail", left_out=2, notes=("rendered by another",)))
    assert "❌ fail" in text
    assert "| error_mm | 30 | 42 | +12 (+9 to +15) mm | 3 | ❌ fail |" in text
    assert "Left out: 2 episodes" in text
    assert "Note: `rendered by another`" in text
    assert "| `drink+dim` | 3 | +21.0 mm | swapped | `pjpdaf-bench run core` |" in text
    better = judged(METRICS[0], "pass", Difference(-12.0, -15.0, -9.0, 24, 24))
    assert "✅ pass (better)" in markdown(verdict_of("pass", metrics=(better,)))
    open_ = judged(METRICS[0], "pass", Difference(0.5, float("-inf"), float("inf"), 1, 1))
    assert "+0.5 (unknown) mm" in markdown(verdict_of("inconclusive", metrics=(open_,)))


def test_hostile_names_stay_in_their_cells():
    episode = EpisodeDifference(HOSTILE, 0, 5.0, ("lost",), f"pjpdaf-bench run '{HOSTILE}'")
    whole = verdict_of("fail", (HOSTILE,), base=HOSTILE, new=HOSTILE, worst=(episode,))
    text = markdown(whole)
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert {len(cells(row)) for row in rows} == {5, 6}
    outside = re.sub(r"(`+)(?!`).*?(?<!`)\1(?!`)", "", text)
    assert "<img" not in outside
    assert "\x07" not in text


def test_a_long_summary_is_cut_below_the_limit_at_a_line():
    worst = tuple(EpisodeDifference("é" * 900, k, 1.0, (), "ü" * 900) for k in range(60))
    text = markdown(verdict_of("fail", worst=worst))
    assert len(text.encode()) <= MARKDOWN_LIMIT
    assert text.endswith("|\n\n(cut: too long)\n")


def test_capped_differences_are_marked_wherever_they_stand():
    (group,) = (g for g in verdict_of().groups if g.verdict == "fail")
    metrics = (replace(judged(METRICS[0], "fail"), capped=2),)
    worst = (EpisodeDifference("drink", 3, 121.0, (), "", capped=True),)
    whole = verdict_of(metrics=metrics, groups=(), worst=worst)
    whole = replace(whole, groups=(replace(group, capped=2),))
    text = markdown(whole)
    assert r"| +12\* (+9 to +15) mm |" in text
    assert r"\* 2 of 24 differences of error_mm are capped at 30 mm." in text
    assert r"| +12\* mm | 9 |" in text  # of the group
    assert r"\* capped: an episode counts 10 default margins at most." in text
    assert "| at least +121.0 mm |" in text
    assert "; 2 of 9 differences of error_mm are capped at 30 mm" in junit_xml(whole)
    assert json.loads(verdict_json(whole))["metrics"][0]["capped"] == 2


def test_an_inconclusive_verdict_ends_with_the_reason_and_the_commands():
    advice = Advice("6 episodes of 3 draws", 9, 0.84, ("pjpdaf-bench run 'a b' --seeds 9",))
    whole = verdict_of("inconclusive", advice=advice)
    text = markdown(whole)
    reason = "why: 6 episodes of 3 draws  \nto decide: --seeds 9 of both, a clear verdict of each"
    assert f"{reason} metric in 84 % of all cases" in text
    assert "```sh\npjpdaf-bench run 'a b' --seeds 9\n```" in text
    assert "; why: 6 episodes of 3 draws; to decide: --seeds 9 of both" in junit_xml(whole)
    assert json.loads(verdict_json(whole))["advice"]["seeds"] == 9
