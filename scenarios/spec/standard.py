"""The parameters that every scenario has unless it says otherwise."""

from __future__ import annotations

from collections.abc import Mapping

from scenarios.spec import cameras, person_and_room
from scenarios.spec.parameters.choice import Choice
from scenarios.spec.parameters.numeric import Numeric

STANDARD: Mapping[str, Numeric | Choice] = {**person_and_room.PARAMETERS, **cameras.PARAMETERS}
