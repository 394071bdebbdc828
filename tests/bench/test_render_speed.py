"""Where the time of a stereo frame goes. Ratios within one run; the clock never fails a test.

Run with `pytest tests/bench --benchmark-enable`.
"""

import time

import pytest

from sim.camera.render import StereoRenderer
from sim.camera.sensor import expose
from sim.person.rest import rest_pose
from sim.scene.world import build
from sim.specs import RigSpec, SceneSpec, SensorSpec

SCENE = SceneSpec(rig=RigSpec(tilt_rad=0.28))
PARTS = {
    "colour": {"labels": False, "amodal": False},
    "labels": {"colour": False, "amodal": False},
    "amodal": {"colour": False, "labels": False},
    "all": {},
}


@pytest.fixture(scope="module")
def renderer():
    world = build(SCENE)
    world.place(rest_pose(SCENE.anatomy))
    with StereoRenderer(world) as opened:
        opened.render()
        yield opened


@pytest.mark.parametrize("part", PARTS)
def test_stereo_frame(benchmark, renderer, part):
    benchmark.group = "stereo frame"
    benchmark.pedantic(renderer.render, kwargs=PARTS[part], rounds=5, warmup_rounds=1)


def test_place(benchmark, renderer):
    pose = rest_pose(SCENE.anatomy)
    benchmark(renderer.world.place, pose)


def test_noise(benchmark, renderer):
    picture = renderer.render(labels=False, amodal=False)[0].colour
    benchmark(expose, picture, SensorSpec(), 1, "left", 0)


def test_labels_cost_less_than_colour(renderer):
    """CPU time, which other processes do not change much: about a fifth."""

    def cpu_s(part):
        start = time.process_time()
        for _ in range(3):
            renderer.render(**PARTS[part])
        return time.process_time() - start

    assert cpu_s("labels") < cpu_s("colour")
