"""One sequence: all checks of its files, and which of two files that disagree is named."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pjpdaf.arrays import Image
from pjpdaf.errors import BenchError
from sim.dataset.check.cameras import camera_faults, usable
from sim.dataset.check.depth import (
    Crossing,
    changed,
    closing,
    closing_fault,
    misplaced,
    other_depth,
    surface_offset,
    twin_faults,
    validity_faults,
)
from sim.dataset.check.events import event_faults
from sim.dataset.check.fault import MISSING, Claim, Fault, fault_of, gathered
from sim.dataset.check.files import Sums, Tree, completeness_faults, damaged, twice_faults
from sim.dataset.check.frame import Frame, load
from sim.dataset.check.frame_tables import (
    FrameTables,
    Numbers,
    numbers_of,
    read_frames,
    shape_claims,
    time_claims,
)
from sim.dataset.check.masks import amodal_faults, seg_faults
from sim.dataset.check.pairs import (
    RectifiedSights,
    correspondence_faults,
    disparity_wrong,
    float_faults,
    occlusion_faults,
)
from sim.dataset.check.pixel_rays import PixelRays
from sim.dataset.check.projection import projection_faults
from sim.dataset.check.view_order import (
    exchanged_faults,
    lone_fault,
    views_swapped,
    wrong_eye,
)
from sim.dataset.files.layout import EVENTS, OBJECTS, RECIPE, RIG, TRUTH, picture_name
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

VIEWS = (0, 1)
NEEDED = (EVENTS, OBJECTS, RECIPE, RIG, TRUTH)


@dataclass(frozen=True)
class Checked:
    """What was found. numbers: those that exports repeat, None where the tables are damaged."""

    faults: tuple[Fault, ...]
    numbers: Numbers | None


def check_sequence(
    sequence: StoredSequence, tree: Tree, sums: Sums, labels: Collection[str], hash_files: bool
) -> Checked:
    """tree, sums: of this sequence, by paths from the data set's folder."""
    faults = list(damaged(tree, sums, tree.plain)) if hash_files else []
    needed = {f"{sequence.name}/{file}" for file in NEEDED}
    faults += [Fault(path, MISSING) for path in needed - tree.plain]
    faults += twice_faults(tree, sequence.name, sums)
    try:
        frames, backgrounds = sequence.frame_count, sequence.background_count
        faults += camera_faults(tree.root, sequence)
        rig, skew_s, _ = sequence.rig, sequence.skew_s, sequence.fps
        names = {one.id: one.name for one in sequence.instances}
    except BenchError as error:
        return Checked((*faults, fault_of(error, tree.root)), None)
    faults += _entry_faults(sequence, tree)
    told: list[FrameTables] | None = None
    try:
        told = read_frames(sequence)
    except BenchError as error:
        faults.append(fault_of(error, tree.root))
    if told is not None or sequence.entry.get("frames") == frames:
        arrived = None if told is None else [frame.arrived for frame in told]
        faults += completeness_faults(tree, sequence.name, frames, backgrounds, labels, arrived)
    with np.errstate(all="ignore"):
        seen = usable(rig)
        if told is not None:
            faults += _told_faults(sequence, tree.root, told)
            wrong = projection_faults(sequence.name, told, rig, skew_s) if seen else []
            faults += wrong
            seen &= not any(fault.file.endswith(RIG) for fault in wrong)
        eyes = _Eyes(sequence, skew_s, names, told, seen)
        here = max((_number(path) for path in tree.plain), default=0)
        for index in range(min(frames, here)):
            frame = load(sequence, tree, index, labels, faults)
            eyes.check(frame)
        eyes.check_backgrounds(tree, backgrounds)
    faults += gathered(eyes.claims)
    numbers = None if told is None else numbers_of(sequence, told)
    return Checked((*faults, *eyes.faults), numbers)


def _number(path: str) -> int:
    """Number of a file of a frame, 0 of another."""
    stem = path.rpartition("/")[2].partition(".")[0]
    return int(stem) if stem.isascii() and stem.isdigit() and len(stem) < 9 else 0


def _entry_faults(sequence: StoredSequence, tree: Tree) -> Iterator[Fault]:
    """manifest.json's entry against rig.json and recipe.json."""
    recipe: Mapping[str, Any] = {}
    try:
        recipe = sequence.recipe
    except BenchError as error:
        yield fault_of(error, tree.root)
    entry, file = sequence.entry, f"{sequence.name}/{RIG}"
    said: list[tuple[str, Any, str]] = [
        ("frames", sequence.frame_count, file),
        ("fps", sequence.fps, file),
    ]
    if "digest" in recipe:
        file = f"{sequence.name}/{RECIPE}"
        said += [(key, recipe.get(key), file) for key in ("digest", "seed", "label")]
    for key, value, where in said:
        if entry and entry.get(key) != value:
            yield Fault(where, f"{key} is {value}, manifest.json says {entry.get(key)}")


def _told_faults(sequence: StoredSequence, root: Path, told: list[FrameTables]) -> list[Fault]:
    """Of the tables and of events.json."""
    claims: list[Claim] = []
    faults: list[Fault] = []
    claims += time_claims(sequence.name, told, sequence.fps)
    claims += shape_claims(sequence.name, told)
    try:
        found = event_faults(sequence.name, told, sequence.events)
        _sorted_into(found, faults, claims)
    except BenchError as error:
        faults.append(fault_of(error, root))
    return [*faults, *gathered(claims)]


def _sorted_into(found: Iterator[Fault | Claim], faults: list[Fault], claims: list[Claim]) -> bool:
    """Put each where it belongs; whether a file was found faulty."""
    faulty = False
    for one in found:
        if isinstance(one, Fault):
            faults.append(one)
            faulty = True
        else:
            claims.append(one)
    return faulty


