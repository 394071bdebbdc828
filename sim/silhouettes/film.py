"""A performance as silhouettes: outlines of its shapes in every view and frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pjpdaf.camera import StereoRig
from pjpdaf.frames import StereoFrame
from sim.camera.clock import Moment, moment
from sim.camera.miscalibration import miscalibrated
from sim.pose import Transform
from sim.scene.rig import stereo_rig
from sim.scene.world import CAMERAS
from sim.script import Performance
from sim.silhouettes.hidden import below_table
from sim.silhouettes.outlines import Outlines, outlines_of
from sim.silhouettes.person import person_bars, person_hulls
from sim.silhouettes.pose_track import PoseTrack, pose_track
from sim.silhouettes.shapes import Bars, Hull, joined
from sim.silhouettes.things import thing_shapes
from sim.specs import SceneSpec


@dataclass(frozen=True, eq=False)
class Film:
    """Silhouettes of a performance of F frames in N views.

    rig: the cameras that film; calibration: as a tracker is given it; moments (F): of the frames;
    track: poses at these moments; outlines: of each view.
    """

    performance: Performance
    rig: StereoRig
    calibration: StereoRig
    moments: tuple[Moment, ...]
    track: PoseTrack
    outlines: tuple[Outlines, ...]

    @property
    def frame_count(self) -> int:
        """Frames."""
        return len(self.moments)

    def frames(self) -> list[StereoFrame]:
        """The frames, without pictures: index and time stamp."""
        nothing = (None,) * len(self.outlines)
        return [StereoFrame(i, m.stamp_s, nothing) for i, m in enumerate(self.moments)]


def film_of(performance: Performance, step_px: int, everything: bool) -> Film:
    """The film of a performance, its pictures reduced by a whole number step_px.

    everything: paint clothes and things too, not only skin and what may cover it. With a shutter
    skew the right view shows the poses of its own moment. Motion blur is left out.
    """
    scene, script = performance.scene, performance.script
    rig = stereo_rig(scene.rig)
    moments = tuple(_moments(performance))
    times_s = [m.time_s for m in moments]
    track = pose_track(script, scene.anatomy, times_s)
    tracks = [track, track]
    if scene.sensor.skew_s > 0:
        later_s = [t_s + scene.sensor.skew_s for t_s in times_s]
        tracks[1] = pose_track(script, scene.anatomy, later_s)
    return Film(
        performance=performance,
        rig=rig,
        calibration=miscalibrated(rig, scene.calibration_error),
        moments=moments,
        track=track,
        outlines=_outlines(performance, rig, tracks, step_px, everything),
    )


def _moments(performance: Performance) -> list[Moment]:
    scene, fps, seed = performance.scene, performance.fps, performance.seed
    clock = scene.clock
    if clock.jitter_s == 0 and clock.dropped == 0:  # no draw can change anything
        times = (np.arange(performance.frames) / fps).tolist()
        return [Moment(t_s, t_s, (True,) * len(CAMERAS)) for t_s in times]
    return [moment(clock, fps, seed, i, CAMERAS) for i in range(performance.frames)]


def _outlines(
    performance: Performance,
    rig: StereoRig,
    tracks: list[PoseTrack],
    step_px: int,
    everything: bool,
) -> tuple[Outlines, ...]:
    scene = performance.scene
    outlines = []
    shapes = _shapes(scene, tracks[0], performance.learnt, everything)
    for track, camera in zip(tracks, rig.cameras, strict=True):
        if track is not tracks[0]:
            shapes = _shapes(scene, track, performance.learnt, everything)
        bars, hulls = shapes
        hidden = below_table(bars, scene.room, camera.centre_w)
        outlines.append(outlines_of(bars, hulls, camera, step_px, everything, hidden))
    return tuple(outlines)


def _shapes(
    scene: SceneSpec, track: PoseTrack, learnt: Mapping[str, Transform], clothes: bool
) -> tuple[Bars, list[Hull]]:
    anatomy, looks = scene.anatomy, scene.appearance
    bars, hulls = thing_shapes(track, scene, learnt)
    return (
        joined([person_bars(track, anatomy, looks), *bars]),
        [*person_hulls(track, anatomy, looks, scene.room.table_height_m, clothes), *hulls],
    )
