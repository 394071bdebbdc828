"""MOTChallenge's ground truth: a folder a sequence and view, and the 3-D variant beside it.

Frames, ids and boxes count from 1; ids are 1 head, 2 right hand, 3 left hand; the class is 1.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from sim.dataset.export.export import AddPart, Export, move_content
from sim.dataset.frame_rows import FrameRows, box_of, read_frame_rows
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS
from sim.steps import counted

CLASS = 1  # "pedestrian": the only class that MOTChallenge's readers score


def write_mot(sequence: StoredSequence, labels: Collection[str], part: Path) -> None:
    """Write `<sequence>-<camera>/` of both views."""
    frames = [*counted(read_frame_rows(sequence))]
    for view, camera in enumerate(CAMERAS):
        folder = part / f"{sequence.name}-{camera}"
        _write(folder / "seqinfo.ini", _seqinfo(sequence, view))
        _write(folder / "gt" / "gt.txt", _boxes(frames, camera))
        _write(folder / "gt" / "gt_3d.txt", _positions(frames, camera))


@contextmanager
def _joining(dataset: Dataset, folder: Path) -> Iterator[AddPart]:
    """Move the folders, and name them in `seqmaps/all.txt`."""
    yield lambda sequence, part: move_content(part, folder)
    names = [f"{sequence.name}-{camera}" for sequence in dataset.sequences for camera in CAMERAS]
    _write(folder / "seqmaps" / "all.txt", "".join(f"{name}\n" for name in ["name", *names]))


export = Export("mot", "mot", "MOTChallenge's files", write_mot, _joining)


def _boxes(frames: list[FrameRows], camera: str) -> str:
    """A line for each target that a picture shows."""
    lines = []
    for frame in frames:
        for number, row in enumerate(frame.targets, 1):
            corner = _corner(frame, number, camera)
            if corner is not None:
                share = row[f"visible_fraction_{camera}"]
                lines.append(f"{frame.index + 1},{number},{corner},1,{CLASS},{share:.6f}\n")
    return "".join(lines)


def _positions(frames: list[FrameRows], camera: str) -> str:
    """A line for each target in each frame: x, y, z [m]; hidden targets: no box, active 0."""
    lines = []
    for frame in frames:
        for number, row in enumerate(frame.targets, 1):
            corner = _corner(frame, number, camera)
            box = f"{corner},1" if corner is not None else "-1,-1,-1,-1,0"
            place = ",".join(f"{row[f'{axis}_m']:.6f}" for axis in "xyz")
            lines.append(f"{frame.index + 1},{number},{box},{place}\n")
    return "".join(lines)


def _corner(frame: FrameRows, number: int, camera: str) -> str | None:
    """left,top,width,height counted from 1, None where no picture shows the target."""
    box = box_of(frame.targets[number - 1], camera) if frame.arrived[camera] else None
    if box is None:
        return None
    left, top, width, height = box
    return f"{left + 1:g},{top + 1:g},{width:g},{height:g}"


def _seqinfo(sequence: StoredSequence, view: int) -> str:
    camera, size = CAMERAS[view], sequence.rig.cameras[view]
    return (
        "[Sequence]\n"
        f"name={sequence.name}-{camera}\n"
        f"imDir=../../{sequence.name}/{camera}\n"
        f"frameRate={sequence.fps:g}\n"
        f"seqLength={sequence.frame_count}\n"
        f"imWidth={size.width_px}\n"
        f"imHeight={size.height_px}\n"
        "imExt=.png\n"
    )


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="ascii")
