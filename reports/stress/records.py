"""What the verbs of `stress` save, a JSON file each; the page reads nothing else but episodes.

Goals are "swap" (the hands exchanged), "head" (the head and a hand exchanged), "lost" (any target).
Values of parameters are in the parameter's unit.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pjpdaf.errors import BenchError
from reports.score.robustness import Goal
from sim.files import disk_faults, written_whole_file

SCHEMA_VERSION: Literal[1] = 1
MOST_BYTES = 64_000_000
Fidelity = Literal["fast", "full"]
Value = float | str
Share = Annotated[float, Field(ge=0, le=1)]
Count = Annotated[int, Field(ge=0)]
R = TypeVar("R", bound="StressFile")


class Record(BaseModel):
    """A frozen record that takes no field but its declared ones."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class EpisodeKey(Record):
    """An episode of the saved run `episodes` beside the file."""

    label: str
    seed: Count


class CaseRecord(Record):
    """A concrete scenario: values that are set, and the noise seed."""

    family: str
    values: dict[str, Value]
    seed: Count


class AxisRecord(Record):
    """A parameter along an axis: its range, or its choices."""

    name: str
    unit: str
    low: float = 0.0
    high: float = 1.0
    log: bool = False
    choices: tuple[str, ...] = ()


class ChangedValue(Record):
    """A parameter that a failure needs: its value, and the nominal one.

    drawn: from the noise seed, not varied by the search.
    """

    name: str
    unit: str
    value: Value
    nominal: Value
    drawn: bool = False


class FailureRecord(Record):
    """A distinct failure.

    measure: of `reports.score.robustness`; cell: the part of the space in words; narrowed: whether
    all that is changed is known to matter; rho: of the measure; severity: share of frames in error;
    confirmed: in full, None if not tried; survived: (failures, fresh noise seeds) of the minimal
    case; command: plays it again.
    """

    measure: str
    cell: str
    case: CaseRecord
    changed: tuple[ChangedValue, ...]
    narrowed: bool = True
    fidelity: Fidelity
    rho: float
    severity: Share
    confirmed: bool | None = None
    survived: tuple[Count, Count] | None = None
    blame: str = ""
    command: str = ""
    episode: EpisodeKey | None = None


class SearchRecord(Record):
    """The search of a family. first: points until the first failure, None without any."""

    family: str
    fidelity: Fidelity
    parameters: Count
    runs: Count
    failing: Count
    first: Count | None = None
    ended: str
    failures: tuple[FailureRecord, ...]


class CellRecord(Record):
    """A cell of a map: ends along x and y as shares of their axes, failures of n trials by goal.

    case: the trial that stands for it; episode: where it is kept; command: plays it again.
    """

    x: tuple[Share, Share]
    y: tuple[Share, Share] = (0.0, 1.0)
    n: Count
    failures: dict[Goal, Count]
    case: CaseRecord
    episode: EpisodeKey | None = None
    command: str = ""


class OccludedRecord(Record):
    """Targets (n) that no view showed for this many frames at a stretch; lost: of these."""

    frames: Count
    n: Count
    lost: Count


class MapRecord(Record):
    """Failures over one parameter or two. goal, level: of the contour that was refined.

    others: the parameters that are not on an axis are drawn nominally, or stay at their medians.
    unplayed: trials without a result. occluded: of the targets of all trials at one frame rate.
    """

    family: str
    fidelity: Fidelity
    goal: Goal
    level: Share
    x: AxisRecord
    y: AxisRecord | None = None
    seeds: Count
    others: Literal["drawn", "medians"]
    runs: Count
    unplayed: Count = 0
    cells: tuple[CellRecord, ...]
    occluded: tuple[OccludedRecord, ...] = ()
    command: str = ""


class EstimateRecord(Record):
    """The probability of a goal under the nominal distribution, with its 95 % interval.

    fidelity: of the figure; "full" after the correction of `fast` ones, or where all runs were
    full. fast: the share of `fast` before; full_failing, full_passing: (failures, full runs) of
    draws that fast failed and passed. verdict: "bound" where nothing failed.
    """

    family: str
    goal: Goal
    fidelity: Fidelity
    p: Share
    low: Share
    high: Share
    method: Literal["plain", "importance"]
    verdict: Literal["estimated", "bound", "inconclusive"]
    runs: Count
    adaptation_runs: Count = 0
    failures: Count
    ess: float
    largest_weight: Share
    fast: tuple[Share, Share, Share] | None = None
    full_failing: tuple[Count, Count] | None = None
    full_passing: tuple[Count, Count] | None = None
    command: str = ""


class CompareRecord(Record):
    """Two systems on common draws: trials in which both, one, or none failed.

    difference: P(b) - P(a) with its 95 % interval; p_value: two-sided exact McNemar. cells_a,
    cells_b: failures of each over the cells of a map.
    """

    family: str
    goal: Goal
    fidelity: Fidelity
    a: str
    b: str
    both: Count
    only_a: Count
    only_b: Count
    neither: Count
    difference: float
    low: float
    high: float
    p_value: Share
    map_a: MapRecord | None = None
    map_b: MapRecord | None = None
    command: str = ""


class StressFile(Record):
    """A file of a verb. system: the system under test in words.

    without_result: runs in which a plug-in raised, hung or died; first_fault: of the first.
    """

    schema_version: Literal[1] = SCHEMA_VERSION
    system: str
    without_result: Annotated[Count, Field(exclude_if=lambda n: n == 0)] = 0
    first_fault: Annotated[str, Field(exclude_if=lambda text: not text)] = ""


class SearchFile(StressFile):
    """failures.json: what a search found, for the page."""

    kind: Literal["search"] = "search"
    searches: tuple[SearchRecord, ...]
    command: str = ""


class MapFile(StressFile):
    """map.json."""

    kind: Literal["map"] = "map"
    maps: tuple[MapRecord, ...]


class EstimateFile(StressFile):
    """estimate.json."""

    kind: Literal["estimate"] = "estimate"
    estimates: tuple[EstimateRecord, ...]


class CompareFile(StressFile):
    """compare.json."""

    kind: Literal["compare"] = "compare"
    comparisons: tuple[CompareRecord, ...]


def write_record(path: Path, record: StressFile) -> Path:
    """Write a file, whole or not at all. Raises BenchError, InfrastructureError of a full disk."""
    noun = "the results"
    with written_whole_file(path, noun, replace=True) as part, disk_faults(path, noun):
        part.write_text(record.model_dump_json(indent=1) + "\n", encoding="utf-8")
    return path


def read_record(path: Path, kind: type[R]) -> R | None:
    """Read a file, None where there is none. Raises BenchError where it is damaged or foreign."""
    if not path.is_file():
        return None
    try:
        if path.stat().st_size > MOST_BYTES:
            raise BenchError(f"{path}: has more than {MOST_BYTES // 1_000_000} MB; not read.")
        return kind.model_validate_json(path.read_bytes())
    except OSError as error:
        raise BenchError(f"{path}: cannot be read: {error.strerror or error}.") from error
    except ValidationError as fault:
        first = fault.errors()[0]
        place = ".".join(map(str, first["loc"])) or "the file"
        raise BenchError(
            f"{path}: is damaged or of another version at {place}: {first['msg']}."
        ) from fault
