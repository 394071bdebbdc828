"""Spans of an episode below its time line: failures, merges, hidden targets, each with its name."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pjpdaf.targets import TARGETS
from reports.page.episode_tables import EpisodeTables
from reports.score.records import VIEWS
from reports.words import EXCHANGED, LABELS, event_text, label_text
from sim.event_names import is_merge

HIDDEN = 0.5  # of a target in a view: less of it shows
_FAULTS = ("swap", "capture", "lost")


@dataclass(frozen=True)
class TimeLane:
    """A row of spans: positions of frames (first, last). kind: swap, capture, lost, merged, hidden.

    target: index into `TARGETS`, -1 where it is of several.
    """

    kind: str
    text: str
    target: int
    spans: tuple[tuple[int, int], ...]


def time_lanes(episode: EpisodeTables) -> tuple[TimeLane, ...]:
    """The lanes of an episode: what failed, then merges by pair and view, then hidden targets."""
    return (*_faults(episode), *_merges(episode), *_hidden(episode))


def spans_of(flags: NDArray[np.bool_]) -> tuple[tuple[int, int], ...]:
    """First and last position of each run of true flags (F,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    return tuple((int(a), int(b) - 1) for a, b in edges.reshape(-1, 2))


def _faults(episode: EpisodeTables) -> Iterator[TimeLane]:
    """Swaps first, then captures and losses, a lane for each text."""
    place = {int(frame): i for i, frame in enumerate(episode.index)}
    rows: dict[tuple[int, int, str], list[tuple[int, int]]] = {}
    for event in episode.events.to_dict("records"):
        if event["kind"] in _FAULTS:
            swap = event["kind"] == "swap"
            target = -1 if swap else TARGETS.index(event["target"])
            text = EXCHANGED if swap else event_text(event)
            key = _FAULTS.index(event["kind"]), target, text
            span = place[int(event["first_frame"])], place[int(event["last_frame"])]
            rows.setdefault(key, []).append(span)
    for (kind, target, text), spans in sorted(rows.items()):
        yield TimeLane(_FAULTS[kind], text, target, tuple(spans))


def _merges(episode: EpisodeTables) -> Iterator[TimeLane]:
    """Merges as the truth names them; where it names none, the frames in which any view has one."""
    labels = episode.column("labels")[:, 0]
    named: dict[str, NDArray[np.bool_]] = {}
    for i, text in enumerate(labels):
        for name in filter(is_merge, str(text).split(";")):
            named.setdefault(name, np.zeros(len(labels), dtype=bool))[i] = True
    for name, flags in sorted(named.items()):
        yield TimeLane("merged", label_text(name), -1, spans_of(flags))
    merged = np.asarray(episode.column("merged").astype(bool).any(axis=1), dtype=np.bool_)
    if not named and merged.any():
        yield TimeLane("merged", "merged in a view", -1, spans_of(merged))


def _hidden(episode: EpisodeTables) -> Iterator[TimeLane]:
    for t, target in enumerate(TARGETS):
        for view in VIEWS:
            visible = episode.column(f"visible_{view}")[:, t].astype(np.float64)
            flags = np.asarray(~(visible >= HIDDEN))
            if flags.any():
                yield TimeLane(
                    "hidden", f"{LABELS[target]} hidden, {view} view", t, spans_of(flags)
                )
