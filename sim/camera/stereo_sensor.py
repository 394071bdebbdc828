"""The sensors of both views: the light that reaches them becomes the pictures of a stereo frame."""

from __future__ import annotations

from pjpdaf.arrays import Image
from pjpdaf.frames import StereoFrame
from sim.camera.sensor import expose
from sim.scene.world import CAMERAS
from sim.specs import SensorSpec

Light = tuple[Image, Image]  # of both views, each (h, w, 3): what the sensors are given


def sense(
    light: Light, sensor: SensorSpec, seed: int, index: int, t_s: float, stream: str = ""
) -> tuple[Image, Image]:
    """The pictures of both views. stream: prefix of the streams of their noise."""
    left, right = (
        expose(picture, sensor, seed, f"{stream}{camera}", index, t_s + delay_s)
        for picture, camera, delay_s in zip(light, CAMERAS, (0.0, sensor.skew_s), strict=True)
    )
    return left, right


def background_frames(
    light: Light, count: int, fps: float, sensor: SensorSpec, seed: int
) -> list[StereoFrame]:
    """Frames of an empty room, each with noise of its own, independent of that of all others."""
    return [
        StereoFrame(
            index, index / fps, sense(light, sensor, seed, index, index / fps, "background/")
        )
        for index in range(count)
    ]
