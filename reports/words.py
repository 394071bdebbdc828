"""Words for targets, events and failures: one table for terminal, pages, pictures and stress."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from sim.event_names import is_merge, stroke_speed_mps

ALL = "all"
LABELS = {"head": "head", "right_hand": "right hand", "left_hand": "left hand", ALL: "all"}
# Of a frame: the estimates of the hands lie on each other's truth.
EXCHANGED = "left and right exchanged"
# Kinds of failure of an episode, the gravest first.
FLAGS = {"swap": "hands swapped", "lost": "lost", "capture": "captured"}
# Goals of a stress test.
GOAL_WORDS = {
    "swap": "hands swapped",
    "head": "head and hand swapped",
    "lost": "target lost",
}
# Measures of robustness (`reports.score.robustness`).
MEASURE_WORDS = {
    "swap": "hands swapped",
    "head_right": "head and right hand swapped",
    "head_left": "head and left hand swapped",
    "lost_head": "head lost",
    "lost_right": "right hand lost",
    "lost_left": "left hand lost",
}
_SIDES = ("right", "left")


def event_text(event: Mapping[Any, Any]) -> str:
    """A scored event in words, such as "right hand captured by head".

    event: a row of the table of events, with kind, target and other.
    """
    target = LABELS[event["target"]]
    return {
        "swap": FLAGS["swap"],
        "capture": f"{target} captured by {LABELS.get(event['other'], '?')}",
        "lost": f"{target} lost",
        "recovered": f"{target} recovered",
    }[event["kind"]]


def pair_text(targets: Iterable[str]) -> str:
    """Targets in words: "hands" for both hands, else such as "head and right hand"."""
    names = [readable_name(name) for name in targets]
    if sorted(names) == ["left hand", "right hand"]:
        return "hands"
    return " and ".join(names)


def label_text(name: str) -> str:
    """A label of a frame in words: "merge:right_hand+left_hand:left_view" is "hands merged, left
    view", "hold:can" is "holds can", "carry:left" is "carry (left hand)", "speed:0.2" is "stroke at
    0.2 m/s".
    """
    if is_merge(name):
        _, pair, view = (*name.split(":"), "")[:3]
        return f"{pair_text(pair.split('+'))} merged, {readable_name(view)}"
    speed_mps = stroke_speed_mps(name)
    if speed_mps == speed_mps:
        return f"stroke at {speed_mps:g} m/s"
    kind, _, detail = name.partition(":")
    if not detail:
        return readable_name(kind)
    thing = f"{detail} hand" if detail in _SIDES else readable_name(detail)
    if kind == "hold":
        return f"holds {thing}"
    return f"{readable_name(kind)} {thing if kind.endswith('_by') else f'({thing})'}"


def labels_text(names: Iterable[str]) -> str:
    """Labels of a frame in words, a merge in both views once."""
    texts = list(dict.fromkeys(label_text(name) for name in names if name))
    for text in list(texts):
        other = text.removesuffix("left view") + "right view"
        if text.endswith(" merged, left view") and other in texts:
            texts[texts.index(text)] = text.removesuffix("left view") + "both views"
            texts.remove(other)
    return " · ".join(texts)


def readable_name(name: str) -> str:
    """A name for reading: targets by their label, underscores as spaces."""
    return LABELS.get(name, name.replace("_", " "))
