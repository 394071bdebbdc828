"""The base of every record that is read from YAML, and the types of its plain fields."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, Strict
from pydantic_core import PydanticCustomError

Number = Annotated[float, Strict(), Field(allow_inf_nan=False)]
Whole = Annotated[int, Strict()]
Text = Annotated[str, Strict()]
NAME = r"^[a-z][a-z0-9_]*$"
Name = Annotated[str, Strict(), Field(pattern=NAME, max_length=60)]


class Record(BaseModel):
    """A frozen record that takes no field but its declared ones; written as it is read."""

    model_config = ConfigDict(extra="forbid", frozen=True, serialize_by_alias=True)


def fault_at(message: str, at: str = "") -> PydanticCustomError:
    """Return a fault for a validator to raise.

    at: dotted path below the validated field that the loader points to, such as "nominal.low";
    "" points to the field itself.
    """
    place = {"at": at} if at else {}
    return PydanticCustomError("fault", "{fault}", {"fault": message, **place})
