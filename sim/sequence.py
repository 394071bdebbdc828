"""Renders a performance: stereo frames with their truth, and person-free background frames."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from pjpdaf.arrays import Image
from pjpdaf.camera import StereoRig
from pjpdaf.frames import StereoFrame
from sim import gl
from sim.camera import selftest
from sim.camera.clock import moment
from sim.camera.exposure import subframes
from sim.camera.miscalibration import miscalibrated
from sim.camera.render import StereoRenderer, ViewRender
from sim.camera.sensor import mean_light
from sim.camera.stereo_sensor import Light, background_frames, sense
from sim.labels import centres, truth_of, velocities
from sim.pose import Pose
from sim.scene.rig import stereo_rig
from sim.scene.world import CAMERAS, World, build
from sim.script import Performance
from sim.truth import Truth


@dataclass(frozen=True, eq=False)
class RenderedFrame:
    """A stereo frame with its truth and the clean renders behind it.

    frame: pictures as the cameras give them, None where a picture was lost. truth, pose: of the
    moment at which the frame was taken, whatever time the frame itself carries. light: what the
    sensors of both views were given, also where a picture was lost. views: clean
    renders of that moment, sharp even where the exposure blurs the pictures; with shutter skew the
    right view, and the right view's part of the truth, is of skew_s later. hook_results: return
    values of the `ViewHook` per view, None without a hook.
    """

    frame: StereoFrame
    truth: Truth
    light: Light
    views: tuple[ViewRender, ViewRender]
    pose: Pose
    hook_results: tuple[Any, Any] = (None, None)


# Called for each view (0 left, 1 right) while the world stands in the pose of its sharp render.
ViewHook = Callable[[World, StereoRenderer, int, ViewRender], Any]


class Simulation(AbstractContextManager["Simulation"]):
    """Renders a performance frame by frame: compiles the scene and opens the renderer once.

    rig: the cameras that film; calibration: the rig that a tracker is given, with the scene's
    calibration error. Close it or use `with`. Raises InfrastructureError where OpenGL is missing or
    fails the self-test, ValueError for a scene that cannot be built.
    """

    def __init__(self, performance: Performance) -> None:
        selftest.check_once()
        self.performance = performance
        self.rig = rig_of(performance)
        self.calibration = miscalibrated(self.rig, performance.scene.calibration_error)
        self._world = build(performance.scene)
        self._renderer = StereoRenderer(self._world, performance.script.pose(0.0))

    @property
    def fps(self) -> float:
        """Frame rate [1/s]."""
        return self.performance.fps

    @property
    def frame_count(self) -> int:
        """Number of frames."""
        return self.performance.frames

    @property
    def redrawn(self) -> int:
        """Number of rejected draws of the seed (`Performance`)."""
        return self.performance.redrawn

    @cached_property
    def renderer(self) -> str:
        """Description of the OpenGL renderer."""
        return gl.describe()

    @property
    def world(self) -> World:
        """The compiled scene; read only: `render` poses it."""
        return self._world

    def frames(self) -> Iterator[tuple[StereoFrame, Truth]]:
        """Yield all frames in order with their truth, at index / fps plus the clock's jitter."""
        for index in range(self.performance.frames):
            rendered = self.render(index)
            yield rendered.frame, rendered.truth

    def render(self, index: int, hook: ViewHook | None = None) -> RenderedFrame:
        """Render the frame of this index; the same bytes in any order of indices.

        hook: may render more of the world as it stands for a view, but must not pose it.
        """
        script, scene = self.performance.script, self.performance.scene
        now = moment(scene.clock, self.performance.fps, self.performance.seed, index, CAMERAS)
        pose = script.pose(now.time_s)
        if scene.sensor.skew_s > 0:
            later_s = now.time_s + scene.sensor.skew_s
            (left,) = self._expose_views(now.time_s, (0,), hook)
            (right,) = self._expose_views(later_s, (1,), hook)
            moved = centres(script.pose(later_s)) - centres(pose)
            moved_m = (np.zeros_like(moved), moved)
        else:
            left, right = self._expose_views(now.time_s, (0, 1), hook)
            moved_m = None
        views = left.view, right.view
        truth = truth_of(
            index,
            pose,
            velocities(script, now.time_s),
            views,
            self.rig.cameras,
            script.events(now.time_s),
            moved_m,
        )
        light = left.light, right.light
        pictures = sense(light, scene.sensor, self.performance.seed, index, now.time_s)
        arrived = tuple(p if came else None for p, came in zip(pictures, now.arrived, strict=True))
        frame = StereoFrame(index, now.stamp_s, arrived)
        hook_results = left.hook_result, right.hook_result
        return RenderedFrame(frame, truth, light, views, pose, hook_results)

    def background(self) -> list[StereoFrame]:
        """Render `background_frames` frames of the room at t = 0 without the person.

        Table, chair and objects stay. Each picture has noise of its own, independent of the noise
        of all frames. No picture is lost or late: a detector that learns can wait.
        """
        performance = self.performance
        count, sensor = performance.background_frames, performance.scene.sensor
        if count == 0:
            return []
        return background_frames(
            self.background_light(), count, performance.fps, sensor, performance.seed
        )

    def background_light(self) -> Light:
        """Render the light of the room at t = 0 without the person."""
        first = self.performance.script.pose(0.0)
        places = MappingProxyType({**first.objects, **self.performance.learnt})
        self._world.place(replace(first, objects=places))
        views = self._renderer.render(labels=False, amodal=False, person=False)
        return _colour(views[0]), _colour(views[1])

    def close(self) -> None:
        """Free the renderer; safe to call twice."""
        self._renderer.close()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _expose_views(
        self, time_s: float, cameras: tuple[int, ...], hook: ViewHook | None
    ) -> list[_ExposedView]:
        """Render these views (0 left, 1 right), each exposed around time_s."""
        script, exposure_s = self.performance.script, self.performance.scene.sensor.exposure_time_s
        moments = subframes(script, self.rig.cameras, exposure_s, time_s)
        middle = len(moments) // 2
        sharp: list[ViewRender] = []
        hook_results: list[Any] = []
        subframe_pictures: list[list[Image]] = [[] for _ in cameras]
        for k, t_s in enumerate(moments):
            self._world.place(script.pose(t_s))
            for pictures, camera in zip(subframe_pictures, cameras, strict=True):
                is_middle = k == middle
                view = self._renderer.view(camera, labels=is_middle, amodal=is_middle)
                pictures.append(_colour(view))
                if is_middle:
                    sharp.append(view)
                    result = hook(self._world, self._renderer, camera, view) if hook else None
                    hook_results.append(result)
        return [
            _ExposedView(view, mean_light(pictures), result)
            for view, pictures, result in zip(sharp, subframe_pictures, hook_results, strict=True)
        ]


@dataclass(frozen=True, eq=False)
class _ExposedView:
    """A view's sharp render, the mean light of its exposure, the hook's return value."""

    view: ViewRender
    light: Image
    hook_result: Any


def _colour(view: ViewRender) -> Image:
    assert view.colour is not None
    return view.colour


def rig_of(performance: Performance) -> StereoRig:
    """The exact rig of a performance's cameras."""
    return stereo_rig(performance.scene.rig)
