"""Labels of a simulation's frames, from the very poses and renders of its pictures."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.targets import TARGETS
from sim.camera.rays import cast
from sim.camera.render import StereoRenderer, ViewRender
from sim.dataset.labels.instances import FIRST_OBJECT, Instances, instances_of
from sim.dataset.labels.keypoints import Keypoints
from sim.dataset.labels.records import (
    CENTRE_KEYPOINTS,
    NOT_LABELLED,
    FrameLabels,
    Matches,
    ObjectState,
    ViewLabels,
)
from sim.dataset.labels.stereo import Depths, Float32s, PicturePair, RectifiedPair
from sim.labels import VELOCITY_STEP_S
from sim.lens import Lens, real_pixels
from sim.pose import Pose, Transform
from sim.scene.world import World
from sim.sequence import RenderedFrame, Simulation
from sim.vectors import about_z

DISPARITY, CORRESPONDENCE = "disparity", "correspondence"


class Labeller:
    """Labels the frames of a simulation; shots stay as `Simulation.render` gives them.

    wanted: of WANTED, the labels that cost more; raises ValueError for another word.

    With shutter skew the right view is exposed later. Its own labels (depth, instances, masks,
    keypoints) are of its picture's moment; rectified and matches, of both views, are of the left
    view's moment, so that each pair of points is one point.
    """

    WANTED: ClassVar[tuple[str, ...]] = (DISPARITY, CORRESPONDENCE)

    def __init__(self, simulation: Simulation, wanted: Collection[str] = WANTED) -> None:
        unknown = sorted(set(wanted) - set(self.WANTED))
        if unknown:
            raise ValueError(f"unknown labels {unknown}; known: {list(self.WANTED)}")
        self.simulation = simulation
        world, scene = simulation.world, simulation.performance.scene
        self.instances: Instances = instances_of(world)
        self._keypoints = Keypoints(scene.anatomy)
        self._rectified = RectifiedPair(world.rig, world.lenses) if DISPARITY in wanted else None
        self._matches = PicturePair(world.rig, world.lenses) if CORRESPONDENCE in wanted else None
        self._bent = [
            _Bent.of(camera, lens) if lens else None
            for camera, lens in zip(world.rig.cameras, world.lenses, strict=True)
        ]

    def labelled(self, index: int) -> tuple[RenderedFrame, FrameLabels]:
        """The rendered of this index with its labels; any order, any time, the same."""
        rendered = self.simulation.render(index, self._render_extras)
        script, scene = self.simulation.performance.script, self.simulation.performance.scene
        skew_s = scene.sensor.skew_s
        poses = (
            rendered.pose,
            script.pose(rendered.truth.time_s + skew_s) if skew_s > 0 else rendered.pose,
        )
        depths = [_depth(view) for view in rendered.views]
        first: _ExtraRenders = rendered.hook_results[0]
        pair = depths[0], depths[1] if first.other is None else first.other
        rectified: Both = (None, None)
        matches: Both = (None, None)
        if self._rectified is not None:
            rectified = self._rectified.matches(first.rectified or pair)
        if self._matches is not None:
            matches = self._matches.matches(pair)
        left, right = (
            replace(
                self._view(view, rendered, poses[view], depths[view]),
                rectified=rectified[view],
                matches=matches[view],
            )
            for view in (0, 1)
        )
        parts = (rendered.pose.head, *rendered.pose.hands)
        labels = FrameLabels(
            quaternions=_quaternions(np.array([part.rotation for part in parts])),
            keypoints_m=self._keypoints.places(rendered.pose),
            views=(left, right),
            objects=self._objects(rendered.pose),
        )
        return replace(rendered, hook_results=(None, None)), labels

    def _render_extras(
        self, world: World, renderer: StereoRenderer, index: int, view: ViewRender
    ) -> _ExtraRenders:
        assert view.amodal is not None
        inside = beyond = None
        if any(not mask.any() or touches_border(mask) for mask in view.amodal):
            beyond = renderer.amodal_beyond(index)
            inside = self._inside(world, index, view.amodal)
        rectified = other = None
        if index == 0:
            pair, skewed = self._rectified, bool(world.scene and world.scene.sensor.skew_s > 0)
            if pair is not None and pair.drawn:
                left, right = (_metres(*renderer.pinhole(camera)) for camera in pair.cameras)
                rectified = left, right
            if skewed and (self._matches is not None or (pair is not None and not pair.drawn)):
                other = _depth(renderer.view(1, colour=False, amodal=False))
        return _ExtraRenders(inside, beyond, rectified, other)

    def _view(
        self, index: int, rendered: RenderedFrame, pose: Pose, depth_m: Float32s
    ) -> ViewLabels:
        """One view's labels but for those of the pair; pose: of its own moment."""
        view, world = rendered.views[index], self.simulation.world
        assert view.geoms is not None
        assert view.amodal is not None
        instances = self.instances.ids(view.geoms)
        pixels, status = self._keypoints.seen(
            pose, world.rig.cameras[index], world.lenses[index], instances, depth_m
        )
        counts = np.bincount(instances.ravel(), minlength=self.instances.highest + 1)
        looked: _ExtraRenders = rendered.hook_results[index]
        in_frame = status[list(CENTRE_KEYPOINTS)] != NOT_LABELLED
        return ViewLabels(
            depth_m=depth_m,
            instances=instances,
            amodal=view.amodal,
            amodal_boxes_px=np.array([box_of(mask) for mask in view.amodal]),
            truncation=truncation(view.amodal, looked.inside, looked.beyond, in_frame),
            hidden_px=hidden(view.amodal, instances, self.instances.highest),
            keypoints_px=pixels,
            keypoint_status=status,
            objects_px=counts[FIRST_OBJECT:].astype(np.int64),
        )

    def _inside(self, world: World, index: int, amodal: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Pixels (T,) of the amodal masks, of the raster in which `amodal_beyond` counts."""
        bent = self._bent[index]
        if bent is None:
            return np.asarray(np.count_nonzero(amodal, axis=(1, 2)), np.int64)
        skins = np.append(world.targets, np.int8(-1))
        counts = np.zeros(len(amodal), np.int64)
        for target, (mask, group) in enumerate(zip(amodal, world.amodal_groups, strict=True)):
            if mask.any():
                pixels = bent.around(box_of(mask))
                geoms, _ = cast(world, bent.ideal, pixels, (group,))
                counts[target] = np.count_nonzero(skins[geoms] == target)
        return counts

    def _objects(self, pose: Pose) -> tuple[ObjectState, ...]:
        """All objects in the order of the scene."""
        performance = self.simulation.performance
        room = performance.scene.room
        before_s = max(pose.time_s - VELOCITY_STEP_S, 0.0)
        after_s = pose.time_s + VELOCITY_STEP_S
        before, after = (performance.script.pose(t).objects for t in (before_s, after_s))
        states = []
        for thing in room.objects:
            name = thing.name
            if name in pose.objects:
                at = pose.objects[name]
                moved = after[name].position_m - before[name].position_m
            else:  # a pose need not name what stands where the scene has it
                base_m = room.table_height_m if thing.base_m is None else thing.base_m
                place = np.array([*thing.position_xy_m, base_m])
                at, moved = Transform(place, about_z(thing.yaw_rad)), np.zeros(3)
            quaternion = _quaternions(at.rotation[None])[0]
            velocity = moved / (after_s - before_s)
            states.append(ObjectState(name, at.position_m, quaternion, velocity))
        return tuple(states)


Both = tuple[Matches, Matches] | tuple[None, None]


@dataclass(frozen=True, eq=False)
class _ExtraRenders:
    """What is rendered for labels alone while the world stands in a view's pose.

    Where a target may be cut off, inside (T,): pixels of its amodal mask inside the picture, beyond
    (T,): with those beyond it, of one raster. With the left view also rectified: depths of the
    rectified pair; other: the right view's depth at the left's moment.
    """

    inside: NDArray[np.int64] | None
    beyond: NDArray[np.int64] | None
    rectified: Depths | None
    other: Float32s | None


@dataclass(frozen=True, eq=False)
class _Bent:
    """The ideal picture of a view with a lens: its camera, and those of its pixels (n, 2) that the
    real picture shows, with their places (n, 2) there.
    """

    ideal: Camera
    pixels: Floats
    real: Float32s

    @staticmethod
    def of(camera: Camera, lens: Lens) -> _Bent:
        rows, columns = np.mgrid[: lens.ideal.height_px, : lens.ideal.width_px]
        pixels = np.column_stack([columns.ravel(), rows.ravel()]).astype(np.float64)
        at = (pixels + camera.K[:2, 2] - lens.ideal.K[:2, 2]).astype(np.float32)
        real = np.column_stack(real_pixels(camera, lens, at[:, 0], at[:, 1]))
        size = np.array([camera.width_px, camera.height_px])
        inside = ((real >= -0.5) & (real < size - 0.5)).all(axis=1)
        return _Bent(lens.ideal, pixels[inside], real[inside])

    def around(self, box: Floats) -> Floats:
        """The ideal pixels (n, 2) in and just around a box of real ones."""
        low, high = box[:2] - 1, box[:2] + box[2:]
        return self.pixels[((self.real >= low) & (self.real <= high)).all(axis=1)]


def box_of(mask: NDArray[np.bool_]) -> Floats:
    """x, y, width, height (4,) of a mask, NaN where it is empty."""
    columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
    if len(rows) == 0:
        return np.full(4, np.nan)
    x, y = columns[0], rows[0]
    return np.array([x, y, columns[-1] - x + 1, rows[-1] - y + 1], np.float64)


def touches_border(mask: NDArray[np.bool_]) -> bool:
    """Whether a mask reaches the picture's border."""
    return bool(mask[[0, -1]].any() or mask[:, [0, -1]].any())


def truncation(
    amodal: NDArray[np.bool_],
    inside: NDArray[np.int64] | None,
    beyond: NDArray[np.int64] | None,
    in_frame: NDArray[np.bool_],
) -> Floats:
    """Share (T,) of each target's amodal pixels that lies outside the picture.

    Exactly 0 for a mask that is clear of the border. inside (T,): pixels inside the picture; beyond
    (T,): with those beyond its border, out to half the picture's size; of one raster, with a lens
    the ideal picture's; None where no target can be cut off. in_frame (T,): whether the target's
    centre is in the picture; of one that shows nowhere (its own hair hides it, or it is farther
    out) this decides for 0 or 1.
    """
    share = np.zeros(len(amodal))
    if inside is None or beyond is None:
        return share
    for target, mask in enumerate(amodal):
        if not mask.any():
            share[target] = beyond[target] > 0 or not in_frame[target]
        elif touches_border(mask):
            share[target] = max(1 - float(inside[target]) / max(float(beyond[target]), 1.0), 0.0)
    return share


def hidden(
    amodal: NDArray[np.bool_], instances: NDArray[np.uint8], highest: int
) -> NDArray[np.int64]:
    """Pixels (T, highest + 1) of each target's amodal mask that show another instance."""
    found = np.array([np.bincount(instances[mask], minlength=highest + 1) for mask in amodal])
    found[np.arange(len(TARGETS)), 1 + np.arange(len(TARGETS))] = 0
    return found.astype(np.int64)


def _depth(view: ViewRender) -> Float32s:
    assert view.depth_m is not None
    assert view.geoms is not None
    return _metres(view.depth_m, view.geoms)


def _metres(depth_m: Float32s, geoms: NDArray[np.int32]) -> Float32s:
    """Depth with NaN where nothing is."""
    return np.where(geoms >= 0, depth_m, np.float32(np.nan))


def _quaternions(rotations: Floats) -> Floats:
    """w >= 0, x, y, z (n, 4) of rotations (n, 3, 3)."""
    turns = Rotation.from_matrix(rotations)
    return np.asarray(turns.as_quat(canonical=True, scalar_first=True))
