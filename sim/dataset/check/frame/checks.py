"""All checks of the frames of a sequence, each before the checks that rest on it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from pjpdaf.arrays import Image
from sim.dataset.check.fault import FaultLog
from sim.dataset.check.files import FileTree
from sim.dataset.check.frame.arrays import FrameArrays, read_arrays
from sim.dataset.check.frame.closing import Correspondences, closing, closing_fault
from sim.dataset.check.frame.correspondence import check_correspondence
from sim.dataset.check.frame.depth import changed_views, check_targets, check_validity
from sim.dataset.check.frame.disparity import check_occlusion, disparity_fault, wrong_share
from sim.dataset.check.frame.float_twins import check_depth_twin, check_match_twins
from sim.dataset.check.frame.flow import check_flow
from sim.dataset.check.frame.masks import MaskView, check_amodal, check_seg
from sim.dataset.check.frame.normals import check_normals
from sim.dataset.check.frame.pixel_rays import RigRays
from sim.dataset.check.frame.semantics import check_classes
from sim.dataset.check.frame.view import FrameView
from sim.dataset.check.frame.view_order import (
    check_lone_view,
    check_view_order,
    views_swapped,
    wrong_view,
)
from sim.dataset.check.frame_tables import FrameTables
from sim.dataset.files.layout import picture_name
from sim.dataset.stored_sequence import StoredSequence
from sim.scene.world import CAMERAS

VIEWS = (0, 1)


class FrameChecks:
    """Checks the frames of a sequence one by one, then its backgrounds.

    labels: those of the data set; names: of the instances by id; tables: per frame, None where
    they are damaged; rays: None where the cameras are not usable.
    """

    def __init__(
        self,
        sequence: StoredSequence,
        tree: FileTree,
        labels: Collection[str],
        names: Mapping[int, str],
        tables: list[FrameTables] | None,
        rays: RigRays | None,
        log: FaultLog,
    ) -> None:
        self._sequence, self._tree, self._labels = sequence, tree, labels
        self._names, self._tables, self._rays, self._log = names, tables, rays, log
        self._reference: FrameArrays | None = None  # the first whose depth has no fault
        self._static_matches: Correspondences | None = None  # of table and room
        self._lone: list[tuple[int, FrameArrays]] = []
        self._classes: FrameArrays | None = None  # the first whose classes have no fault
        self._before: FrameArrays | None = None  # the frame before, if its depth has no fault
        self._normals: dict[int, FrameView] = {}  # by view, the last whose normals have no fault

    def check(self, index: int) -> None:
        """Check a frame."""
        log = self._log
        frame = read_arrays(self._sequence, self._tree, index, self._labels, log)
        tables = self._tables[index] if self._tables is not None else None
        trusted = [self._masks_hold(frame, view, tables) for view in VIEWS]
        start = len(log.faults)
        for view in VIEWS:
            if trusted[view]:
                log.add("depth", check_validity(frame, view))
            if frame.views[view].rectified is not None:
                log.add("occlusion", check_occlusion(frame, view))
        self._check_classes(frame, trusted)
        before, self._before = self._before, None
        if self._rays is not None and all(trusted):
            faults = len(log.faults)
            self._check_pair(frame, tables, self._rays)
            if len(log.faults) == faults:
                self._check_surfaces(frame, before, self._rays)
                self._before = frame
        named = {fault.file for fault in log.faults[start:]}
        for view in VIEWS:
            # The twin of a faulty file need not be named.
            if frame.file("depth", view) not in named:
                log.add("float", check_depth_twin(frame, view))
            if not named & {frame.file(label, view) for label in ("disparity", "correspondence")}:
                log.add("float", check_match_twins(frame, view))

    def _masks_hold(self, frame: FrameArrays, view: int, tables: FrameTables | None) -> bool:
        """Check the masks of a view; whether other checks may rest on its ids."""
        arrays = frame.views[view]
        if arrays.seg is None:
            return False
        if tables is None:
            return True
        masks = MaskView(frame, view, tables, self._names)
        if self._log.add("seg", check_seg(masks)):
            return False
        if arrays.amodal is not None:
            self._log.add("amodal", check_amodal(masks))
        return True

    def _check_pair(self, frame: FrameArrays, tables: FrameTables | None, rays: RigRays) -> None:
        """Check depth and matches of both views; only depth where that is faulty."""
        log, views = self._log, [FrameView(frame, view, rays) for view in VIEWS]
        shares = {}
        for view in views:
            if view.own.depth_m is not None and view.own.rectified is not None:
                share = wrong_share(view)
                if share is not None:
                    shares[view.view] = share

        def suspects() -> Collection[int]:
            changed = changed_views(frame, self._reference) if self._reference else []
            return changed or shares or VIEWS

        if tables is not None and log.add("depth", check_targets(frame, tables, rays, suspects)):
            return
        log.add("disparity", [disparity_fault(views[v], share) for v, share in shares.items()])
        for view in views:
            if view.own.matches is not None:
                log.add("correspondence", check_correspondence(view))
        if any(view.own.depth_m is None for view in views):
            return
        closings = [closing(view, static_only=rays.skew_s > 0) for view in views]
        faults = [
            closing_fault(view, result)
            for view, result in zip(views, closings, strict=True)
            if not result.good
        ]
        if not log.add("depth", faults):
            self._reference = self._reference or frame
            self._check_pictures(views[0], closings[0].matches)

    def _check_classes(self, frame: FrameArrays, trusted: Sequence[bool]) -> None:
        faulty = False
        there = [v for v in VIEWS if trusted[v] and frame.views[v].classes is not None]
        for view in there:
            faulty |= self._log.add("semantic", check_classes(frame, view, self._classes))
        if len(there) == len(VIEWS) and not faulty:
            self._classes = self._classes or frame

    def _check_surfaces(
        self, frame: FrameArrays, before: FrameArrays | None, rays: RigRays
    ) -> None:
        """Check normals, and the flow from the frame before and back to it."""
        for view in VIEWS:
            own = FrameView(frame, view, rays)
            last = None if before is None else FrameView(before, view, rays)
            if own.own.normals is not None:
                faults = check_normals(own, self._normals.get(view))
                if not self._log.add("normals", faults):
                    self._normals[view] = own
            if last is None or before is None:
                continue
            if last.own.forward is not None:
                tables = self._pair(before.index, frame.index)
                self._log.add("flow", check_flow(last, own, tables, "flow_forward"))
            if own.own.backward is not None:
                tables = self._pair(frame.index, before.index)
                self._log.add("flow", check_flow(own, last, tables, "flow_backward"))

    def _pair(self, one: int, other: int) -> tuple[FrameTables, FrameTables] | None:
        return None if self._tables is None else (self._tables[one], self._tables[other])

    def _check_pictures(self, left: FrameView, matches: Correspondences) -> None:
        frame = left.frame
        self._log.add("view order", check_view_order(frame, matches))
        self._log.add("view order", check_view_order(frame, matches, "clean"))
        arrived = [view for view in VIEWS if frame.views[view].picture is not None]
        if len(arrived) == 1:
            self._lone.append((arrived[0], frame))
        if self._static_matches is None:
            self._static_matches = closing(left, static_only=True).matches

    def check_backgrounds(self, count: int) -> None:
        """Check the order of the person-free pictures, and by them the pictures without partner."""
        reference: tuple[Image, Image] | None = None
        for index in range(count):
            name = self._sequence.name
            folders = [f"background_{camera}" for camera in CAMERAS]
            files = [f"{name}/{folder}/{picture_name(index)}" for folder in folders]
            left, right = (
                self._background(folder, file, index)
                for folder, file in zip(folders, files, strict=True)
            )
            if left is None or right is None or self._static_matches is None:
                continue
            if views_swapped((left, right), self._static_matches):
                self._log.add("view order", [wrong_view(files[view], view) for view in VIEWS])
            elif reference is None:
                reference = left, right
        if reference is not None:
            for view, frame in self._lone:
                self._log.add("view order", check_lone_view(frame, view, reference))

    def _background(self, folder: str, file: str, index: int) -> Image | None:
        if file not in self._tree.plain:
            return None
        return self._log.read(lambda: self._sequence.picture(folder, index, np.uint8, 3))
