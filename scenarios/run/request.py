"""The request of a run, and its file in the folder of an unfinished run."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass, field, replace
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from pjpdaf.errors import BenchError
from pjpdaf.presets.names import DEFAULT_PRESET
from pjpdaf.presets.registry import PRESETS
from scenarios.execute.episodes import EPISODE_TIME_LIMIT_S
from scenarios.play.plan import PlanRequest
from sim.files import written_whole_file

REQUEST = "request.json"
MAX_BYTES = 1 << 20


@dataclass(frozen=True)
class Shard:
    """The index-th of `count` parts of a run, from 1: every count-th episode."""

    index: int
    count: int

    def __str__(self) -> str:
        return f"shard {self.index} of {self.count}"

    def owns(self, number: int) -> bool:
        """Whether the episode of this number, from 0, is in it."""
        return number % self.count == self.index - 1


@dataclass(frozen=True)
class RunRequest:
    """Arguments of `run`; None: the default.

    plan: the episodes; jobs: worker processes; cluster: as of `place_of`; out: folder of the
    saved run; argv: the command line, for run.json; slim: save only what `compare` needs;
    time_limit_s: of one episode; by_target: print a row for each target; shard: the part to play,
    None for the whole run.
    """

    plan: PlanRequest = field(default_factory=PlanRequest)
    preset: str = DEFAULT_PRESET
    jobs: int | None = None
    cluster: str | None = None
    out: Path | None = None
    argv: tuple[str, ...] = ()
    slim: bool = False
    time_limit_s: float = EPISODE_TIME_LIMIT_S
    by_target: bool = False
    shard: Shard | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """What is played, for the name of a folder."""
        dataset = self.plan.dataset
        return self.plan.targets if dataset is None else (dataset.absolute().name,)


def parse_shard(text: str) -> Shard:
    """Read `--shard I/K`. Raises BenchError."""
    match = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text)
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise BenchError(f"--shard {text[:40]}: must be I/K, the I-th of K parts, as 1/8 up to 8/8")
    return Shard(int(match[1]), int(match[2]))


def write_request(path: Path, request: RunRequest) -> None:
    """Write a request as JSON, without folder, processes and cluster. Raises BenchError."""
    plain = replace(request, out=None, jobs=None, cluster=None)
    data = TypeAdapter(RunRequest).dump_json(plain, indent=1)
    with written_whole_file(path, "the request", replace=True) as part:
        part.write_bytes(data + b"\n")


def read_request(path: Path, detector: str | None = None, tracker: str | None = None) -> RunRequest:
    """Read the request of a file.

    detector, tracker: those that the user names. A file names no code that is run: a plug-in must
    be named by the user as well. Raises BenchError.
    """
    request = stored_request(path)
    given = {"detector": detector, "tracker": tracker}
    plug_ins = named_plug_ins(request)
    for kind, name in {"detector": request.plan.detector, "tracker": request.plan.tracker}.items():
        if given[kind] is None and kind in plug_ins:
            raise BenchError(
                f"{path.parent}: was begun with --{kind} {name}; give that again, as it is code"
            )
        if given[kind] not in (None, name):
            raise BenchError(f"{path.parent}: was begun with --{kind} {name}, got {given[kind]}")
    return request


def stored_request(path: Path) -> RunRequest:
    """The request of a file, to be looked at; what it names is not to be run. Raises BenchError."""
    try:
        with path.open("rb") as file:
            request: RunRequest = TypeAdapter(RunRequest).validate_json(file.read(MAX_BYTES))
    except OSError as fault:
        raise BenchError(f"{path}: cannot be read: {fault.strerror or fault}") from fault
    except ValidationError as fault:
        first = fault.errors()[0]
        at = ".".join(map(str, first["loc"]))
        raise BenchError(f"{path}: is damaged: {at}: {first['msg']}") from None
    return request


def named_plug_ins(request: RunRequest) -> dict[str, str]:
    """Detector and tracker of a request that are a user's code, by "detector" and "tracker"."""
    wanted = request.plan
    named = {"tracker": wanted.tracker}
    if wanted.detections is None:  # else the detector is the name of a file
        named["detector"] = wanted.detector
    return {kind: name for kind, name in named.items() if name not in PRESETS}


def resume_command(folder: Path, request: RunRequest) -> str:
    """The command line that goes on with the unfinished run of a folder."""
    words = ["pjpdaf-bench", "run", "--resume", str(folder)]
    for kind, name in sorted(named_plug_ins(request).items()):
        words += [f"--{kind}", name]
    return shlex.join(words)
