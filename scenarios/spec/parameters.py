"""A parameter: a number with unit, range and nominal distribution, one of some words, or a file.

Values are kept in physical units; `latent` gives the same value as a standard-normal number for
those who search.
"""

from __future__ import annotations

import difflib
import hashlib
import math
import re
from collections.abc import Collection, Mapping
from functools import lru_cache
from pathlib import Path, PureWindowsPath
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    Strict,
    Tag,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    field_serializer,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError
from scipy.special import ndtr, ndtri

from pjpdaf.errors import BenchError
from sim.clips.clip_files import MAX_BYTES, SUFFIXES
from sim.motion.stage import Value

Number = Annotated[float, Strict(), Field(allow_inf_nan=False)]
Whole = Annotated[int, Strict()]
Text = Annotated[str, Strict()]
Name = Annotated[str, Strict(), Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=60)]

# Unit -> (base unit, factor). A parameter is kept in its own unit; text may use any of its kind.
UNITS: Mapping[str, tuple[str, float]] = {
    "m": ("m", 1.0),
    "cm": ("m", 0.01),
    "mm": ("m", 0.001),
    "m/s": ("m/s", 1.0),
    "cm/s": ("m/s", 0.01),
    "mm/s": ("m/s", 0.001),
    "km/h": ("m/s", 1 / 3.6),
    "s": ("s", 1.0),
    "ms": ("s", 0.001),
    "rad": ("rad", 1.0),
    "deg": ("rad", math.pi / 180.0),
    "px": ("px", 1.0),
    "grey": ("grey", 1.0),
    "Hz": ("Hz", 1.0),
    "K": ("K", 1.0),
    "EV": ("EV", 1.0),
    "1": ("1", 1.0),
    "%": ("1", 0.01),
}
Unit = Literal[
    "m", "cm", "mm", "m/s", "cm/s", "mm/s", "km/h", "s", "ms", "rad", "deg", "px", "grey",
    "Hz", "K", "EV", "1", "%",
]  # fmt: skip
_QUANTITY = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*([^\s\d.+-]\S*|1)?\s*", re.ASCII
)


def nearest(word: str, known: Collection[str]) -> str:
    """ "; did you mean X?" for the known word that looks most like this one, else nothing."""
    close = difflib.get_close_matches(word, sorted(known), n=1)
    return f"; did you mean {close[0]}?" if close else ""


def quantity(text: str, unit: str) -> float:
    """A number, with or without a unit of the same kind, in `unit`. Raises ValueError."""
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise ValueError(f"must be a number in {unit}, got {text[:60]!r}")
    value, given = float(match[1]), match[2]
    if not math.isfinite(value):
        raise ValueError(f"must be finite, got {text[:60]!r}")
    if given is None:
        return value
    base, factor = UNITS[unit]
    if given not in UNITS or UNITS[given][0] != base:
        fit = ", ".join(name for name, (kind, _) in UNITS.items() if kind == base)
        raise ValueError(f"must be in {fit}, got unit {given[:20]!r}")
    # 0.3 m/s stays 0.3: no factor where there is nothing to convert.
    return value if given == unit else value * UNITS[given][1] / factor


