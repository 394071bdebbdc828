"""Plays a performance: stereo frames with their truth, and the person-free background."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from types import MappingProxyType, TracebackType

import numpy as np

from pjpdaf.camera import StereoRig
from pjpdaf.frames import StereoFrame
from sim import selftest
from sim.labels import truth_of, velocities
from sim.pose import Pose
from sim.render import StereoRenderer, ViewRender
from sim.rig import stereo_rig
from sim.script import Performance
from sim.sensor import expose
from sim.truth import Truth
from sim.world import CAMERAS, build


@dataclass(frozen=True, eq=False)
class Shot:
    """One frame with all that is known of it: noisy pictures, truth, clean renders, pose."""

    frame: StereoFrame
    truth: Truth
    views: tuple[ViewRender, ViewRender]
    pose: Pose


class Simulation:
    """One performance, ready to play: compiles the scene and opens the renderer once.

    Close it or use `with`. Raises InfrastructureError where OpenGL is missing or fails the
    self-test, ValueError for a scene that cannot be built.
    """

    def __init__(self, performance: Performance) -> None:
        selftest.check_once()
        self.performance = performance
        self.rig = rig_of(performance)
        self.calibration = self.rig
        self._world = build(performance.scene)
        self._renderer = StereoRenderer(self._world)

    def frames(self) -> Iterator[tuple[StereoFrame, Truth]]:
        """All frames in order, at times index / fps."""
        for index in range(self.performance.frames):
            shot = self.shot(index)
            yield shot.frame, shot.truth

    def shots(self) -> Iterator[Shot]:
        """All frames in order, with their clean renders (for data sets)."""
        for index in range(self.performance.frames):
            yield self.shot(index)

    def shot(self, index: int) -> Shot:
        """The frame of this index; any order, any time, the same bytes."""
        script = self.performance.script
        t_s = index / self.performance.fps
        pose = script.pose(t_s)
        self._world.place(pose)
        views = self._renderer.render()
        frame = self._exposed(index, t_s, views, "")
        truth = truth_of(
            index, pose, velocities(script, t_s), views, self.rig.cameras, script.events(t_s)
        )
        return Shot(frame, truth, views, pose)

    def background(self) -> list[StereoFrame]:
        """`background_frames` pictures of the room at t = 0 without the person, for learning.

        Table, chair and objects stay. Each has noise of its own, apart from all frames' noise.
        """
        first = self.performance.script.pose(0.0)
        places = MappingProxyType({**first.objects, **self.performance.learnt})
        self._world.place(replace(first, objects=places))
        views = self._renderer.render(labels=False, amodal=False, person=False)
        return [
            self._exposed(index, index / self.performance.fps, views, "background/")
            for index in range(self.performance.background_frames)
        ]

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

    def _exposed(
        self, index: int, t_s: float, views: tuple[ViewRender, ViewRender], stream: str
    ) -> StereoFrame:
        pictures: list[np.ndarray | None] = []
        sensor, seed = self.performance.scene.sensor, self.performance.seed
        for camera, view in zip(CAMERAS, views, strict=True):
            assert view.colour is not None
            pictures.append(expose(view.colour, sensor, seed, f"{stream}{camera}", index))
        return StereoFrame(index, t_s, tuple(pictures))


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
