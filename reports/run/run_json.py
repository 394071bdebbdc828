"""The schema of run.json: what other modules read of it by key, checked before they do."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from pjpdaf.errors import BenchError
from reports.run.schema import KIND, OLDEST_VERSION, SCHEMA_VERSION, SLIM_TABLES, TABLES

MAX_BYTES = 32 << 20
MAX_FILES = 200_000
_RULES = {"missing": "is missing", "model_type": "must be a mapping"}
MOST = 2**53  # greatest whole number: floats hold it too

Text = Annotated[str, Field(max_length=10_000)]
Count = Annotated[int, Field(ge=0, le=MOST)]
Seconds = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class _Record(BaseModel):
    """A record of which some fields are checked; others may stand beside them."""

    model_config = ConfigDict(strict=True, extra="ignore")


class FileEntry(_Record):
    """A file of the run."""

    sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


class SuiteEntry(_Record):
    """A suite that was played."""

    name: Text
    version: int | Text
    digest: Text


class FailureEntry(_Record):
    """An episode without a result."""

    seed: Count
    reason: Text
    kind: Text | None = None


class ScenarioEntry(_Record):
    """A scenario: its seeds, and the digest and true motion of each."""

    name: Text
    group: Text = ""
    family: Text = ""
    seeds: list[Count]
    digests: list[Text]
    truths: list[Text]
    failures: list[FailureEntry] = []

    @model_validator(mode="after")
    def _of_one_length(self) -> ScenarioEntry:
        for key in ("digests", "truths"):
            if len(getattr(self, key)) != len(self.seeds):
                raise ValueError(f"{key} of {self.name} do not match its seeds")
        if len(set(self.seeds)) != len(self.seeds):
            raise ValueError(f"a seed of {self.name} is there twice")
        return self


class EpisodeEntry(_Record):
    """Something that belongs to an episode."""

    scenario: Text
    seed: Count


class PictureEntry(EpisodeEntry):
    """A stored picture."""

    frame: Count
    file: Text


class FilmEntry(EpisodeEntry):
    """A stored film; whole: of every frame."""

    file: Text
    whole: bool


class TimingEntry(EpisodeEntry):
    """Wall time of the stages of an episode."""

    frames: Count
    stage_s: dict[Text, Seconds]


class Request(_Record):
    """The words of the command line, to play the run again."""

    targets: list[Text]
    seeds: Count | None
    first_seed: Count
    only: list[Text]
    settings: list[Text]
    dataset: Text | None = None
    detections: Text | None = None


class Provenance(_Record):
    """Versions, machine, commit."""

    versions: dict[Text, Text]
    renderer: Text = ""
    commit: Text | None
    dirty: bool | None
    argv: list[Text] = []


class RunJson(_Record):
    """A whole run.json."""

    name: Text
    complete: bool
    slim: bool = False
    metrics_version: int | None = None
    preset: Text
    detector: Text
    tracker: Text
    parameters: dict[Text, Any]
    overrides: dict[Text, Any]
    request: Request | None = None
    suites: list[SuiteEntry] = []
    scenarios: list[ScenarioEntry]
    provenance: Provenance
    pictures: list[PictureEntry]
    films: list[FilmEntry]
    timing: list[TimingEntry]
    files: Annotated[dict[Text, FileEntry], Field(max_length=MAX_FILES)]

    @field_validator("request", mode="before")
    @classmethod
    def _of_a_data_set(cls, value: Any) -> Any:
        return None if value == {} else value

    @model_validator(mode="after")
    def _of_one_run(self) -> RunJson:
        names = [scenario.name for scenario in self.scenarios]
        if len(set(names)) != len(names):
            raise ValueError("a scenario is there twice")
        known = {(s.name, seed) for s in self.scenarios for seed in s.seeds}
        for noun, entries in (("picture", self.pictures), ("film", self.films)):
            for entry in entries:
                if entry.file not in self.files:
                    raise ValueError(f"a {noun} is not listed among the files")
        for of_episode in (*self.pictures, *self.films, *self.timing):
            if (of_episode.scenario, of_episode.seed) not in known:
                raise ValueError(f"no episode {of_episode.scenario} seed {of_episode.seed}")
        for name in SLIM_TABLES if self.slim else TABLES:
            if f"{name}.parquet" not in self.files:
                raise ValueError(f"{name}.parquet is not listed among the files")
        return self


def read_run_json(path: Path) -> dict[str, Any]:
    """Read a run.json; all that `RunJson` has is there and of its type. Raises BenchError."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise BenchError(f"{path}: is larger than {MAX_BYTES >> 20} MiB.")
        text = path.read_text(encoding="utf-8")
        meta = json.loads(text)
        # A half of a surrogate pair, of which no file could be written again.
        json.dumps(meta, ensure_ascii=False).encode("utf-8")
    except RecursionError:
        raise BenchError(f"{path}: is damaged: nested too deeply.") from None
    except (OSError, ValueError) as fault:
        raise BenchError(f"{path}: is damaged: {' '.join(str(fault).split())[:300]}.") from fault
    if not isinstance(meta, dict) or meta.get("kind") != KIND:
        raise BenchError(f"{path}: is not the run.json of a saved run.")
    version = meta.get("schema_version")
    if type(version) is not int or not OLDEST_VERSION <= version <= SCHEMA_VERSION:
        raise BenchError(
            f"{path}: schema version {str(version)[:40]}; this version reads {OLDEST_VERSION} to "
            f"{SCHEMA_VERSION}: play the run again."
        )
    try:
        RunJson.model_validate(meta)
    except ValidationError as fault:
        raise BenchError(f"{path}: is damaged: {_first(fault)}; play the run again.") from None
    return meta


def _first(fault: ValidationError) -> str:
    """The first fault: its place in the file, and the rule."""
    first: Mapping[str, Any] = fault.errors(include_url=False, include_input=False)[0]
    place = ".".join(str(part)[:60] for part in first["loc"])
    rule = _RULES.get(first["type"], str(first["msg"]).removeprefix("Value error, "))
    return f"{place}: {rule[:1].lower()}{rule[1:]}" if place else rule
