"""Swaps, captures, losses and recoveries of an episode, with hysteresis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.targets import LEFT_HAND, RIGHT_HAND, TARGETS
from reports.score.records import Episode
from reports.score.score import Bools

KINDS = ("swap", "capture", "lost", "recovered")
APART_M = 0.10
SWAP_S = 0.5
LOST_M = 0.15
LOST_S = 1.0
RECOVERED_M = 0.10
RECOVERED_S = 0.5


@dataclass(frozen=True)
class Event:
    """Something that went wrong (or right again) between two frames, both included.

    target, other: indices into `TARGETS`; other is the target that captured this one, the other
    hand of a swap, else -1. first, last: positions in the episode's frames. ended: it was over
    before the episode was. For `recovered`, first is the frame of the loss and last the frame
    from which the target is tracked again, so that the duration is the time to recovery.
    """

    kind: str
    target: int
    other: int
    first: int
    last: int
    ended: bool
    start_s: float
    duration_s: float


@dataclass(frozen=True)
class Span:
    """A sustained condition: frames first..last; `ended` if it was over before the frames were."""

    first: int
    last: int
    ended: bool


def find_events(episode: Episode) -> tuple[Event, ...]:
    """All events of an episode, ordered by first frame, kind and target.

    swap: m = <e_R - e_L, g_R - g_L> / |g_R - g_L|² < 0 for 0.5 s of frames in which the hands are
    more than 0.10 m apart; over when m > 0 for as long. One event, of the right hand with the left.
    capture: for 0.5 s an estimate is nearest to another target's truth instead of its own, the two
    truths being more than 0.10 m apart. Hands that capture each other are a swap, not a capture.
    lost: more than 0.15 m off for 1 s. No estimate counts as infinitely far off, except before the
    first one (the tracker waits for a good start); a target that never gets one is lost from
    the first frame on. recovered: within 0.10 m for 0.5 s after that.
    """
    truths = np.stack([outcome.truth.centres_m for outcome in episode.frames])
    estimates = np.stack([outcome.estimates.positions_m for outcome in episode.frames])
    times = np.array([outcome.truth.time_s for outcome in episode.frames])
    events = [
        *_swaps(truths, estimates, times, episode.fps),
        *_captures(truths, estimates, times, episode.fps),
        *_losses(truths, estimates, times, episode.fps),
    ]
    return tuple(sorted(events, key=lambda e: (e.first, KINDS.index(e.kind), e.target, e.last)))


def swap_margin(truths_m: Floats, estimates_m: Floats) -> Floats:
    """`pair_margin` of the two hands."""
    return pair_margin(truths_m, estimates_m, RIGHT_HAND, LEFT_HAND)


def pair_margin(truths_m: Floats, estimates_m: Floats, a: int, b: int) -> Floats:
    """m (F,) of targets a, b from positions (F, T, 3): +1 right, 0 coalesced, -1 swapped.

    m = <e_a - e_b, g_a - g_b> / |g_a - g_b|²; NaN in frames without estimates of both.
    """
    g = truths_m[:, a] - truths_m[:, b]
    e = estimates_m[:, a] - estimates_m[:, b]
    with np.errstate(invalid="ignore", divide="ignore"):
        margin = np.sum(e * g, axis=1) / np.sum(g * g, axis=1)
    return np.asarray(margin)


def frames_of(duration_s: float, fps: float) -> int:
    """Least number of frames that lasts duration_s: 0.5 s at 3 fps are 2 frames."""
    return max(1, math.ceil(duration_s * fps - 1e-9))


def sustained(bad: Bools, good: Bools, enter: int, leave: int, gap: int = 0) -> list[Span]:
    """Spans in which a condition holds, with hysteresis.

    bad, good (F,): evidence for and against; a frame may be neither. It starts with the first of
    `enter` bad frames and is over at the first of `leave` good frames. Frames that are neither are
    passed over where at most `gap` of them stand together; more of them start the count anew.
    """
    spans: list[Span] = []
    active = False
    start = run_start = count = silent = 0
    last_bad = 0
    for frame in range(len(bad)):
        wanted, against = (good, bad) if active else (bad, good)
        if wanted[frame]:
            run_start = frame if count == 0 else run_start
            count, silent = count + 1, 0
        else:
            silent += 1
            if against[frame] or silent > gap:
                count = 0
        if active and bad[frame]:
            last_bad = frame
        if count == (leave if active else enter):
            if active:
                spans.append(Span(start, last_bad, ended=True))
            else:
                start, last_bad = run_start, frame
            active, count = not active, 0
    if active:
        spans.append(Span(start, len(bad) - 1, ended=False))
    return spans


def _event(kind: str, target: int, other: int, span: Span, times: Floats, fps: float) -> Event:
    duration = float(times[span.last] - times[span.first]) + 1.0 / fps
    return Event(
        kind, target, other, span.first, span.last, span.ended, float(times[span.first]), duration
    )


def hands_apart(truths_m: Floats) -> Bools:
    """Frames (F,) of positions (F, T, 3) in which the hands are more than 0.10 m apart."""
    return _apart(truths_m, RIGHT_HAND, LEFT_HAND)


def _apart(truths: Floats, a: int, b: int) -> Bools:
    far: Bools = np.linalg.norm(truths[:, a] - truths[:, b], axis=1) > APART_M
    return far


def _swaps(truths: Floats, estimates: Floats, times: Floats, fps: float) -> list[Event]:
    margin = swap_margin(truths, estimates)
    apart = hands_apart(truths)
    need = frames_of(SWAP_S, fps)
    spans = sustained(apart & (margin < 0), apart & (margin > 0), need, need, gap=need)
    return [_event("swap", RIGHT_HAND, LEFT_HAND, span, times, fps) for span in spans]


def _captures(truths: Floats, estimates: Floats, times: Floats, fps: float) -> list[Event]:
    # distances[f, t, u]: from the estimate of t to the truth of u.
    distances = np.linalg.norm(estimates[:, :, None] - truths[:, None], axis=-1)
    need = frames_of(SWAP_S, fps)
    T = len(TARGETS)
    captured = np.zeros((len(truths), T, T), dtype=bool)
    decided = np.zeros_like(captured)
    for t in range(T):
        for u in range(T):
            if t != u:
                apart = _apart(truths, t, u)
                nearest = (distances[:, t, [u]] <= distances[:, t]).all(axis=1)
                taken = nearest & (distances[:, t, u] < distances[:, t, t])
                captured[:, t, u] = apart & taken
                decided[:, t, u] = apart & ~taken & np.isfinite(distances[:, t, u])
    mutual = captured[:, RIGHT_HAND, LEFT_HAND] & captured[:, LEFT_HAND, RIGHT_HAND]
    events = []
    for t in range(T):
        for u in range(T):
            bad = captured[:, t, u]
            if {t, u} == {RIGHT_HAND, LEFT_HAND}:
                bad = bad & ~mutual
            spans = sustained(bad, decided[:, t, u], need, need, gap=need)
            events += [_event("capture", t, u, span, times, fps) for span in spans]
    return events


def _losses(truths: Floats, estimates: Floats, times: Floats, fps: float) -> list[Event]:
    events = []
    for target in range(len(TARGETS)):
        errors = np.linalg.norm(estimates[:, target] - truths[:, target], axis=1)
        given = np.isfinite(errors)
        errors = np.where(given, errors, np.inf)
        bad = errors > LOST_M
        if given.any():
            bad[: int(np.argmax(given))] = False
        spans = sustained(
            bad,
            errors <= RECOVERED_M,
            min(frames_of(LOST_S, fps), len(errors)),
            frames_of(RECOVERED_S, fps),
        )
        for span in spans:
            events.append(_event("lost", target, -1, span, times, fps))
            if span.ended:
                back = _first_good(errors, span, frames_of(RECOVERED_S, fps))
                waited = float(times[back] - times[span.first])
                start = float(times[span.first])
                events.append(Event("recovered", target, -1, span.first, back, True, start, waited))
    return events


def _first_good(errors: Floats, span: Span, need: int) -> int:
    """First of the frames within the bound that ended a span."""
    good = errors <= RECOVERED_M
    for frame in range(span.last + 1, len(errors) - need + 1):
        if good[frame : frame + need].all():
            return frame
    raise AssertionError("an ended loss has a recovery")


@dataclass(frozen=True)
class TargetEvents:
    """Counts of one target's events in an episode. Frames count the span, both ends included."""

    swaps: int
    swapped_frames: int
    captures: int
    losses: int
    lost_frames: int
    recoveries: int
    recovery_s: float

    @property
    def ever_swapped(self) -> bool:
        """The hands changed places at least once (also where they started so)."""
        return self.swaps > 0

    @property
    def ever_lost(self) -> bool:
        """The target was lost at least once."""
        return self.losses > 0


def count_events(events: tuple[Event, ...], target: int) -> TargetEvents:
    """The events that concern one target; a swap concerns both hands. recovery_s is their sum."""
    swaps = [e for e in events if e.kind == "swap" and target in (e.target, e.other)]
    mine = [e for e in events if e.target == target]
    losses = [e for e in mine if e.kind == "lost"]
    back = [e for e in mine if e.kind == "recovered"]
    return TargetEvents(
        swaps=len(swaps),
        swapped_frames=_length(swaps),
        captures=sum(e.kind == "capture" for e in mine),
        losses=len(losses),
        lost_frames=_length(losses),
        recoveries=len(back),
        recovery_s=sum(e.duration_s for e in back),
    )


def _length(events: list[Event]) -> int:
    assert all(a.last < b.first for a, b in pairwise(events)), "spans of a kind do not overlap"
    return sum(e.last - e.first + 1 for e in events)
