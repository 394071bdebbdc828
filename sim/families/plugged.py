"""Kinds of motion of users: an installed entry point, or module:factory."""

from __future__ import annotations

import functools
import importlib.util
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from pjpdaf.plugins.loading import PlugInError, call_plug_in, find_factory
from sim.files import files_digest
from sim.motion.motion import MotionPlan
from sim.motion.stage import Family, Stage, Values, no_objects
from sim.specs import ObjectSpec

MOTIONS = "pjpdaf_bench.families"


@dataclass(frozen=True, eq=False)
class OwnMotion:
    """A kind of motion of a user's: its parameters with units and ranges, its plan, its objects.

    parameters: name -> what a scenario file says of a parameter (unit, range, nominal, meaning;
    or choices). frames: of its scenario, at 3 a second; summary: of `scenarios show`.
    """

    parameters: Mapping[str, Mapping[str, Any]]
    plan: Callable[[Stage], MotionPlan]
    objects: Callable[[Values], tuple[ObjectSpec, ...]] = no_objects
    frames: int = 54
    summary: str = ""


@functools.lru_cache(maxsize=64)
def own_motion(name: str) -> OwnMotion:
    """The kind of motion that a plug-in's factory makes. Raises PlugInError."""
    factory = find_factory("motion", MOTIONS, name)
    made = call_plug_in(f"The motion {name!r} cannot be built:", factory)
    if not isinstance(made, OwnMotion):
        raise PlugInError(
            f"The motion {name!r}: its factory must return an OwnMotion (sim.families.plugged), "
            f"returns {type(made).__name__}."
        )
    return made


def own_family(name: str) -> Family:
    """The family of a plug-in, whose faults name it. Raises PlugInError."""
    made = own_motion(name)

    def plan(stage: Stage) -> MotionPlan:
        # A BenchError is a draw that cannot be posed, or a parameter that does not fit.
        planned = call_plug_in(f"The motion {name!r}: plan: raises", made.plan, stage)
        if not isinstance(planned, MotionPlan):
            raise PlugInError(
                f"The motion {name!r}: plan: must return a MotionPlan (stage.plan makes it), "
                f"returns {type(planned).__name__}."
            )
        return planned

    def objects(values: Values) -> tuple[ObjectSpec, ...]:
        listed = call_plug_in(f"The motion {name!r}: objects: raises", made.objects, values)
        if not (isinstance(listed, tuple) and all(isinstance(o, ObjectSpec) for o in listed)):
            raise PlugInError(
                f"The motion {name!r}: objects: must return a tuple of ObjectSpec, returns "
                f"{type(listed).__name__}."
            )
        return listed

    return Family(tuple(made.parameters), plan, objects)


def source_digest(name: str, group: str = MOTIONS) -> str:
    """SHA-256 of the module or package of a plug-in; "" where it is not there.

    group: of its entry points. Other modules that it imports are not looked at. Nothing is
    imported: not even the package that a module is in.
    """
    module = name
    for point in entry_points(group=group):
        if point.name == name:
            module = point.value
    top = module.partition(":")[0].partition(".")[0]
    try:
        spec = importlib.util.find_spec(top) if top else None
    except ValueError:  # a module that was made by hand
        spec = None
    if spec is None:
        return ""
    if spec.submodule_search_locations:
        folders = [Path(folder) for folder in spec.submodule_search_locations]
        return " ".join(files_digest(folder, sources_below(folder)) for folder in folders)
    file = Path(spec.origin or "")
    return files_digest(file.parent, [file]) if file.is_file() else ""


def sources_below(folder: Path) -> Iterator[Path]:
    """All files below a folder but compiled code."""
    return (p for p in folder.rglob("*") if p.is_file() and "__pycache__" not in p.parts)
