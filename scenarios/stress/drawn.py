"""Drawn values: what a case leaves to its noise seed, as the person, the light and the cameras."""

from __future__ import annotations

from scenarios.spec.draw import concrete
from scenarios.spec.parameters.file import File
from scenarios.spec.parameters.numeric import Numeric
from scenarios.stress.case import Case
from scenarios.stress.space import Axis, Space, third
from sim.motion.stage import Value


def drawn_space(space: Space) -> Space:
    """The space of all that does not vary in a space and is not set there; without files."""
    held = {*space.names, *space.fixed}
    parameters = space.family.scenario.parameters
    files = [name for name, parameter in parameters.items() if isinstance(parameter, File)]
    axes = Space.of(space.family, [n for n in parameters if n not in (*held, *files)]).axes
    return Space(space.family, tuple(axis for axis in axes if axis.name not in held), {})


def drawn_values(space: Space, case: Case) -> dict[str, Value]:
    """The concrete values of a case in the drawn space of a space, in each parameter's unit.

    A case that sets all of them is the same episode, to the bit. One that sets some of them may
    not be: in varied surroundings the rig is drawn until it sees the person.
    """
    values = concrete(space.family.scenario, case.seed, case.values)
    return {name: values[name] for name in drawn_space(space).names}


def drawn_part(axis: Axis, value: Value) -> str:
    """The third of its nominal distribution in which a number lies; a choice itself.

    Not of its range, as of what a search varies: most of what is drawn lies in the middle of that.
    """
    if not isinstance(axis.parameter, Numeric):
        return str(value)
    return third(axis.parameter.cdf(float(value)))
