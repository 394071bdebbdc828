"""Targets and objects of a script, as a file gives them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, model_validator

from scenarios.spec.motion.expression import quantity_type
from scenarios.spec.parameters.record import Name, Number, Record, Text, fault_at
from sim.families.gestures.gesture import BODY_POINTS

# Kinds of object that stand on a table: usual extents x, y, z [m] and colour.
KINDS: Mapping[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "can": ((0.066, 0.066, 0.122), (0.72, 0.05, 0.05)),
    "cup": ((0.100, 0.100, 0.100), (0.20, 0.55, 0.30)),
    "box": ((0.075, 0.095, 0.100), (0.62, 0.12, 0.40)),
    "ball": ((0.110, 0.110, 0.110), (0.15, 0.45, 0.70)),
    "post": ((0.045, 0.045, 0.300), (0.10, 0.11, 0.12)),
    "book": ((0.150, 0.210, 0.030), (0.16, 0.25, 0.24)),
    "block": ((0.060, 0.060, 0.060), (0.30, 0.32, 0.34)),
}

# Least and greatest: of places [m], of an object's extents [m], of its turn [rad].
LENGTH, EXTENT, TURN = (-2.0, 2.0), (0.005, 1.0), (-3.15, 3.15)
if TYPE_CHECKING:
    Length = float | str
    Extent = float | str
    Angle = float | str
    BodyPoint = str
    ObjectKind = str
else:
    Length = quantity_type("m", *LENGTH)
    Extent = quantity_type("m", *EXTENT)
    Angle = quantity_type("rad", *TURN, "turned about the vertical")
    BodyPoint = Literal[BODY_POINTS]
    ObjectKind = Literal[tuple(KINDS)]
# A number of a record: dotted path of its field, value, base unit, least and greatest.
Quantified = tuple[str, float | str, str, tuple[float, float]]
_BY = "ahead, outward (to the acting hand's own side) and up of it"


class TargetFields(Record):
    """A target: a place on or above the table, or relative to an object or a point of the body."""

    table: (
        Annotated[
            tuple[Length, ...],
            Field(
                min_length=2,
                max_length=3,
                description="ahead of the shoulders, outward, and height above the table",
            ),
        ]
        | None
    ) = None
    object: Name | None = None
    body: BodyPoint | None = None
    by: Annotated[tuple[Length, ...], Field(min_length=3, max_length=3, description=_BY)] | None = (
        None
    )

    @model_validator(mode="after")
    def _one_of_three(self) -> Self:
        given = [n for n in ("table", "object", "body") if getattr(self, n) is not None]
        if len(given) != 1:
            raise fault_at("needs one of table, object, body" + (", got two" * (len(given) > 1)))
        if self.by is not None and self.table is not None:
            raise fault_at("goes with object or body; a place on the table has it all", "by")
        return self


class ObjectFields(Record):
    """An object that stands on the table at the start.

    at: ahead of the shoulders and aside, to `side` (right, left, or a parameter that is either).
    """

    kind: ObjectKind
    at: Annotated[
        tuple[Length, ...],
        Field(min_length=2, max_length=2, description="ahead of the shoulders, and aside"),
    ]
    side: Text = "left"
    size: Annotated[tuple[Extent, ...], Field(min_length=3, max_length=3)] | None = None
    colour: (
        Annotated[
            tuple[Annotated[Number, Field(ge=0, le=1)], ...], Field(min_length=3, max_length=3)
        ]
        | None
    ) = None
    turn: Angle = 0.0

    def quantities(self) -> Iterator[Quantified]:
        """Yield all its numbers."""
        for axis, length in enumerate(self.at):
            yield f"at.{axis}", length, "m", LENGTH
        for axis, extent in enumerate(self.size or ()):
            yield f"size.{axis}", extent, "m", EXTENT
        yield "turn", self.turn, "rad", TURN
