"""WebDataset's shards: a sample a frame, its pictures and labels as they are, and one JSON.

A sample's key is `seq_000000_000001`: sequence and number of the frame's files. A picture that did
not arrive is not in its sample.
"""

from __future__ import annotations

import io
import json
import tarfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from sim.dataset.export.folder import file_bytes, files_of, replaced_folder, sequences_of
from sim.dataset.files.cameras import camera_record
from sim.dataset.files.layout import LABELS, picture_name
from sim.dataset.frame_rows import FrameRow, FrameRows, read_frame_rows
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

FOLDER = "webdataset"
SHARD_SAMPLES = 1000
SHARD_BYTES = 512 << 20
_OF_FRAME = ("frame_index", "time_s", "stamp_s", "events", *(f"arrived_{c}" for c in CAMERAS))


def export(
    dataset: Dataset,
    into: Path,
    on_sequence: Callable[[str], None] = lambda name: None,
    *,
    shard_samples: int = SHARD_SAMPLES,
    shard_bytes: int = SHARD_BYTES,
) -> list[Path]:
    """Write `webdataset/shard-000000.tar` and so on; see `registry.Export`.

    A shard has at most this many samples, and at most this many bytes unless one sample has more.
    """
    folder = into / FOLDER
    with (
        replaced_folder(folder, "WebDataset's shards") as part,
        _Shards(part, shard_samples, shard_bytes) as shards,
    ):
        for sequence in sequences_of(dataset):
            common = _common(sequence)
            for frame in read_frame_rows(sequence):
                shards.add(
                    f"{sequence.name}_{picture_name(frame.index, '')}",
                    _sample(dataset, sequence, frame, common),
                )
            on_sequence(sequence.name)
    return files_of(folder)


def _sample(
    dataset: Dataset, sequence: StoredSequence, frame: FrameRows, common: Mapping[str, Any]
) -> dict[str, bytes]:
    """The members of a sample by what follows its key."""
    members = {}
    for camera in CAMERAS:
        if frame.arrived[camera]:
            path = sequence.folder / camera / picture_name(frame.index)
            members[f"{camera}.png"] = file_bytes(path)
    for label, folders in LABELS.items():
        suffix = ".npz" if label == "float" else ".png"
        for name in folders if label in dataset.labels else ():
            path = sequence.folder / name / picture_name(frame.index, suffix)
            members[f"{name}{suffix}"] = file_bytes(path)
    text = json.dumps({**common, **_said(frame)}, allow_nan=False)
    members["json"] = text.encode("ascii")
    return members


def _common(sequence: StoredSequence) -> dict[str, Any]:
    """What the JSON of each frame of a sequence has: cameras and what the ids mean."""
    return {
        "sequence": sequence.name,
        "fps": sequence.fps,
        "cameras": _cameras(sequence.rig.cameras),
        "calibration": _cameras(sequence.calibration.cameras),
        "instances": [
            {"id": one.id, "name": one.name, "kind": one.kind} for one in sequence.instances
        ],
    }


def _cameras(cameras: Any) -> dict[str, Any]:
    return {name: camera_record(one) for name, one in zip(CAMERAS, cameras, strict=True)}


def _said(frame: FrameRows) -> dict[str, Any]:
    """The frame's rows of the tables, what all of them share only once."""
    return {
        "frame_index": frame.index,
        "time_s": frame.time_s,
        "stamp_s": frame.stamp_s,
        "arrived": dict(frame.arrived),
        "events": frame.targets[0]["events"],
        "targets": [_without(row) for row in frame.targets],
        "objects": [_without(row) for row in frame.objects],
    }


def _without(row: FrameRow) -> dict[str, Any]:
    return {name: value for name, value in row.items() if name not in _OF_FRAME}


class _Shards:
    """Tar files without times, owners or order of the day."""

    def __init__(self, folder: Path, most_samples: int, most_bytes: int) -> None:
        self._folder, self._most = folder, (most_samples, most_bytes)
        self._tar: tarfile.TarFile | None = None
        self._count = self._samples = self._bytes = 0

    def add(self, key: str, members: Mapping[str, bytes]) -> None:
        """The next sample."""
        blocks = tarfile.BLOCKSIZE
        size = sum(blocks + -(-len(data) // blocks) * blocks for data in members.values())
        full = self._samples >= self._most[0] or self._bytes + size > self._most[1]
        if self._tar is None or full:
            self._next()
        assert self._tar is not None
        for name in sorted(members):
            about = tarfile.TarInfo(f"{key}.{name}")  # time 0, owner 0, no names
            about.size = len(members[name])
            self._tar.addfile(about, io.BytesIO(members[name]))
        self._samples += 1
        self._bytes += size

    def _next(self) -> None:
        if self._tar is not None:
            self._tar.close()
        path = self._folder / f"shard-{self._count:06d}.tar"
        self._tar = tarfile.open(path, "w", format=tarfile.USTAR_FORMAT)  # noqa: SIM115 (kept open)
        self._count += 1
        self._samples = self._bytes = 0

    def __enter__(self) -> _Shards:
        return self

    def __exit__(self, *_: object) -> None:
        if self._tar is not None:
            self._tar.close()
