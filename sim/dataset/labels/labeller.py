"""Labels of a simulation's frames, from the very poses and renders of its pictures."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pjpdaf.arrays import Floats, Image
from sim.camera.render import StereoRenderer, ViewRender
from sim.dataset.labels.classes import classes_of
from sim.dataset.labels.flow import Moment, ViewFlow
from sim.dataset.labels.instances import FIRST_OBJECT, Instances, instances_of
from sim.dataset.labels.keypoints import Keypoints
from sim.dataset.labels.masks import box_of, hidden
from sim.dataset.labels.records import (
    CENTRE_KEYPOINTS,
    NOT_LABELLED,
    FlowLabels,
    FrameLabels,
    Matches,
    ObjectState,
    ViewLabels,
)
from sim.dataset.labels.skeletons import Skeletons
from sim.dataset.labels.stereo import Depths, Float32s, PicturePair, RectifiedPair
from sim.dataset.labels.truncation import IdealPixels, pixels_inside, touches_border, truncation
from sim.labels import VELOCITY_STEP_S
from sim.pose import Pose, Transform
from sim.scene.world import World
from sim.sequence import RenderedFrame, Simulation
from sim.vectors import about_z

DISPARITY, CORRESPONDENCE = "disparity", "correspondence"
SEMANTIC, NORMALS, FLOW = "semantic", "normals", "flow"


class Labeller:
    """Labels the frames of a simulation; shots stay as `Simulation.render` gives them.

    wanted: of WANTED, the expensive labels. Raises ValueError for an unknown label.

    With shutter skew the right view is exposed later. Its own labels (depth, instances, masks,
    keypoints) are of its picture's moment; rectified and matches, of both views, are of the left
    view's moment, so that both pixels of a match show the same point.
    """

    WANTED: ClassVar[tuple[str, ...]] = (DISPARITY, CORRESPONDENCE, SEMANTIC, NORMALS, FLOW)

    def __init__(self, simulation: Simulation, wanted: Collection[str] = WANTED) -> None:
        unknown = sorted(set(wanted) - set(self.WANTED))
        if unknown:
            raise ValueError(f"unknown labels {unknown}; known: {list(self.WANTED)}")
        self.simulation = simulation
        world, scene = simulation.world, simulation.performance.scene
        self.instances: Instances = instances_of(world)
        self._keypoints = Keypoints(scene.anatomy)
        self._skeletons = Skeletons(world)
        self._rectified = RectifiedPair(world.rig, world.lenses) if DISPARITY in wanted else None
        self._matches = PicturePair(world.rig, world.lenses) if CORRESPONDENCE in wanted else None
        self._classes = classes_of(world) if SEMANTIC in wanted else None
        self._draws_normals = NORMALS in wanted
        self._flows = (
            [ViewFlow(*own) for own in zip(world.rig.cameras, world.lenses, strict=True)]
            if FLOW in wanted
            else None
        )
        self._moments: dict[int, tuple[Moment, Moment]] = {}  # of the last two frames
        self._ideal = [
            IdealPixels.of(camera, lens) if lens else None
            for camera, lens in zip(world.rig.cameras, world.lenses, strict=True)
        ]

    def labelled(self, index: int) -> tuple[RenderedFrame, FrameLabels]:
        """Render and label the frame of this index; the same in any order of indices."""
        rendered = self.simulation.render(index, self._render_extras)
        script, scene = self.simulation.performance.script, self.simulation.performance.scene
        skew_s = scene.sensor.skew_s
        right_pose = script.pose(rendered.truth.time_s + skew_s) if skew_s > 0 else rendered.pose
        poses = rendered.pose, right_pose
        depths = [_depth(view) for view in rendered.views]
        first: _ExtraRenders = rendered.hook_results[0]
        pair = depths[0], depths[1] if first.other is None else first.other
        rectified: ViewMatches = (None, None)
        matches: ViewMatches = (None, None)
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
        if self._flows is not None:
            second: _ExtraRenders = rendered.hook_results[1]
            assert first.moment is not None
            assert second.moment is not None
            self._moments = {k: self._moments[k] for k in list(self._moments)[-1:]}
            self._moments[index] = first.moment, second.moment
        parts = (rendered.pose.head, *rendered.pose.hands)
        labels = FrameLabels(
            quaternions=_quaternions(np.array([part.rotation for part in parts])),
            keypoints_m=self._keypoints.positions(rendered.pose),
            skeleton_m=self._skeletons.positions(rendered.pose),
            finger_angles_rad=self._skeletons.finger_angles(rendered.pose),
            views=(left, right),
            objects=self._objects(rendered.pose),
        )
        return replace(rendered, hook_results=(None, None)), labels

    def flow(self, index: int) -> FlowLabels:
        """Optical flow between the frame of this index and the next.

        Each view's is between its own two moments. Frames that were not among the last two
        labelled are rendered. Raises ValueError where the label `flow` was not wanted.
        """
        if self._flows is None:
            raise ValueError("the label flow was not wanted")
        before, after = (self._moments.get(k) or self._moment(k) for k in (index, index + 1))
        pairs = list(zip(self._flows, before, after, strict=True))
        left, right = (flow.between(one, other) for flow, one, other in pairs)
        left_back, right_back = (flow.between(other, one) for flow, one, other in pairs)
        return FlowLabels((left, right), (left_back, right_back))

    def _moment(self, index: int) -> tuple[Moment, Moment]:
        self.labelled(index)
        return self._moments[index]

    def _render_extras(
        self, world: World, renderer: StereoRenderer, index: int, view: ViewRender
    ) -> _ExtraRenders:
        assert view.amodal is not None
        inside = beyond = None
        if any(not mask.any() or touches_border(mask) for mask in view.amodal):
            beyond = renderer.amodal_beyond(index)
            inside = pixels_inside(world, self._ideal[index], view.amodal)
        rectified = other = None
        if index == 0:
            pair, skewed = self._rectified, bool(world.scene and world.scene.sensor.skew_s > 0)
            if pair is not None and pair.drawn:
                left, right = (_metres(*renderer.pinhole(camera)) for camera in pair.cameras)
                rectified = left, right
            if skewed and (self._matches is not None or (pair is not None and not pair.drawn)):
                other = _depth(renderer.view(1, colour=False, amodal=False))
        assert view.geoms is not None
        normals = renderer.normals(index, view.geoms) if self._draws_normals else None
        moment = Moment.of(world, view.geoms, _depth(view)) if self._flows is not None else None
        return _ExtraRenders(inside, beyond, rectified, other, normals, moment)

    def _view(
        self, index: int, rendered: RenderedFrame, pose: Pose, depth_m: Float32s
    ) -> ViewLabels:
        """Labels of a view without its matches; pose: of the view's own moment."""
        view, world = rendered.views[index], self.simulation.world
        assert view.geoms is not None
        assert view.amodal is not None
        instances = self.instances.ids(view.geoms)
        camera, lens = world.rig.cameras[index], world.lenses[index]
        pixels, status = self._keypoints.project(pose, camera, lens, instances, depth_m)
        joints, joint_status = self._skeletons.project(pose, camera, lens, view.geoms, depth_m)
        counts = np.bincount(instances.ravel(), minlength=self.instances.highest + 1)
        extra: _ExtraRenders = rendered.hook_results[index]
        in_frame = status[list(CENTRE_KEYPOINTS)] != NOT_LABELLED
        return ViewLabels(
            depth_m=depth_m,
            instances=instances,
            amodal=view.amodal,
            amodal_boxes_px=np.array([box_of(mask) for mask in view.amodal]),
            truncation=truncation(view.amodal, extra.inside, extra.beyond, in_frame),
            hidden_px=hidden(view.amodal, instances, self.instances.highest),
            keypoints_px=pixels,
            keypoint_status=status,
            skeleton_px=joints,
            skeleton_status=joint_status,
            objects_px=counts[FIRST_OBJECT:].astype(np.int64),
            classes=None if self._classes is None else np.take(self._classes, view.geoms),
            normals=extra.normals,
        )

    def _objects(self, pose: Pose) -> tuple[ObjectState, ...]:
        """The objects in the order of the scene."""
        performance = self.simulation.performance
        room = performance.scene.room
        before_s = max(pose.time_s - VELOCITY_STEP_S, 0.0)
        after_s = pose.time_s + VELOCITY_STEP_S
        before, after = (performance.script.pose(t).objects for t in (before_s, after_s))
        states = []
        for spec in room.objects:
            name = spec.name
            if name in pose.objects:
                at = pose.objects[name]
                moved = after[name].position_m - before[name].position_m
            else:  # a pose need not name an object that stands where the scene has it
                base_m = room.table_height_m if spec.base_m is None else spec.base_m
                position = np.array([*spec.position_xy_m, base_m])
                at, moved = Transform(position, about_z(spec.yaw_rad)), np.zeros(3)
            quaternion = _quaternions(at.rotation[None])[0]
            velocity = moved / (after_s - before_s)
            states.append(ObjectState(name, at.position_m, quaternion, velocity))
        return tuple(states)


ViewMatches = tuple[Matches, Matches] | tuple[None, None]


@dataclass(frozen=True, eq=False)
class _ExtraRenders:
    """Renders for labels alone, made while the world stands in a view's pose.

    inside, beyond (T,): amodal pixels for `truncation`, where a target may be cut off. Of the left
    view only: rectified, depths of the rectified pair; other, the right view's depth at the left
    view's moment. normals, moment: of the view, where wanted.
    """

    inside: NDArray[np.int64] | None
    beyond: NDArray[np.int64] | None
    rectified: Depths | None
    other: Float32s | None
    normals: Image | None
    moment: Moment | None


def _depth(view: ViewRender) -> Float32s:
    assert view.depth_m is not None
    assert view.geoms is not None
    return _metres(view.depth_m, view.geoms)


def _metres(depth_m: Float32s, geoms: NDArray[np.int32]) -> Float32s:
    """Depth with NaN for nothing."""
    return np.where(geoms >= 0, depth_m, np.float32(np.nan))


def _quaternions(rotations: Floats) -> Floats:
    """w >= 0, x, y, z (n, 4) of rotations (n, 3, 3)."""
    turns = Rotation.from_matrix(rotations)
    return np.asarray(turns.as_quat(canonical=True, scalar_first=True))
