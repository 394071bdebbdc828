"""Recorded motion: a clip played by the person."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pjpdaf.errors import BenchError
from sim.clips.clip_files import load_clip
from sim.clips.clips import Clip, mirrored
from sim.clips.retarget import Retargeted, retarget
from sim.motion.carriage import Carriage
from sim.motion.curves import started
from sim.motion.motion import Cue, MotionPlan
from sim.motion.planner import LEAST_STROKE_S
from sim.motion.stage import STILL_S, Family, Stage
from sim.motion.strokes import HandPath, HandState, Stroke, minimum_jerk, stroke_duration

_BOW_M = np.array([0.0, 0.0, 0.02])  # of the strokes that lead in
_AROUND_S = 1.0  # of the clip around what is played, that is judged too
_RAMP_S = 0.4  # in which the clip's time gets going, and comes to rest


@dataclass(frozen=True)
class ClipClock:
    """The clip's time over the performer's: still until from_s, then 1 / slow as fast, then still.

    start_s, end_s: where in the clip it begins and ends. Getting going and coming to rest take
    ramp_s each, so that there is no jump in speed.
    """

    from_s: float
    start_s: float
    end_s: float
    slow: float

    @property
    def ramp_s(self) -> float:
        """Duration in which the clip's time gets going [s]."""
        return min(_RAMP_S, self.slow * (self.end_s - self.start_s))

    @property
    def over_s(self) -> float:
        """When the clip is over [s]."""
        return self.from_s + self.slow * (self.end_s - self.start_s) + self.ramp_s

    def clip_s(self, t_s: float) -> float:
        """The moment of the clip at t_s."""
        ramp, gone = self.ramp_s, t_s - self.from_s
        left = self.over_s - t_s
        if gone <= 0.0:
            return self.start_s
        if left <= 0.0:
            return self.end_s
        if left < ramp:
            return self.end_s - started(left, ramp) / self.slow
        return self.start_s + started(gone, ramp) / self.slow

    def when(self, clip_s: float) -> float:
        """When a moment of the clip is played, within ramp_s / 2 at its ends."""
        within = min(max(clip_s, self.start_s), self.end_s)
        return self.from_s + 0.5 * self.ramp_s + self.slow * (within - self.start_s)


@dataclass(frozen=True, eq=False)
class ClipHand:
    """A hand that comes from its place on the table and plays the clip."""

    side: int
    arriving: HandPath
    clock: ClipClock
    body: Retargeted

    def at(self, t_s: float) -> HandState:
        """The state at t_s [s], any t."""
        if t_s <= self.clock.from_s:
            return self.arriving.at(t_s)
        return self.body.hand(self.side, self.clock.clip_s(t_s))


@dataclass(frozen=True, eq=False)
class ClipCarriage:
    """Torso and head: upright while the hands are still, then as in the clip."""

    clock: ClipClock
    body: Retargeted

    def at(self, t_s: float) -> Carriage:
        """The carriage at t_s [s], any t."""
        share = minimum_jerk((t_s - STILL_S) / (self.clock.from_s - STILL_S))
        return self.body.carriage(self.clock.clip_s(t_s), share)


def _recorded(stage: Stage) -> MotionPlan:
    """From rest to the clip's first pose, the clip, and held still where it is over."""
    begin_s = stage.number("clip_start")
    end_s = begin_s + stage.duration_s / stage.number("slow")
    clip = load_clip(str(stage.values["clip"]), (begin_s - _AROUND_S, end_s + _AROUND_S))
    if stage.values["mirror"] == "yes":
        clip = mirrored(clip)
    start = stage.number("clip_start")
    if start >= clip.duration_s - 0.1:
        raise BenchError(
            f"clip_start: {start:g} s is not before the clip's end at {clip.duration_s:.2f} s"
        )
    body = retarget(
        clip,
        stage.scene,
        stage.number("elbow_swivel"),
        stage.number("scale"),
        stage.number("lift"),
    )
    rests = [stage.rest(side) for side in (0, 1)]
    firsts = [body.hand(side, start) for side in (0, 1)]
    # Both hands arrive together, the hand with the longer way at lead_speed.
    lead_s = max(
        stroke_duration(first.position_m - rest.position_m, _BOW_M, stage.number("lead_speed"))
        for first, rest in zip(firsts, rests, strict=True)
    )
    lead_s = max(lead_s, LEAST_STROKE_S)
    clock = ClipClock(STILL_S + lead_s, start, clip.duration_s, stage.number("slow"))
    right, left = (
        ClipHand(
            side,
            HandPath(rests[side], (Stroke(STILL_S, lead_s, firsts[side], _BOW_M),)),
            clock,
            body,
        )
        for side in (0, 1)
    )
    return stage.plan(
        (right, left), cues=_cues(stage, clip, clock), carriage=ClipCarriage(clock, body)
    )


def _cues(stage: Stage, clip: Clip, clock: ClipClock) -> tuple[Cue, ...]:
    cues = [Cue("clip", clock.from_s, clock.over_s)]
    if clock.over_s < stage.duration_s:
        cues.append(Cue("clip:over", clock.over_s, stage.duration_s))
    cues += [
        Cue(f"clip:bridged:{gap.joint}", clock.when(gap.from_s), clock.when(gap.to_s))
        for gap in clip.gaps
        if gap.to_s > clock.start_s
    ]
    return tuple(cues)


FAMILIES: Mapping[str, Family] = {
    "recorded": Family(
        ("clip", "slow", "mirror", "clip_start", "scale", "lift", "lead_speed"), _recorded
    ),
}
