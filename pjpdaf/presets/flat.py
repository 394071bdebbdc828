"""Parameters under flat names, as the command line and run.json give them.

The leaves of the nested records, by field name; a variant, which is an object in the records, goes
by its word. Field names are unique, so NAME alone addresses a parameter.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator, Mapping
from typing import Any, TypeVar, get_type_hints

from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.detector.undistortion import UNDISTORTIONS
from pjpdaf.tracker.clutter import CLUTTER_READINGS
from pjpdaf.tracker.fusion.missed import MISSED_RULES
from pjpdaf.tracker.fusion.registry import FUSIONS
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters
from pjpdaf.tracker.measurement import MEASUREMENT_MODELS
from pjpdaf.tracker.occlusion import OCCLUSION_RULES
from pjpdaf.tracker.parameters import TrackerParameters
from pjpdaf.tracker.process import NOISE_GROWTHS

Parameters = TypeVar(
    "Parameters", bound=DetectorParameters | TrackerParameters | HypothesisParameters
)

# Parameter -> word -> variant: the only place where a word becomes an object.
VARIANTS: Mapping[str, Mapping[str, object]] = {
    "undistort": UNDISTORTIONS,
    "process": NOISE_GROWTHS,
    "measurement": MEASUREMENT_MODELS,
    "clutter_reading": CLUTTER_READINGS,
    "occlusion": OCCLUSION_RULES,
    "update": FUSIONS,
    "beta_0": MISSED_RULES,
}


@dataclasses.dataclass(frozen=True)
class Leaf:
    """A parameter: its path of field names, the last of which is its flat name, and its type."""

    path: tuple[str, ...]
    kind: Any

    @property
    def name(self) -> str:
        """The flat name."""
        return self.path[-1]


def leaves(record: type, above: tuple[str, ...] = ()) -> Iterator[Leaf]:
    """All parameters of a record type and the records in it, in order."""
    kinds = _kinds(record)
    for field in dataclasses.fields(record):
        path, kind = (*above, field.name), kinds[field.name]
        if isinstance(kind, type) and dataclasses.is_dataclass(kind):
            yield from leaves(kind, path)
        else:
            yield Leaf(path, kind)


@functools.cache
def _kinds(record: type) -> dict[str, Any]:
    return get_type_hints(record)  # slow: it evaluates every annotation


def flat_names(record: type) -> tuple[str, ...]:
    """Flat names of a record type, in order."""
    return tuple(leaf.name for leaf in leaves(record))


def flat_values(
    record: DetectorParameters | TrackerParameters | HypothesisParameters,
) -> dict[str, Any]:
    """Flat name -> value, variants by their words of the command line."""
    return {
        leaf.name: _word(leaf.name, functools.reduce(getattr, leaf.path, record))
        for leaf in leaves(type(record))
    }


def _word(name: str, value: object) -> object:
    """Return a variant's word, its description if it has none; any other value as it is."""
    if name not in VARIANTS:
        return value
    words = (word for word, variant in VARIANTS[name].items() if variant == value)
    return next(words, repr(value))


def replaced(record: Any, values: Mapping[tuple[str, ...], object]) -> Any:
    """Copy nested records with other values at these paths, all changed at once."""
    below: dict[str, dict[tuple[str, ...], object]] = {}
    changed: dict[str, object] = {}
    for (name, *rest), value in values.items():
        if rest:
            below.setdefault(name, {})[tuple(rest)] = value
        else:
            changed[name] = value
    changed |= {name: replaced(getattr(record, name), inner) for name, inner in below.items()}
    return dataclasses.replace(record, **changed)
