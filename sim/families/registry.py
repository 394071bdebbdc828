"""All families of motion by name. A registry is a dict."""

from __future__ import annotations

from collections.abc import Mapping

from sim.families import crossing, face, fast, recorded, splits, table, together, traps, view
from sim.motion.stage import Family

FAMILIES: Mapping[str, Family] = {
    name: gesture
    for module in (table, face, together, crossing, view, splits, fast, traps, recorded)
    for name, gesture in module.FAMILIES.items()
}
