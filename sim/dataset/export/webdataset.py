"""WebDataset's shards: a sample per frame, of its pictures and labels as they are, and a JSON.

A sample's key is `seq_000000_000001`: sequence and number of the frame's files. A picture that did
not arrive is not in its sample.
"""

from __future__ import annotations

import json
import tarfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from pjpdaf.camera import Camera
from sim.dataset.export.export import AddPart, Export, file_bytes
from sim.dataset.files.cameras import camera_record
from sim.dataset.files.layout import LABELS, frames_with, picture_name
from sim.dataset.frame_rows import FrameRow, FrameRows, read_frame_rows
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS
from sim.steps import counted

SHARD_SAMPLES = 1000
SHARD_BYTES = 512 << 20
SAMPLES, SIZES = "samples", "sizes.json"  # of a part
_SHARED = ("frame_index", "time_s", "stamp_s", "events", *(f"arrived_{c}" for c in CAMERAS))


def exporter(shard_samples: int = SHARD_SAMPLES, shard_bytes: int = SHARD_BYTES) -> Export:
    """The export to `webdataset/shard-000000.tar` and so on.

    A shard has at most shard_samples, and at most shard_bytes unless a single sample has more.
    """

    @contextmanager
    def joining(dataset: Dataset, folder: Path) -> Iterator[AddPart]:
        def add(sequence: StoredSequence, part: Path) -> None:
            sizes = json.loads((part / SIZES).read_text("ascii"))
            with (part / SAMPLES).open("rb") as samples:
                for size in sizes:
                    shards.add(samples.read(size))

        with closing(_Shards(folder, shard_samples, shard_bytes)) as shards:
            yield add

    return Export("webdataset", "webdataset", "WebDataset's shards", write_samples, joining)


def write_samples(sequence: StoredSequence, labels: Collection[str], part: Path) -> None:
    """Write the samples of a sequence, as they are in a tar file, and their sizes [bytes]."""
    common = _common(sequence)
    sizes = []
    with (part / SAMPLES).open("wb") as file:
        for frame in counted(read_frame_rows(sequence)):
            key = f"{sequence.name}_{picture_name(frame.index, '')}"
            sample = _tar_members(key, _sample(labels, sequence, frame, common))
            file.write(sample)
            sizes.append(len(sample))
    (part / SIZES).write_text(json.dumps(sizes), "ascii")


def _tar_members(key: str, members: Mapping[str, bytes]) -> bytes:
    """Members of a tar file by suffix of their key, without times and owners."""
    blocks = []
    for name in sorted(members):
        info = tarfile.TarInfo(f"{key}.{name}")  # time 0, owner 0, no names
        info.size = len(members[name])
        padding = -info.size % tarfile.BLOCKSIZE
        blocks += [info.tobuf(tarfile.USTAR_FORMAT), members[name], bytes(padding)]
    return b"".join(blocks)


def _sample(
    labels: Collection[str], sequence: StoredSequence, frame: FrameRows, common: Mapping[str, Any]
) -> dict[str, bytes]:
    """The members of a sample by the suffix of its key."""
    members = {}
    for camera in CAMERAS:
        if frame.arrived[camera]:
            path = sequence.folder / camera / picture_name(frame.index)
            members[f"{camera}.png"] = file_bytes(path)
    for label, folders in LABELS.items():
        suffix = ".npz" if label == "float" else ".png"
        for name in folders if label in labels else ():
            if frame.index not in frames_with(name, sequence.frame_count):
                continue
            path = sequence.folder / name / picture_name(frame.index, suffix)
            members[f"{name}{suffix}"] = file_bytes(path)
    text = json.dumps({**common, **_frame_record(frame)}, allow_nan=False)
    members["json"] = text.encode("ascii")
    return members


def _common(sequence: StoredSequence) -> dict[str, Any]:
    """The part of the JSON that all frames of a sequence share: cameras and instances."""
    return {
        "sequence": sequence.name,
        "fps": sequence.fps,
        "cameras": _cameras(sequence.rig.cameras),
        "calibration": _cameras(sequence.calibration.cameras),
        "instances": [
            {"id": instance.id, "name": instance.name, "kind": instance.kind}
            for instance in sequence.instances
        ],
    }


def _cameras(cameras: Sequence[Camera]) -> dict[str, Any]:
    return {name: camera_record(camera) for name, camera in zip(CAMERAS, cameras, strict=True)}


def _frame_record(frame: FrameRows) -> dict[str, Any]:
    """The frame's rows of the tables; the values that all rows share, once."""
    return {
        "frame_index": frame.index,
        "time_s": frame.time_s,
        "stamp_s": frame.stamp_s,
        "arrived": dict(frame.arrived),
        "events": frame.targets[0]["events"],
        "targets": [_unshared(row) for row in frame.targets],
        "objects": [_unshared(row) for row in frame.objects],
        "skeletons": [_unshared(row) for row in frame.skeletons],
    }


def _unshared(row: FrameRow) -> dict[str, Any]:
    return {name: value for name, value in row.items() if name not in _SHARED}


class _Shards:
    """Writes tar files of whole samples: the same samples, the same bytes."""

    def __init__(self, folder: Path, most_samples: int, most_bytes: int) -> None:
        self._folder, self._most = folder, (most_samples, most_bytes)
        self._tar: tarfile.TarFile | None = None
        self._count = self._samples = self._bytes = 0

    def add(self, sample: bytes) -> None:
        """Add the members of a sample, as they are in a tar file."""
        full = self._samples >= self._most[0] or self._bytes + len(sample) > self._most[1]
        if self._tar is None or full:
            self._next()
        assert self._tar is not None
        assert self._tar.fileobj is not None
        self._tar.fileobj.write(sample)
        self._tar.offset += len(sample)
        self._samples += 1
        self._bytes += len(sample)

    def _next(self) -> None:
        self.close()
        path = self._folder / f"shard-{self._count:06d}.tar"
        self._tar = tarfile.open(path, "w", format=tarfile.USTAR_FORMAT)  # noqa: SIM115 (kept open)
        self._count += 1
        self._samples = self._bytes = 0

    def close(self) -> None:
        """Finish the current shard."""
        if self._tar is not None:
            self._tar.close()
            self._tar = None
