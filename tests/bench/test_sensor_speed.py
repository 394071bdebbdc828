"""What each effect of a camera costs: a picture through the sensor, a stereo frame as a whole.

Run with --benchmark-enable. Nothing here fails by the clock.
"""

from __future__ import annotations

from dataclasses import replace

import pytest

from sim.camera.sensor import expose, mean_light
from sim.person.rest import rest_pose
from sim.script import Performance
from sim.sequence import Simulation
from sim.specs import ClockSpec, RigSpec, SceneSpec, SensorSpec

SCENE = SceneSpec(rig=RigSpec(tilt_rad=0.28))
NONE = SensorSpec(noise_sd=0.0)
OF_A_PICTURE = {
    "none": NONE,
    "read noise": SensorSpec(noise_sd=3.0),
    "read and shot noise": SensorSpec(noise_sd=3.0, shot_noise_sd=4.0),
    "gains of the light": replace(NONE, exposure_ev=0.5, white_balance_rgb=(1.2, 1.0, 0.8)),
    "jpeg 60": replace(NONE, jpeg_quality=60),
    "jpeg 95": replace(NONE, jpeg_quality=95),
}
OF_A_FRAME = {
    "none": {},
    "blur, 8 px": {"sensor": replace(NONE, exposure_time_s=0.016)},
    "shutter skew": {"sensor": replace(NONE, skew_s=0.03)},
    "jitter": {"clock": ClockSpec(jitter_s=0.02)},
    "lens": {"rig": replace(SCENE.rig, distortion=(-0.3, 0.1, 0.0, 0.0))},
}


class Sliding:
    """The right hand slides at 1 m/s: 0.5 px a ms."""

    def pose(self, t_s):
        palms = ((0.34, -0.32 + 1.0 * t_s, 0.77), (0.34, 0.25, 0.77))
        return rest_pose(SCENE.anatomy, palms_m=palms, time_s=t_s)

    def events(self, t_s):
        return ()


def played(**changed):
    scene = replace(SCENE, sensor=NONE)
    return Performance(replace(scene, **changed), Sliding(), 5, 15.0, 1, seed=100)


@pytest.fixture(scope="module")
def picture():
    with Simulation(played()) as simulation:
        return simulation.render(2).frame.pictures[0]


@pytest.mark.benchmark(group="sensor, one picture of 640x480")
@pytest.mark.parametrize("effect", OF_A_PICTURE)
def test_a_picture(benchmark, picture, effect):
    benchmark(expose, picture, OF_A_PICTURE[effect], 1, "left", 0)


@pytest.mark.benchmark(group="sensor, one picture of 640x480")
def test_the_mean_of_five_pictures(benchmark, picture):
    benchmark(mean_light, [picture] * 5)


@pytest.mark.sample(1)
@pytest.mark.benchmark(group="stereo frame with truth")
@pytest.mark.parametrize("effect", OF_A_FRAME)
def test_a_frame(benchmark, effect):
    with Simulation(played(**OF_A_FRAME[effect])) as simulation:
        benchmark.pedantic(simulation.render, args=(2,), rounds=5, warmup_rounds=1)
