"""Plays a performance: stereo frames with their truth, and the person-free background."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from types import MappingProxyType, TracebackType
from typing import Any

import numpy as np

from pjpdaf.camera import StereoRig
from pjpdaf.frames import StereoFrame
from sim.camera import selftest
from sim.camera.clock import moment
from sim.camera.exposure import subframes
from sim.camera.miscalibration import miscalibrated
from sim.camera.render import StereoRenderer, ViewRender
from sim.camera.sensor import Picture, expose, mean_light
from sim.labels import centres, truth_of, velocities
from sim.pose import Pose
from sim.scene.rig import stereo_rig
from sim.scene.world import CAMERAS, World, build
from sim.script import Performance
from sim.truth import Truth


@dataclass(frozen=True, eq=False)
class Shot:
    """One frame with all that is known of it.

    frame: pictures as the cameras give them, None where one was lost. truth: of the moment at which
    the frame was taken, whatever time the frame itself carries. pose: of that moment. views: clean
    renders, sharp even where the exposure blurs the pictures: of that moment too, but with shutter
    skew the right one, and with it the right view's part of the truth, is of skew_s later. looks:
    what the `Look` said of each view, where one was given.
    """

    frame: StereoFrame
    truth: Truth
    views: tuple[ViewRender, ViewRender]
    pose: Pose
    looks: tuple[Any, Any] = (None, None)


# Called for each view (0 left, 1 right) while the world stands in the pose of its sharp render.
Look = Callable[[World, StereoRenderer, int, ViewRender], Any]


class Simulation:
    """One performance, ready to play: compiles the scene and opens the renderer once.

    rig: the cameras that film; calibration: what a tracker is told of them, with the scene's
    calibration error. Close it or use `with`. Raises InfrastructureError where OpenGL is missing or
    fails the self-test, ValueError for a scene that cannot be built.
    """

    def __init__(self, performance: Performance) -> None:
        selftest.check_once()
        self.performance = performance
        self.rig = rig_of(performance)
        self.calibration = miscalibrated(self.rig, performance.scene.calibration_error)
        self._world = build(performance.scene)
        self._renderer = StereoRenderer(self._world)

    @property
    def fps(self) -> float:
        """Frames a second."""
        return self.performance.fps

    @property
    def frame_count(self) -> int:
        """Frames."""
        return self.performance.frames

    @property
    def redrawn(self) -> int:
        """How many draws of its seed were thrown away (`Performance`)."""
        return self.performance.redrawn

    def frames(self) -> Iterator[tuple[StereoFrame, Truth]]:
        """All frames in order, at times index / fps where the clock has no jitter."""
        for index in range(self.performance.frames):
            shot = self.shot(index)
            yield shot.frame, shot.truth

    def shots(self) -> Iterator[Shot]:
        """All frames in order, with their clean renders (for data sets)."""
        for index in range(self.performance.frames):
            yield self.shot(index)

    def shot(self, index: int, look: Look | None = None) -> Shot:
        """The frame of this index; any order, any time, the same bytes.

        look: may render more of the world, as it stands for a view; it must not pose it.
        """
        script, scene = self.performance.script, self.performance.scene
        now = moment(scene.clock, self.performance.fps, self.performance.seed, index, CAMERAS)
        pose = script.pose(now.time_s)
        if scene.sensor.skew_s > 0:
            later_s = now.time_s + scene.sensor.skew_s
            (left,), (right,) = (
                self._filmed(now.time_s, (0,), look),
                self._filmed(later_s, (1,), look),
            )
            moved = centres(script.pose(later_s)) - centres(pose)
            moved_m = (np.zeros_like(moved), moved)
        else:
            left, right = self._filmed(now.time_s, (0, 1), look)
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
        pictures = self._exposed(index, now.time_s, (left.light, right.light), "")
        arrived = tuple(p if came else None for p, came in zip(pictures, now.arrived, strict=True))
        frame = StereoFrame(index, now.stamp_s, arrived)
        return Shot(frame, truth, views, pose, (left.look, right.look))

    def background(self) -> list[StereoFrame]:
        """`background_frames` pictures of the room at t = 0 without the person, for learning.

        Table, chair and objects stay. Each has noise of its own, apart from all frames' noise. All
        are there and in time: whoever learns can wait.
        """
        if self.performance.background_frames == 0:
            return []
        first = self.performance.script.pose(0.0)
        places = MappingProxyType({**first.objects, **self.performance.learnt})
        self._world.place(replace(first, objects=places))
        views = self._renderer.render(labels=False, amodal=False, person=False)
        light = _colour(views[0]), _colour(views[1])
        frames = []
        for index in range(self.performance.background_frames):
            t_s = index / self.performance.fps
            pictures = self._exposed(index, t_s, light, "background/")
            frames.append(StereoFrame(index, t_s, pictures))
        return frames

    def close(self) -> None:
        """Free the renderer; safe to call twice."""
        self._renderer.close()

    def __enter__(self) -> Simulation:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def world(self) -> World:
        """The compiled scene; only looked at from outside."""
        return self._world

    def _filmed(self, time_s: float, which: tuple[int, ...], look: Look | None) -> list[_Filmed]:
        """These views as they are exposed around time_s."""
        script, exposure_s = self.performance.script, self.performance.scene.sensor.exposure_time_s
        moments = subframes(script, self.rig.cameras, exposure_s, time_s)
        middle = len(moments) // 2
        sharp: list[ViewRender] = []
        looks: list[Any] = []
        light: list[list[Picture]] = [[] for _ in which]
        for k, t_s in enumerate(moments):
            self._world.place(script.pose(t_s))
            for pictures, camera in zip(light, which, strict=True):
                full = k == middle
                view = self._renderer.view(camera, labels=full, amodal=full)
                pictures.append(_colour(view))
                if full:
                    sharp.append(view)
                    looks.append(look and look(self._world, self._renderer, camera, view))
        parts = zip(sharp, light, looks, strict=True)
        return [_Filmed(view, mean_light(pictures), said) for view, pictures, said in parts]

    def _exposed(
        self, index: int, t_s: float, light: tuple[Picture, Picture], stream: str
    ) -> tuple[Picture, Picture]:
        sensor, seed = self.performance.scene.sensor, self.performance.seed
        left, right = (
            expose(picture, sensor, seed, f"{stream}{camera}", index, t_s + delay_s)
            for picture, camera, delay_s in zip(light, CAMERAS, (0.0, sensor.skew_s), strict=True)
        )
        return left, right


@dataclass(frozen=True, eq=False)
class _Filmed:
    """A view in the middle of its exposure, the picture of the whole of it, what a look said."""

    view: ViewRender
    light: Picture
    look: Any


def _colour(view: ViewRender) -> Picture:
    assert view.colour is not None
    return view.colour


def rig_of(performance: Performance) -> StereoRig:
    """The exact calibration of a performance's cameras."""
    return stereo_rig(performance.scene.rig)


def simulate(performance: Performance) -> Iterator[tuple[StereoFrame, Truth]]:
    """All frames of a performance with their truth, in order."""
    with Simulation(performance) as simulation:
        yield from simulation.frames()


def background(performance: Performance) -> list[StereoFrame]:
    """The performance's person-free frames."""
    with Simulation(performance) as simulation:
        return simulation.background()
