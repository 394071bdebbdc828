"""recipe.json: all that a sequence of a data set was made from, to make it again."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pjpdaf.errors import BenchError
from scenarios.play.job import Job, System, digest_of
from scenarios.spec.draw import concrete, in_si, perform, scene_of
from scenarios.spec.names import load_scenario, scenario_names
from scenarios.spec.parameters.file import File, FileText, file_named
from scenarios.spec.scenario import Scenario, digest
from scenarios.spec.suggestion import suggestion
from sim.dataset.files.layout import DEFAULT_LABELS, LABELS, TRAINING_LABELS
from sim.motion.stage import Value
from sim.scene.identity import identity_of
from sim.script import Performance
from sim.specs import RigSpec

KIND, SCHEMA_VERSION = "pjpdaf-bench recipe", 1
FILES = "files"  # folder of a sequence in which its clips lie
OWN_SIZE = RigSpec().width_px, RigSpec().height_px
SMALLEST, LARGEST = 32, 4096  # width and height of a picture


@dataclass(frozen=True)
class SequenceSettings:
    """The settings of a data set beside its scenarios: labels and picture size.

    size_px: width and height; the focal length goes with the width. None: as the scenario has it.
    """

    labels: tuple[str, ...] = DEFAULT_LABELS
    size_px: tuple[int, int] | None = None

    def record(self) -> dict[str, Any]:
        """Plain values."""
        return {"labels": list(self.labels), "size_px": self.size_px and list(self.size_px)}


@dataclass(frozen=True)
class Recipe:
    """A sequence to make. rung: of the ladder, "" without one."""

    job: Job
    settings: SequenceSettings
    rung: str = ""
    made_with: Mapping[str, Any] = field(default_factory=dict)

    def performance(self) -> Performance:
        """The sequence, ready to be simulated. Raises BenchError, Unposable."""
        job = self.job
        return sized(perform(job.scenario, job.seed, job.overrides), self.settings.size_px)

    def files(self) -> dict[str, FileText]:
        """Clips that it plays, by parameter."""
        return files_of(self.job)

    def record(self, redrawn: int) -> dict[str, Any]:
        """The content of recipe.json. redrawn: as the performance says.

        identity: digests of room, body and rig, whatever the size of the pictures.
        """
        job = self.job
        values = concrete(job.scenario, job.seed, job.overrides, redrawn)
        scene = scene_of(job.scenario, in_si(job.scenario, values))
        return {
            "kind": KIND,
            "schema": SCHEMA_VERSION,
            "scenario": job.scenario.model_dump(mode="json"),
            "scenario_digest": digest(job.scenario),
            "seed": job.seed,
            "label": job.name,
            "rung": self.rung,
            "overrides": {
                name: value if isinstance(value, int | float) else str(value)
                for name, value in job.overrides.items()
            },
            "files": {
                name: {"name": stored_name(file), "sha256": file.sha256}
                for name, file in self.files().items()
            },
            "digest": digest_of(job),
            "values": {
                name: value if isinstance(value, int | float) else str(value)
                for name, value in values.items()
            },
            "identity": asdict(identity_of(scene)),
            "settings": self.settings.record(),
            "made_with": dict(self.made_with),
        }


def sized(performance: Performance, size_px: tuple[int, int] | None) -> Performance:
    """The performance filmed in pictures of another size; the horizontal field of view stays."""
    if size_px is None:
        return performance
    rig = performance.scene.rig
    scale = size_px[0] / rig.width_px
    x, y = rig.principal_offset_px
    rig = replace(
        rig,
        width_px=size_px[0],
        height_px=size_px[1],
        focal_px=scale * rig.focal_px,
        principal_offset_px=(scale * x, scale * y),
    )
    return replace(performance, scene=replace(performance.scene, rig=rig))


def files_of(job: Job) -> dict[str, FileText]:
    """The files that a job plays, by parameter."""
    files: dict[str, FileText] = {}
    for name, parameter in job.scenario.parameters.items():
        if isinstance(parameter, File):
            value = job.overrides.get(name, parameter.file)
            assert isinstance(value, FileText), "a job has found its files"
            files[name] = value
    return files


def stored_name(file: FileText) -> str:
    """Its name in a data set: of its content, so that two of one name stay apart."""
    return f"{file.sha256[:16]}{Path(file).suffix.lower()}"


def read_recipe(record: Mapping[str, Any], folder: Path) -> Recipe:
    """The recipe of a recipe.json whose folder is given; clips lie below it in FILES.

    Raises BenchError where it is none, or cannot be made again by this version.
    """
    path = folder / "recipe.json"
    if record.get("kind") != KIND or record.get("schema") != SCHEMA_VERSION:
        raise BenchError(f"{path}: is not a recipe of version {SCHEMA_VERSION}.")
    clips = _clips(record, folder, path)
    scenario = _scenario(record, clips, path)
    seed, overrides = record.get("seed"), record.get("overrides")
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**63:
        raise BenchError(f"{path}: seed must be a whole number, 0 or more.")
    if not isinstance(overrides, Mapping) or not all(
        isinstance(value, int | float | str) for value in overrides.values()
    ):
        raise BenchError(f"{path}: overrides must be numbers and texts by name.")
    for name in overrides:
        if isinstance(scenario.parameters.get(name), File) and name not in clips:
            raise BenchError(f"{path}: overrides.{name}: its file is not among files.")
    changed: dict[str, Value] = {**overrides, **{n: c for n, c in clips.items() if n in overrides}}
    label = record.get("label")
    if not isinstance(label, str) or not 0 < len(label) <= 200:
        raise BenchError(f"{path}: label must be a text.")
    try:
        job = Job(scenario, seed, changed, System(), label=label)
        concrete(scenario, seed, changed)
    except BenchError as fault:
        raise BenchError(f"{path}: {fault}") from fault
    if digest_of(job) != record.get("digest"):
        raise BenchError(
            f"{path}: its digest is not that of its scenario, seed and changed values; it was "
            "edited, or made by another version."
        )
    rung = record.get("rung")
    made_with = record.get("made_with")
    return Recipe(
        job,
        _settings(record.get("settings"), path),
        rung if isinstance(rung, str) else "",
        made_with if isinstance(made_with, Mapping) else {},
    )


def job_from_recipe(record: Mapping[str, Any], folder: Path) -> Job:
    """The episode of a recipe.json. Raises as `read_recipe`."""
    return read_recipe(record, folder).job


def performance_from_recipe(record: Mapping[str, Any], folder: Path) -> Performance:
    """The sequence of a recipe.json. Raises as `read_recipe`, and Unposable."""
    return read_recipe(record, folder).performance()


def parse_labels(words: str) -> tuple[str, ...]:
    """The labels of a text such as "depth,seg", in the order of LABELS; "training", "all", "none".

    Raises BenchError for an unknown one.
    """
    named = [word.strip() for word in words.split(",") if word.strip()]
    if named == ["all"]:
        return tuple(LABELS)
    if named == ["none"]:
        return ()
    if named == ["training"]:
        return TRAINING_LABELS
    return checked_labels(named, "--labels")


def checked_labels(named: Collection[str], where: str) -> tuple[str, ...]:
    """The labels in the order of LABELS. Raises BenchError for an unknown one."""
    for name in named:
        if name not in LABELS:
            hint = suggestion(name, (*LABELS, "training", "all", "none"))
            raise BenchError(f"{where} {name[:40]}: no such label{hint}")
    return tuple(name for name in LABELS if name in named)


def parse_size(words: str) -> tuple[int, int] | None:
    """Width and height of a text such as "320x240"; None for the scenarios' own size.

    Raises BenchError.
    """
    width, x, height = words.lower().partition("x")
    if not (x and width.isdigit() and height.isdigit() and len(words) <= 20):
        raise BenchError(f"--size {words[:40]}: must be WIDTHxHEIGHT, such as 320x240")
    size = checked_size((int(width), int(height)), "--size")
    return None if size == OWN_SIZE else size


def checked_size(size: tuple[int, int], where: str) -> tuple[int, int]:
    """Raises BenchError where a picture cannot have this size."""
    if not all(SMALLEST <= side <= LARGEST for side in size):
        raise BenchError(
            f"{where} {size[0]}x{size[1]}: both must be from {SMALLEST} to {LARGEST} pixels"
        )
    return size


def _settings(record: Any, path: Path) -> SequenceSettings:
    try:
        labels, size = record["labels"], record["size_px"]
        if not all(isinstance(name, str) for name in labels):
            raise TypeError
        size_px = None if size is None else (int(size[0]), int(size[1]))
    except (KeyError, TypeError, ValueError, IndexError):
        raise BenchError(f"{path}: settings must have labels and size_px.") from None
    if size_px is not None:
        checked_size(size_px, f"{path}: settings.size_px")
    return SequenceSettings(checked_labels(labels, f"{path}: settings.labels"), size_px)


def _clips(record: Mapping[str, Any], folder: Path, path: Path) -> dict[str, FileText]:
    """The clips that a recipe names, each checked against its digest."""
    named = record.get("files")
    if not isinstance(named, Mapping):
        raise BenchError(f"{path}: files must be names and digests by parameter.")
    clips = {}
    for parameter, entry in named.items():
        try:
            file = file_named(str(entry["name"]), folder / FILES)
        except (KeyError, TypeError, ValueError) as fault:
            raise BenchError(f"{path}: files.{parameter}: {fault}") from None
        if file.sha256 != entry.get("sha256"):
            raise BenchError(f"{file.path}: is not the file that {path.name} names.")
        clips[parameter] = file
    return clips


def _scenario(record: Mapping[str, Any], clips: Mapping[str, FileText], path: Path) -> Scenario:
    """The scenario as it was then; the shipped one where it still is the same."""
    given = record.get("scenario")
    if not isinstance(given, dict) or not isinstance(given.get("parameters"), dict):
        raise BenchError(f"{path}: scenario must be a scenario.")
    name, wanted = given.get("name"), record.get("scenario_digest")
    if name in scenario_names():
        shipped = load_scenario(str(name))
        if digest(shipped) == wanted and given == shipped.model_dump(mode="json"):
            return shipped
    parameters = {
        key: {**value, "file": clips[key]} if key in clips and "file" in value else value
        for key, value in given["parameters"].items()
        if isinstance(value, dict)
    }
    try:
        scenario = Scenario.model_validate(
            {**given, "parameters": parameters}, context={"folder": path.parent / FILES}
        )
    except ValidationError as fault:
        first = fault.errors()[0]
        # Names with a space are no fields, but tell which kind of motion or parameter it is.
        at = ".".join(str(part) for part in first["loc"] if " " not in str(part))
        raise BenchError(f"{path}: scenario.{at}: {first['msg']}") from None
    if digest(scenario) != wanted:
        raise BenchError(
            f"{path}: its scenario is not the one that its digest names; it was edited, or made "
            "by another version."
        )
    return scenario
