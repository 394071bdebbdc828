"""All gestures by name. A registry is a dict."""

from __future__ import annotations

from collections.abc import Mapping

from sim.families.gestures import free, head, hidden, pairs, things, touch
from sim.families.gestures.gesture import Gesture

GESTURES: Mapping[str, Gesture] = {
    name: gesture
    for module in (free, things, touch, pairs, hidden, head)
    for name, gesture in module.GESTURES.items()
}