class _Eyes:
    """The checks of single frames; keeps what they find, and what backgrounds are judged by."""

    def __init__(
        self,
        sequence: StoredSequence,
        skew_s: float,
        names: dict[int, str],
        told: list[FrameTables] | None,
        seen: bool,
    ) -> None:
        self.faults: list[Fault] = []
        self.claims: list[Claim] = []
        self._sequence, self._skew_s, self._names, self._told = sequence, skew_s, names, told
        self._sights = tuple(PixelRays(camera) for camera in sequence.rig.cameras) if seen else None
        self._rectified = RectifiedSights(sequence.rig) if seen else None
        self._good: Frame | None = None  # the first whose depth has no fault
        self._still: Crossing | None = None  # of what stands still, from left to right
        self._lone: list[tuple[int, Frame]] = []

    def check(self, frame: Frame) -> None:
        """All checks of a frame."""
        told = self._told[frame.index] if self._told is not None else None
        trusted = [self._masks(frame, view, told) for view in VIEWS]
        start = len(self.faults)
        for view in VIEWS:
            if trusted[view]:
                self.faults += validity_faults(frame, view)
            if frame.eyes[view].rectified is not None:
                self.faults += occlusion_faults(frame, view)
        if self._sights is not None and self._rectified is not None and all(trusted):
            self._depths(frame, told, self._sights, self._rectified)
        named = {fault.file for fault in self.faults[start:]}
        for view in VIEWS:
            # A twin of what is wrong itself need not be named.
            if frame.file("depth", view) not in named:
                self.faults += twin_faults(frame, view)
            if not named & {frame.file(kind, view) for kind in ("disparity", "correspondence")}:
                self.faults += float_faults(frame, view)

    def _masks(self, frame: Frame, view: int, told: FrameTables | None) -> bool:
        """Whether the view's ids can be built upon."""
        eye = frame.eyes[view]
        if eye.seg is None:
            return False
        if told is None:
            return True
        found = seg_faults(frame, told, view, self._names)
        if _sorted_into(found, self.faults, self.claims):
            return False
        if eye.amodal is not None:
            found = amodal_faults(frame, told, view, self._names)
            _sorted_into(found, self.faults, self.claims)
        return True

    def _depths(
        self,
        frame: Frame,
        told: FrameTables | None,
        sights: tuple[PixelRays, ...],
        rectified: RectifiedSights,
    ) -> None:
        pair = sights[0], sights[1]
        still = self._skew_s > 0
        low: dict[int, float] = {}
        for view in VIEWS:
            eye = frame.eyes[view]
            if eye.depth_m is not None and eye.rectified is not None:
                later = still and view == 1
                share = disparity_wrong(frame, view, rectified, pair, later)
                if share is not None:
                    low[view] = share
        wrong = misplaced(frame, told, pair) if told is not None else {}
        both = all(eye.depth_m is not None for eye in frame.eyes)
        if both and told is not None and not wrong:
            off = surface_offset(frame, told, pair, self._skew_s)
            if off is not None:
                moved = changed(frame, self._good) if self._good is not None else []
                for view in moved or low or VIEWS:
                    wrong[view] = (
                        f"with {other_depth(frame, view)}, puts the visible surface of {off[0]} "
                        f"{1e3 * off[1]:.3g} mm from where {TRUTH} has it"
                    )
        self.faults += [Fault(frame.file("depth", view), wrong[view]) for view in sorted(wrong)]
        if wrong:
            return
        self.faults += [
            Fault(
                frame.file("disparity", view),
                f"{share:.1%} of its pixels lie elsewhere than {frame.file('depth', view)}",
            )
            for view, share in low.items()
        ]
        for view in VIEWS:
            if frame.eyes[view].matches is not None:
                later = still and view == 1
                self.faults += correspondence_faults(frame, view, pair, later)
        if not both:
            return
        closings = [closing(frame, view, pair, still) for view in VIEWS]
        bad = [view for view in VIEWS if not closings[view].good]
        self.faults += [closing_fault(frame, view, closings[view]) for view in bad]
        if not bad:
            self._good = self._good or frame
            self._pictures(frame, closings[0].crossing, pair)

    def _pictures(
        self, frame: Frame, crossing: Crossing, sights: tuple[PixelRays, PixelRays]
    ) -> None:
        self.faults += exchanged_faults(frame, crossing)
        self.faults += exchanged_faults(frame, crossing, "clean")
        came = [view for view in VIEWS if frame.eyes[view].picture is not None]
        if len(came) == 1:
            self._lone.append((came[0], frame))
        if self._still is None:
            self._still = closing(frame, 0, sights, still=True).crossing

    def check_backgrounds(self, tree: Tree, count: int) -> None:
        """The person-free pictures, and by them those whose other eye did not arrive."""
        first: tuple[Image, Image] | None = None
        for index in range(count):
            folders = [f"background_{camera}" for camera in CAMERAS]
            files = [f"{self._sequence.name}/{f}/{picture_name(index)}" for f in folders]
            pictures = []
            for folder, file in zip(folders, files, strict=True):
                if file not in tree.plain:
                    continue
                try:
                    pictures.append(self._sequence.picture(folder, index, np.uint8, 3))
                except BenchError as error:
                    self.faults.append(fault_of(error, tree.root))
            if len(pictures) < len(VIEWS) or self._still is None:
                continue
            pair = pictures[0], pictures[1]
            if views_swapped(pair, self._still):
                self.faults += [Fault(files[view], wrong_eye(view)) for view in VIEWS]
            elif first is None:
                first = pair
        if first is not None:
            for view, frame in self._lone:
                self.faults += lone_fault(frame, view, first)
