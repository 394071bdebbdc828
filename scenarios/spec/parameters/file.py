"""A parameter that is a file, such as a clip of recorded motion."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path, PureWindowsPath
from typing import Any

from pydantic import ValidationInfo, ValidatorFunctionWrapHandler, field_serializer, field_validator

from pjpdaf.errors import BenchError
from scenarios.spec.parameters.record import Record, Text, fault_at
from sim.clips.clip_files import MAX_BYTES, SUFFIXES
from sim.motion.stage import Value


class FileText(str):
    """The name of a file as the user gave it, with its place and the digest of its content.

    path: absolute; sha256: hexadecimal, of the content when the file was named.
    """

    path: Path
    sha256: str

    def __new__(cls, given: str, path: Path, sha256: str) -> FileText:
        """Build the text with its two fields."""
        self = super().__new__(cls, given)
        self.path, self.sha256 = path, sha256
        return self

    def __reduce__(self) -> tuple[type[FileText], tuple[str, Path, str]]:
        return FileText, (str(self), self.path, self.sha256)

    def unchanged(self) -> Path:
        """The path, after its content is proved the same. Raises BenchError where it is not."""
        try:
            now = _sha256(self.path)
        except ValueError as fault:
            raise BenchError(f"{self}: {fault}") from None
        if now != self.sha256:
            raise BenchError(f"{self}: has changed since it was named; start again")
        return self.path


def file_named(given: str, folder: Path | None = None) -> FileText:
    """Find a file by its name: below `folder`, links resolved, or anywhere where None.

    Raises ValueError with the rule that the name breaks.
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


def file_in_context(given: str, info: ValidationInfo, at: str = "") -> FileText:
    """Find a file below the folder that the validation's context names, if it names one.

    at: as of `fault_at`. Raises PydanticCustomError.
    """
    try:
        return file_named(given, (info.context or {}).get("folder"))
    except ValueError as fault:
        raise fault_at(str(fault), at) from None


def contents(values: Mapping[str, Value]) -> dict[str, Value]:
    """The same values with the digest of its content for each file."""
    return {
        name: f"sha256:{value.sha256}" if isinstance(value, FileText) else value
        for name, value in values.items()
    }


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
    def _with_digest(
        cls, value: Any, as_text: ValidatorFunctionWrapHandler, info: ValidationInfo
    ) -> str:
        return value if isinstance(value, FileText) else file_in_context(as_text(value), info)

    @field_serializer("file", when_used="json")
    def _content(self, file: str) -> str:
        """In JSON, of which digests are made, the content stands for the name."""
        assert isinstance(file, FileText)
        return f"sha256:{file.sha256}"

    def quantile(self, share: float) -> str:
        """The file, whatever the share: nothing is drawn."""
        return self.file

    def check(self, name: str, value: Value) -> str:
        """A file set by hand. Raises BenchError where it cannot be used."""
        if isinstance(value, FileText):
            return value
        try:
            return file_named(str(value))
        except ValueError as fault:
            raise BenchError(f"{name}: {fault}") from None
