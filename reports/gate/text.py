"""Numbers and outcomes of a verdict in words."""

from __future__ import annotations

import math
from collections.abc import Callable

from reports.gate.metrics import Metric
from reports.gate.verdict import GroupDifference, MetricVerdict, Verdict
from reports.summary.text import count


def verdict_sentence(verdict: Verdict, lead: str, name: Callable[[Metric], str]) -> str:
    """A verdict in one sentence. lead: its first words, the outcome; name: words for a metric."""
    if verdict.identical:
        text = "the same results as the base, bit for bit"
    elif verdict.verdict == "pass":
        text = "no metric is worse by more than its margin"
    else:
        decisive = (m.metric for m in verdict.metrics if m.verdict == verdict.verdict)
        text = ", ".join(map(name, decisive))
    return f"{lead}: {text} ({count(verdict.episodes, 'paired episode')})"


def outcome_text(judged: MetricVerdict) -> str:
    """A metric's outcome, an improvement beyond doubt marked."""
    return "pass (better)" if judged.better else judged.verdict


def interval_text(judged: MetricVerdict) -> str:
    """The interval of a metric's difference, without its unit."""
    d = judged.difference
    if not math.isfinite(d.low):
        return "unknown"
    return f"{number(d.low, '+')} to {number(d.high, '+')}"


def difference_text(judged: MetricVerdict) -> str:
    """The mean difference, without its unit; a star where some of it is capped."""
    return number(judged.difference.mean, "+") + ("*" if judged.capped else "")


def cap_text(judged: MetricVerdict | GroupDifference, name: str = "") -> str:
    """What is capped of a difference; "" where nothing is. name: of the metric, if not its own."""
    if not judged.capped:
        return ""
    n = judged.difference.n if isinstance(judged, MetricVerdict) else judged.episodes
    reach = f"{number(judged.metric.reach)}{unit_text(judged.metric)}"
    name = name or judged.metric.name
    return f"{judged.capped} of {n} differences of {name} are capped at {reach}"


def unit_text(metric: Metric) -> str:
    """The unit behind a number of this metric, "" for shares."""
    return "" if metric.unit == "1" else f" {metric.unit}"


def number(value: float, sign: str = "") -> str:
    """A number of three digits; sign "+" shows a plus."""
    return f"{value:{sign}.3g}" if value else "0"
