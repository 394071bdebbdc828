"""A rehearsal: a script's steps laid one after the other on the clocks of hands and head."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from sim.contact.contact import Unposable
from sim.families.gestures.gesture import Step
from sim.families.gestures.head import HeadPlanner
from sim.motion.carriage import CarriageMotion
from sim.motion.motion import Cue, Hold, PlannedStep
from sim.motion.planner import Grasp, HandPlanner
from sim.motion.stage import Stage
from sim.pose import SIDES, Transform
from sim.specs import ObjectSpec

_ROUNDING_S = 1e-6


@dataclass(frozen=True, eq=False)
class Load:
    """An object in a hand: how it was grasped, where it stood, since when [s]."""

    spec: ObjectSpec
    grasp: Grasp
    place: Transform
    from_s: float


@dataclass
class Rehearsal:
    """All that changes while the steps of a script are planned in their order.

    hands, head: what they do so far. loads: by side, what a hand holds. places: of every object,
    where it stands or was put. spans: start and end [s] of the steps that have a label.
    """

    stage: Stage
    hands: tuple[HandPlanner, HandPlanner]
    head: HeadPlanner
    places: dict[str, Transform]
    loads: dict[int, Load] = field(default_factory=dict)
    holds: list[Hold] = field(default_factory=list)
    cues: list[Cue] = field(default_factory=list)
    leans: list[CarriageMotion] = field(default_factory=list)
    planned: list[PlannedStep] = field(default_factory=list)
    spans: dict[str, tuple[float, float]] = field(default_factory=dict)

    def object_named(self, name: str) -> tuple[ObjectSpec, Transform]:
        """An object of the script and where it stands by now. Raises KeyError."""
        return self.stage.object_named(name)[0], self.places[name]

    def stage_of(self, step: Step) -> Stage:
        """The stage as a family sees it whose parameters are the numbers and words of the step."""
        streams, prefix = self.stage.streams, f"step{step.index}/"
        return replace(
            self.stage,
            values={**self.stage.values, **step.numbers, **step.words},
            streams=lambda name: streams(prefix + name),
        )

    def begin(self, step: Step, clocks_s: Sequence[float]) -> float:
        """When a step begins [s] whose hands, or head, are free at these times.

        Raises Unposable where they are not free yet, or the first frames would not be still.
        """
        free_s = max(clocks_s)
        if step.at_s is not None:
            begins_s, cause = step.at_s, f"at {step.at_s:g} s"
        elif step.along:
            begins_s = self.spans[step.along][0] + step.wait_s
            cause = f"with {step.along}, at {begins_s:.2f} s"
        else:
            after_s = self.spans[step.after][1] if step.after else free_s
            return max(after_s + step.wait_s, free_s)
        if begins_s < free_s - _ROUNDING_S:
            raise Unposable(
                f"{step.where}: overlaps in time: it begins {cause}, but {self._busy(step)} until "
                f"{free_s:.2f} s; begin it later, or leave out its time"
            )
        return begins_s

    def _busy(self, step: Step) -> str:
        """What keeps hands or head of a step from beginning it, for a message."""
        mine = [p for p in self.planned if p.side in (step.who or (None,))]
        if not mine:
            return "the first frames are still"
        last = max(mine, key=lambda planned: planned.to_s)
        who = "the head" if last.side is None else f"the {SIDES[last.side]} hand"
        return f"{who} is busy with {last.title}"

    def note(self, step: Step, side: int | None, from_s: float, to_s: float) -> None:
        """Record when a side (None: the head) makes a step."""
        self.planned.append(PlannedStep(step.where, step.title, side, from_s, to_s))
        who = "head" if side is None else SIDES[side]
        self.cues.append(Cue(f"{step.do}:{who}", from_s, to_s))
        if step.label:
            first, last = self.spans.get(step.label, (from_s, to_s))
            self.spans[step.label] = (min(first, from_s), max(last, to_s))
