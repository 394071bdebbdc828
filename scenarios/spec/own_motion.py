"""The scenario of a plug-in's motion: its parameters as it declares them, and nothing else."""

from __future__ import annotations

import re

from pydantic import ValidationError

from pjpdaf.errors import BenchError
from pjpdaf.plugins.loading import allow_plug_ins_from_here, entry_point_names
from scenarios.spec.motion.plugged import (
    MODULE_FACTORY,
    declared_parameters,
    fault_of_name,
    first_line,
)
from scenarios.spec.scenario import Scenario
from sim.families.plugged import MOTIONS, own_motion

GROUP = "own"


def is_own_motion(name: str) -> bool:
    """Whether a name given by the user is that of a plug-in's motion."""
    return MODULE_FACTORY.fullmatch(name) is not None or name in entry_point_names(MOTIONS)


def scenario_of_motion(name: str) -> Scenario:
    """The scenario that a plug-in's motion is by itself. Raises BenchError.

    name: an entry point, or module:factory, which the user must trust (`trust`).
    """
    if fault := fault_of_name(name):
        raise BenchError(fault)
    allow_plug_ins_from_here(name)
    made = own_motion(name)
    declared_parameters(name)  # its faults are lines of their own, not those of a record
    plain = re.sub(r"[^a-z0-9_]+", "_", name.rpartition(":")[2].lower()).lstrip("_0123456789")
    record = {
        "name": plain[:60] or GROUP,
        "group": GROUP,
        "family": plain[:60] or GROUP,
        "summary": made.summary or f"The motion {name}.",
        "frames": made.frames,
        "motion": {"kind": name},
        "parameters": {},
    }
    try:
        return Scenario.model_validate(record)
    except ValidationError as error:
        raise BenchError(f"The motion {name!r}: {first_line(error.errors()[0])}") from None
