"""What makes two failures different: the event, and the cell of the parameters that matter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from scenarios.stress.case import Case
from scenarios.stress.minimise import minimal_changes
from scenarios.stress.search.evaluation import Evaluation
from scenarios.stress.space import Axis, Space
from sim.motion.stage import Value

MOST_UNSURE = 4  # parameters that are named although some of them may not matter
PARTS = ("low", "middle", "high")  # thirds of a range


@dataclass(frozen=True)
class Signature:
    """The signature of a failure. cell: parameter -> third of its range, or choice."""

    family: str
    measure: str
    cell: tuple[tuple[str, str], ...]

    @property
    def words(self) -> str:
        """Its cell, such as "speed high, front left"; "nominal" where no parameter matters."""
        return ", ".join(f"{name} {part}" for name, part in self.cell) or "nominal"


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
        cell = self.signature.cell
        words = f"any of {len(cell)}" if len(cell) > MOST_UNSURE else self.signature.words
        return f"{words} (budget spent: perhaps less)"


def part_of(axis: Axis, value: Value) -> str:
    """The third of its range in which a number lies; a choice itself."""
    if axis.choices:
        return str(value)
    return PARTS[min(int(axis.to_unit(value) * len(PARTS)), len(PARTS) - 1)]


def explained(signature: Signature, space: Space, case: Case, measure: str) -> bool:
    """Whether a failure lies in the cell of a signature that has one, with the same measure."""
    return (
        bool(signature.cell)
        and measure == signature.measure
        and all(part_of(space.axis(n), case.values[n]) == part for n, part in signature.cell)
    )


def attribute(
    space: Space,
    evaluation: Evaluation,
    measure: str,
    evaluate: Callable[[Case], Sequence[str] | None],
) -> DistinctFailure:
    """The failure with the parameters that matter: those that cannot go back to nominal.

    evaluate: the measures that fail for a case, None where it cannot be played any more. The noise
    seed stays.
    """
    case, nominal = evaluation.case, space.nominal()
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
    cell = tuple(
        (axis.name, part_of(axis, case.values[axis.name]))
        for axis in space.axes
        if axis.name in needed
    )
    signature = Signature(case.family, measure, cell)
    return DistinctFailure(signature, evaluation, with_changes(needed), narrowed)
