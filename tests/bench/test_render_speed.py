"""Where the time of a stereo frame goes. Ratios within one run; the clock never fails a test.

Run with `pytest tests/bench --benchmark-enable`.
"""

import time

import numpy as np
import pytest

from sim.camera.render import StereoRenderer
from sim.camera.sensor import expose
from sim.labels import truth_of
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
def renderers():
    """One that draws everything, and one that draws what differs from the still scene."""
    pose = rest_pose(SCENE.anatomy)
    world = build(SCENE)
    world.place(pose)
    with StereoRenderer(world) as whole, StereoRenderer(world, pose) as windows:
        whole.render()
        windows.render()
        yield {"whole": whole, "windows": windows}


@pytest.fixture(scope="module")
def renderer(renderers):
    return renderers["windows"]


@pytest.mark.parametrize("drawn", ["whole", "windows"])
@pytest.mark.parametrize("part", PARTS)
def test_stereo_frame(benchmark, renderers, part, drawn):
    benchmark.group = f"stereo frame: {part}"
    benchmark.pedantic(renderers[drawn].render, kwargs=PARTS[part], rounds=5, warmup_rounds=1)


def test_truth(benchmark, renderer):
    pose, views = rest_pose(SCENE.anatomy), renderer.render(colour=False)
    benchmark(truth_of, 0, pose, np.zeros((3, 3)), views, renderer.world.rig.cameras)


def test_place(benchmark, renderer):
    pose = rest_pose(SCENE.anatomy)
    benchmark(renderer.world.place, pose)


def test_noise(benchmark, renderer):
    picture = renderer.render(labels=False, amodal=False)[0].colour
    benchmark(expose, picture, SensorSpec(), 1, "left", 0)


def cpu_s(renderer, part):
    """CPU time, which other processes do not change much."""
    start = time.process_time()
    for _ in range(3):
        renderer.render(**PARTS[part])
    return time.process_time() - start


def test_labels_cost_less_than_colour(renderer):
    """About a third."""
    assert cpu_s(renderer, "labels") < cpu_s(renderer, "colour")


def test_windows_cost_less_than_whole_pictures(renderers):
    """About seven tenths."""
    assert cpu_s(renderers["windows"], "all") < 0.9 * cpu_s(renderers["whole"], "all")
