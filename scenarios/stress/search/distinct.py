"""What makes two failures different: the event, and the cell of the values that matter."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from scenarios.stress.case import Case
from scenarios.stress.drawn import drawn_part, drawn_space, drawn_values
from scenarios.stress.minimise import minimal_changes
from scenarios.stress.search.evaluation import Evaluation
from scenarios.stress.space import Axis, Space, third
from sim.motion.stage import Value

MOST_UNSURE = 4  # values that are named although some of them may not matter
Failing = Callable[[Case], Sequence[str] | None]


@dataclass(frozen=True)
class Signature:
    """The signature of a failure. cell: parameter that is searched -> third of its range, or
    choice; drawn: where none of these matters, of what is drawn from the noise seed the same, by
    thirds of its nominal distribution.
    """

    family: str
    measure: str
    cell: tuple[tuple[str, str], ...]
    drawn: tuple[tuple[str, str], ...] = ()

    @property
    def parts(self) -> tuple[tuple[str, str], ...]:
        """All that matters, searched or drawn."""
        return (*self.cell, *self.drawn)

    def covers(self, other: Signature) -> bool:
        """Whether every failure of another signature is one of this, by what is drawn."""
        same = (self.family, self.measure) == (other.family, other.measure)
        return same and bool(self.drawn) and set(self.drawn) <= set(other.drawn)

    @property
    def words(self) -> str:
        """As "speed high, front left" or "drawn: beard yes"; else that all is nominal."""
        if not self.parts:
            return "nominal, drawn values too"
        return self.worded(", ".join(f"{name} {part}" for name, part in self.parts))

    def worded(self, parts: str) -> str:
        """Words for its parts, marked where these are drawn."""
        return f"drawn: {parts}" if self.drawn else parts


@dataclass(frozen=True)
class DistinctFailure:
    """A failure with a signature of its own; minimal: the same with only what matters changed.

    narrowed: whether everything that the signature names is known to matter; the budget may end
    before.
    """

    signature: Signature
    evaluation: Evaluation
    minimal: Case
    narrowed: bool = True

    @property
    def words(self) -> str:
        """Its signature's cell, and whether more of it may not matter; a long one as a number."""
        if self.narrowed:
            return self.signature.words
        parts = self.signature.parts
        words = self.signature.words
        if len(parts) > MOST_UNSURE:
            words = self.signature.worded(f"any of {len(parts)}")
        return f"{words} (budget spent: perhaps less)"


def part_of(axis: Axis, value: Value) -> str:
    """The third of its range in which a number lies; a choice itself."""
    return str(value) if axis.choices else third(axis.to_unit(value))


def explained(signatures: Iterable[Signature], space: Space, case: Case, measure: str) -> bool:
    """Whether a failure lies in the cell of a signature that has one, with the same measure."""
    known = [signature for signature in signatures if signature.measure == measure]
    for cell in (signature.cell for signature in known if signature.cell):
        if all(part_of(space.axis(name), case.values[name]) == part for name, part in cell):
            return True
    cells = [signature.drawn for signature in known if signature.drawn]
    if not cells:
        return False
    drawn, values = drawn_space(space), drawn_values(space, case)
    return any(
        all(drawn_part(drawn.axis(name), values[name]) == part for name, part in cell)
        for cell in cells
    )


def attribute(
    space: Space, evaluation: Evaluation, measure: str, evaluate: Failing
) -> DistinctFailure:
    """The failure with the values that matter: those that cannot go back to nominal.

    Of the parameters of the space; where none of these matters, of what is drawn from the noise
    seed. evaluate: the measures that fail for a case, None where it cannot be played any more. The
    noise seed stays.
    """
    case = evaluation.case
    needed, minimal, narrowed = _narrowed(space, case, measure, evaluate)
    if needed or not narrowed:
        cell = tuple((n, part_of(space.axis(n), case.values[n])) for n in needed)
        signature = Signature(case.family, measure, cell)
        return DistinctFailure(signature, evaluation, minimal, narrowed)
    drawn, values = drawn_space(space), drawn_values(space, minimal)
    # All of them are set, so that what goes back to nominal moves nothing else.
    whole = minimal.with_values(values)
    needed, minimal, narrowed = _narrowed(drawn, whole, measure, evaluate)
    cell = tuple((n, drawn_part(drawn.axis(n), values[n])) for n in needed)
    signature = Signature(case.family, measure, (), cell)
    return DistinctFailure(signature, evaluation, minimal, narrowed)


def _narrowed(
    space: Space, case: Case, measure: str, evaluate: Failing
) -> tuple[tuple[str, ...], Case, bool]:
    """The parameters of a space that a failing case needs, in the space's order.

    Also the case with the others nominal, and whether all that are left are known to be needed.
    """
    nominal = space.nominal()
    changed = [name for name in space.names if case.values[name] != nominal[name]]
    here, there = space.unit_of_values(case.values), space.unit_of_values(nominal)
    distance = dict(zip(space.names, abs(here - there), strict=True))
    changed.sort(key=lambda name: float(distance[name]))

    def with_changes(names: Sequence[str]) -> Case:
        return case.with_values({n: nominal[n] for n in changed if n not in names})

    narrowed = True

    def fails_with(names: Sequence[str]) -> bool:
        nonlocal narrowed
        failed = evaluate(with_changes(names))
        narrowed = narrowed and failed is not None
        return failed is not None and measure in failed

    needed = minimal_changes(changed, fails_with)
    in_order = tuple(name for name in space.names if name in needed)
    return in_order, with_changes(needed), narrowed