class Record(BaseModel):
    """Frozen, and no field but the declared ones."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Uniform(Record):
    """Equally likely from low to high (left out: the parameter's range)."""

    kind: Literal["uniform"]
    low: Number | None = None
    high: Number | None = None


class LogUniform(Record):
    """The logarithm equally likely from low to high (left out: the parameter's range)."""

    kind: Literal["log-uniform"]
    low: Number | None = None
    high: Number | None = None


class Normal(Record):
    """A normal distribution cut to the parameter's range."""

    kind: Literal["normal"]
    mean: Number
    sd: Annotated[Number, Field(gt=0)]


class Fixed(Record):
    """Always this value; the range says how far it may be set."""

    kind: Literal["fixed"]
    value: Number


Distribution = Annotated[Uniform | LogUniform | Normal | Fixed, Field(discriminator="kind")]


class Numeric(Record):
    """A number: unit, range [least, greatest], and what it nominally is."""

    unit: Unit
    range: tuple[Number, Number]
    nominal: Distribution
    meaning: Text = ""

    @model_validator(mode="before")
    @classmethod
    def _with_units(cls, data: Any) -> Any:
        """Text such as "0.3 m/s" or "30 cm" becomes the number in this parameter's unit."""
        if not isinstance(data, Mapping) or data.get("unit") not in UNITS:
            return data

        def plain(value: Any, place: str) -> Any:
            if not isinstance(value, str):
                return value
            try:
                return quantity(value, data["unit"])
            except ValueError as fault:
                raise PydanticCustomError(
                    "quantity", "{fault}", {"fault": str(fault), "at": place}
                ) from None

        read = dict(data)
        if isinstance(read.get("range"), list | tuple):
            read["range"] = [plain(v, f"range.{i}") for i, v in enumerate(read["range"])]
        if isinstance(read.get("nominal"), Mapping):
            read["nominal"] = {
                key: plain(v, f"nominal.{key}") if key != "kind" else v
                for key, v in read["nominal"].items()
            }
        return read

    @field_validator("range")
    @classmethod
    def _forward(cls, ends: tuple[float, float]) -> tuple[float, float]:
        if ends[0] > ends[1]:
            raise PydanticCustomError(
                "reversed",
                "{fault}",
                {"fault": f"range is reversed: {ends[0]:g} is greater than {ends[1]:g}"},
            )
        return ends

    @model_validator(mode="after")
    def _nominal_inside(self) -> Self:
        low, high = self.range
        for key, value in self.nominal.model_dump(exclude={"kind", "sd"}).items():
            if value is not None and not low <= value <= high:
                raise fault_at(
                    f"{value:g} is outside the range {low:g} to {high:g} {self.unit}",
                    f"nominal.{key}",
                )
        if isinstance(self.nominal, Uniform | LogUniform):
            a, b = self.bounds
            if a > b:
                raise fault_at(f"low {a:g} is greater than high {b:g}", "nominal.low")
            if isinstance(self.nominal, LogUniform) and a <= 0:
                raise fault_at(f"log-uniform needs a low end above 0, got {a:g}", "nominal")
        return self

    @property
    def bounds(self) -> tuple[float, float]:
        """Ends of the nominal distribution: its own where it has any, else the range."""
        low, high = self.range
        if isinstance(self.nominal, Uniform | LogUniform):
            low = low if self.nominal.low is None else self.nominal.low
            high = high if self.nominal.high is None else self.nominal.high
        return low, high

    def at(self, share: float) -> float:
        """The value below which this share (0-1) of the nominal distribution lies: F^-1(share)."""
        low, high = self.bounds
        nominal = self.nominal
        if isinstance(nominal, Fixed):
            return nominal.value
        if isinstance(nominal, Normal):
            first, last = (float(ndtr((end - nominal.mean) / nominal.sd)) for end in (low, high))
            value = nominal.mean + nominal.sd * float(ndtri(first + share * (last - first)))
            return min(max(value, low), high)
        if isinstance(nominal, LogUniform):
            return float(min(max(low * (high / low) ** share, low), high))
        return low + share * (high - low)

    def share(self, value: float) -> float:
        """F(value) of the nominal distribution, the inverse of `at` (1/2 for a fixed one)."""
        low, high = self.bounds
        nominal = self.nominal
        if isinstance(nominal, Fixed) or low == high:
            return 0.5
        if isinstance(nominal, Normal):
            first, here, last = (
                float(ndtr((end - nominal.mean) / nominal.sd)) for end in (low, value, high)
            )
            below = (here - first) / (last - first)
        elif isinstance(nominal, LogUniform):
            below = math.log(value / low) / math.log(high / low)
        else:
            below = (value - low) / (high - low)
        return min(max(below, 0.0), 1.0)

    def check(self, name: str, value: Value) -> float:
        """A value set by hand: a number or text with a unit. Raises BenchError naming the range."""
        low, high = self.range
        try:
            number = quantity(value, self.unit) if isinstance(value, str) else float(value)
        except ValueError as fault:
            raise BenchError(f"{name}: {fault} (range {low:g} to {high:g} {self.unit})") from None
        if not low <= number <= high:
            ends = f"{low:g} to {high:g} {self.unit}"
            raise BenchError(f"{name}: {number:g} {self.unit} is outside its range {ends}")
        return number


class Choice(Record):
    """One of some words, equally likely or by weight."""

    choices: Annotated[tuple[Name, ...], Field(min_length=1)]
    weights: tuple[Annotated[Number, Field(ge=0)], ...] | None = None
    meaning: Text = ""

    @model_validator(mode="after")
    def _weights_fit(self) -> Self:
        if self.weights is not None:
            if len(self.weights) != len(self.choices):
                raise fault_at(
                    f"{len(self.weights)} weights for {len(self.choices)} choices", "weights"
                )
            if sum(self.weights) <= 0:
                raise fault_at("at least one weight must be above 0", "weights")
        return self

    def at(self, share: float) -> str:
        """The choice at this share (0-1) of the cumulated weights."""
        weights = self.weights or (1.0,) * len(self.choices)
        left = share * sum(weights)
        for choice, weight in zip(self.choices, weights, strict=True):
            left -= weight
            if left < 0:
                return choice
        return [c for c, w in zip(self.choices, weights, strict=True) if w > 0][-1]

    def check(self, name: str, value: Value) -> str:
        """A value set by hand. Raises BenchError naming the choices."""
        if value not in self.choices:
            known = ", ".join(self.choices)
            hint = nearest(str(value), self.choices)
            raise BenchError(f"{name}: must be one of {known}, got {str(value)[:60]!r}{hint}")
        return str(value)


class FileText(str):
    """A file as it was named, with where it is and what is in it; in results, only the name.

    path: absolute; sha256: hexadecimal, of its content when it was named.
    """

    path: Path
    sha256: str

    def __new__(cls, given: str, path: Path, sha256: str) -> FileText:
        """The name with what it stands for."""
        self = super().__new__(cls, given)
        self.path, self.sha256 = path, sha256
        return self

    def __reduce__(self) -> tuple[type[FileText], tuple[str, Path, str]]:
        return FileText, (str(self), self.path, self.sha256)

    def unchanged(self) -> Path:
        """The path, once more proved to hold what it held. Raises BenchError where it does not."""
        try:
            now = _sha256(self.path)
        except ValueError as fault:
            raise BenchError(f"{self}: {fault}") from None
        if now != self.sha256:
            raise BenchError(f"{self}: has changed since it was named; start again")
        return self.path


def file_named(given: str, folder: Path | None = None) -> FileText:
    """The file of a name: below `folder`, whatever links lead there, or anywhere where None.

    Raises ValueError with the rule that it breaks.
    """
    path = Path(given)
    if not given or "\0" in given:
        raise ValueError("must be the name of a file")
    if not given.lower().endswith(SUFFIXES):
        raise ValueError(f"must end in {', '.join(SUFFIXES)}, got {given[:200]!r}")
    if folder is not None:
        whole = path.is_absolute() or PureWindowsPath(given).drive or given.startswith("~")
        if whole or not (folder / path).resolve().is_relative_to(folder.resolve()):
            raise ValueError(f"must lie in the folder of this file or below, got {given[:200]!r}")
        path = folder / path
    path = path.absolute()
    return FileText(given, path, _sha256(path))


def _sha256(path: Path) -> str:
    try:
        if not path.exists():
            raise ValueError(f"no such file: {path}")
        if not path.is_file():
            raise ValueError(f"is not a file: {path}")
        state = path.stat()
        if state.st_size > MAX_BYTES:
            raise ValueError(f"is larger than {MAX_BYTES >> 20} MiB: {path}")
        return _sha256_of(path, state.st_size, state.st_mtime_ns)
    except OSError as fault:
        reason = (fault.strerror or str(fault)).lower()
        raise ValueError(f"cannot be read: {reason}: {path}") from None


@lru_cache(maxsize=64)
def _sha256_of(path: Path, size: int, mtime_ns: int) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


class File(Record):
    """A file: in a YAML file below that file's folder, set by hand from anywhere."""

    file: Text
    meaning: Text = ""

    @field_validator("file", mode="wrap")
    @classmethod
    def _found(cls, value: Any, text: ValidatorFunctionWrapHandler, info: ValidationInfo) -> str:
        if isinstance(value, FileText):
            return value
        return found_file(text(value), info)

    @field_serializer("file", when_used="json")
    def _content(self, file: str) -> str:
        """In JSON, of which digests are made, the content stands for the name."""
        assert isinstance(file, FileText)
        return f"sha256:{file.sha256}"

    def at(self, share: float) -> str:
        """The file, whatever the share: nothing is drawn."""
        return self.file

    def check(self, name: str, value: Value) -> str:
        """A file set by hand. Raises BenchError where it cannot be one."""
        if isinstance(value, FileText):
            return value
        try:
            return file_named(str(value))
        except ValueError as fault:
            raise BenchError(f"{name}: {fault}") from None


def found_file(given: str, info: ValidationInfo, at: str = "") -> FileText:
    """`file_named` below the folder that the validation's context names, if it names one."""
    try:
        return file_named(given, (info.context or {}).get("folder"))
    except ValueError as fault:
        place = {"at": at} if at else {}
        raise PydanticCustomError("file", "{fault}", {"fault": str(fault), **place}) from None


def fault_at(message: str, at: str) -> PydanticCustomError:
    """A fault of a part of a record: `at` is the path below it that the loader points to."""
    return PydanticCustomError("fault", "{fault}", {"fault": message, "at": at})


def _sort_of(data: Any) -> str:
    if isinstance(data, File) or (isinstance(data, Mapping) and "file" in data):
        return "from a file"  # no word that may be a field: locations of faults carry it
    if isinstance(data, Choice) or (isinstance(data, Mapping) and "choices" in data):
        return "choice"
    return "numeric"


Parameter = Annotated[
    Annotated[Numeric, Tag("numeric")]
    | Annotated[Choice, Tag("choice")]
    | Annotated[File, Tag("from a file")],
    Discriminator(_sort_of),
]


def latent(parameter: Numeric, value: float) -> float:
    """The standard-normal number z of a value: Phi^-1(F(value))."""
    return float(ndtri(parameter.share(value)))


def fixed(unit: Unit, low: float, high: float, value: float, what: str) -> Numeric:
    """A parameter that stays at a value unless it is set."""
    nominal = Fixed(kind="fixed", value=value)
    return Numeric(unit=unit, range=(low, high), nominal=nominal, meaning=what)


def normal(unit: Unit, low: float, high: float, mean: float, sd: float, what: str) -> Numeric:
    """A parameter that is nominally normal, cut to its range."""
    nominal = Normal(kind="normal", mean=mean, sd=sd)
    return Numeric(unit=unit, range=(low, high), nominal=nominal, meaning=what)


def uniform(unit: Unit, ends: tuple[float, float], a: float, b: float, what: str) -> Numeric:
    """A parameter that is nominally equally likely from a to b, within the range `ends`."""
    nominal = Uniform(kind="uniform", low=a, high=b)
    return Numeric(unit=unit, range=ends, nominal=nominal, meaning=what)


def choice(weights: Mapping[str, float], what: str) -> Choice:
    """A parameter that is one of some words, each as likely as its weight."""
    return Choice(choices=tuple(weights), weights=tuple(weights.values()), meaning=what)
