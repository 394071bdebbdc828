"""The parameters that every scenario has unless it says otherwise."""

from __future__ import annotations

from collections.abc import Mapping

from scenarios import filming, surroundings
from scenarios.parameters import Choice, Numeric

STANDARD: Mapping[str, Numeric | Choice] = {**surroundings.PARAMETERS, **filming.PARAMETERS}
