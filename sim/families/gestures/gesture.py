"""The record of a gesture: the fields of its step, who can make it, and how it is planned."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sim.families.gestures.rehearsal import Rehearsal

HAND, BOTH, HEAD = "hand", "both", "head"  # who can make a gesture
NO_LOAD, TAKES, LOADED, PUTS, ANY_LOAD = "no load", "takes", "loaded", "puts", "any load"

# Points of the body that a target can name; `sim.families.gestures.targets` places them.
BODY_POINTS = ("mouth", "chin", "nose", "forehead", "ear", "crown", "chest", "shoulder")


@dataclass(frozen=True)
class Quantity:
    """A field that is a number in a base unit, from least to most; default None: it can be absent.

    required: it cannot.
    """

    name: str
    unit: str
    least: float
    most: float
    meaning: str
    default: float | None = None
    required: bool = False


@dataclass(frozen=True)
class Word:
    """A field that is one of some words; default None: it must be given."""

    name: str
    words: tuple[str, ...]
    meaning: str
    default: str | None = None


@dataclass(frozen=True)
class ObjectName:
    """A field that names an object of the script."""

    name: str
    meaning: str


@dataclass(frozen=True)
class Place:
    """A field that is a target: on or above the table, by an object, on the body."""

    name: str
    meaning: str
    required: bool = True
    body: bool = True  # whether points of the body can be named


StepField = Quantity | Word | ObjectName | Place


@dataclass(frozen=True)
class Target:
    """A target in metres: `table` (ahead of the shoulders, outward, up), `object`, or `body`.

    offset_m: for the table from the origin of the person, for the others from the object's foot or
    the point of the body: ahead, outward (to the side of the hand that acts), up.
    """

    kind: str
    name: str
    offset_m: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Step:
    """A step of a script, its numbers in SI units.

    who: "head", or the sides that act (0 right, 1 left). at_s, after, along, wait_s: when it
    begins. where: the file's place and the step's number, as the beginning of a message.
    """

    index: int
    do: str
    who: tuple[int, ...]
    where: str
    label: str = ""
    at_s: float | None = None
    after: str = ""
    along: str = ""
    wait_s: float = 0.0
    numbers: Mapping[str, float] = field(default_factory=dict)
    words: Mapping[str, str] = field(default_factory=dict)
    targets: Mapping[str, Target] = field(default_factory=dict)

    def number(self, name: str) -> float:
        """A number that the step has."""
        return self.numbers[name]

    def without_duration(self) -> Step:
        """The step at its peak speed, for a part of its way that its duration does not count."""
        return replace(self, numbers={k: v for k, v in self.numbers.items() if k != "duration"})

    @property
    def title(self) -> str:
        """The step as messages name it."""
        return f"motion.steps.{self.index} ({self.do})"


@dataclass(frozen=True, eq=False)
class Gesture:
    """A gesture: fields of its step, who can make it, what it does to a hand's load, its plan.

    play: adds the step to a rehearsal, for the side that is given (of a gesture of both hands, or
    of the head, it is to be ignored).
    """

    meaning: str
    fields: tuple[StepField, ...]
    play: Callable[[Rehearsal, Step, int], None]
    who: tuple[str, ...] = (HAND,)
    load: str = NO_LOAD
    leaves_view: bool = False


SPEED = Quantity("speed", "m/s", 0.02, 4.0, "peak speed; 0.4 m/s without speed and duration")
DURATION = Quantity("duration", "s", 0.1, 60.0, "time that the way takes, instead of a speed")
USUAL_SPEED_MPS = 0.4
