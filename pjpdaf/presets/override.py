"""Presets with changed values: KEY=VALUE of the command line, or values of Python."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Mapping
from typing import Any, get_args, get_origin

from pjpdaf.checks import BadParameter
from pjpdaf.errors import closest, did_you_mean
from pjpdaf.presets.flat import VARIANTS, Parameters, flat_names, leaves, replaced
from pjpdaf.presets.record import Preset


def with_values(record: Parameters, values: Mapping[str, object]) -> Parameters:
    """Copy a record with parameters changed, by flat name; texts are read as the parameter's type.

    Raises BadParameter.
    """
    known = {leaf.name: leaf for leaf in leaves(type(record))}
    changed = {}
    for key, value in values.items():
        if key not in known:
            raise BadParameter(
                f"{type(record).__name__} has no field {key!r}.{did_you_mean(key, known)}"
            )
        changed[known[key].path] = _read(key, value, known[key].kind)
    copy: Parameters = replaced(record, changed)
    return copy


def override(
    preset: Preset, values: Mapping[str, object], others: Collection[Preset] = ()
) -> Preset:
    """Change a preset by KEY=VALUE, e.g. {'p_detect': '0.8', 'detector.min_area_px': '150'}.

    A key is a flat name, or one with 'detector.' or 'tracker.' before it. Raises BadParameter with
    the choices and the nearest name, or those of the `others` that have the parameter.
    """
    if not values:
        return preset
    changes: dict[str, dict[str, object]] = {"detector": {}, "tracker": {}}
    names = {
        "detector": flat_names(type(preset.detector)),
        "tracker": flat_names(type(preset.tracker)),
    }
    for key, value in values.items():
        prefix, _, name = key.rpartition(".")
        homes = [prefix] if prefix in changes else [home for home in changes if not prefix]
        home = next((home for home in homes if name in names[home]), None)
        if home is None:
            homes = homes or list(changes)
            known = [field for h in homes for field in names[h]]
            hint = _of_another(name, homes, others, known) or did_you_mean(name, known)
            raise BadParameter(f"No parameter {key!r}.{hint}")
        changes[home][name] = value
    return dataclasses.replace(
        preset,
        detector=with_values(preset.detector, changes["detector"]),
        tracker=with_values(preset.tracker, changes["tracker"]),
    )


def _of_another(
    name: str, homes: Collection[str], others: Collection[Preset], known: Collection[str]
) -> str:
    """Which of other presets have the parameter, or, where none of the known is near, a near one.

    Empty where none has.
    """
    names = {
        one.name: [n for home in homes for n in flat_names(type(getattr(one, home)))]
        for one in others
    }
    near = closest(name, {n for one in names.values() for n in one})
    if not near or (near[0] != name and closest(name, known)):
        return ""
    owners = sorted(one for one in names if near[0] in names[one])
    meant = "" if near[0] == name else f" Did you mean {near[0]!r}?"
    return f"{meant} It is of the preset{'s' if len(owners) > 1 else ''} {' and '.join(owners)}."


_TRUE, _FALSE = ("true", "yes", "on", "1"), ("false", "no", "off", "0")


def _read(key: str, value: object, kind: Any) -> Any:
    """Read a value, possibly text, as `kind`: a variant, bool, int, float or a tuple of floats."""
    if key in VARIANTS:
        variants = VARIANTS[key]
        if isinstance(value, str) and value in variants:
            return variants[value]
        words = ", ".join(map(repr, variants))
        raise BadParameter(f"{key} must be one of {words}, got {value!r}.")
    if get_origin(kind) is tuple:
        numbers = value.strip("()[] ").split(",") if isinstance(value, str) else value
        wanted = get_args(kind)
        if not isinstance(numbers, (list, tuple)) or len(numbers) != len(wanted):
            raise BadParameter(
                f"{key} must be {len(wanted)} numbers with commas between, got {value!r}."
            )
        return tuple(_read(key, number, k) for number, k in zip(numbers, wanted, strict=True))
    if kind is bool:
        text = str(value).strip().lower()
        if text not in _TRUE + _FALSE:
            raise BadParameter(f"{key} must be true or false, got {value!r}.")
        return text in _TRUE
    assert kind in (int, float), kind
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise BadParameter(f"{key} must be a number, got {value!r}.")
    try:
        number = kind(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number) or (kind is int and float(value) != number):
        noun = "a whole number" if kind is int else "a number"
        raise BadParameter(f"{key} must be {noun}, got {value!r}.")
    return number
