"""Our renderer against MuJoCo's: CPU time of the same stereo frames in one process, and pictures.

python examples/renderers.py cross                       # ratios
python examples/renderers.py cross --picture OUT.png     # and the looks, side by side
"""

from __future__ import annotations

import copy
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import cv2
import numpy as np

from pjpdaf.arrays import Image
from scenarios.execute.local import local_executor
from scenarios.play.footage import performance_of
from scenarios.play.job import Job, System
from scenarios.play.play import play_complete
from scenarios.spec.names import load_scenario
from sim.camera.canvas import render_pass
from sim.gl import context, load_mujoco
from sim.processes import Answer
from sim.scene.world import CAMERAS
from sim.sequence import Simulation

FRAMES, SIZE = (6, 12, 18), (480, 640)
DOUBLE = 2 * SIZE[0], 2 * SIZE[1]
EPISODE_FRAMES = 24
Timed = Callable[[], object]


class Bare:
    """MuJoCo's low-level functions, doing the passes of `run`: colour, ids and depth, amodal ids.

    At our quality: 2 x 2 samples, a shadow map of 1024, each pass read back.
    """

    def __init__(self, simulation: Simulation) -> None:
        mujoco = self._mujoco = load_mujoco()
        world = self._world = simulation.world
        self._scene = mujoco.MjvScene(world.model, maxgeom=world.model.ngeom + 50)
        self._context = mujoco.MjrContext(world.model, mujoco.mjtFontScale.mjFONTSCALE_100)
        self._option = mujoco.MjvOption()

    def render(self) -> Image:
        """Both views; the left picture, RGB."""
        flags = self._mujoco.mjtRndFlag
        lit = flags.mjRND_SHADOW, flags.mjRND_CULL_FACE
        ids = flags.mjRND_SEGMENT, flags.mjRND_IDCOLOR, flags.mjRND_CULL_FACE
        pictures = []
        context()  # mujoco.Renderer has one of its own
        self._mujoco.mjr_setBuffer(self._mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        for name in CAMERAS:
            self._show(name, range(6))
            rgb = render_pass(self._scene, self._context, DOUBLE, lit, with_depth=False)[0]
            pictures.append(cv2.resize(rgb, SIZE[::-1], interpolation=cv2.INTER_AREA)[::-1])
            render_pass(self._scene, self._context, SIZE, ids, with_depth=True)
            for group in self._world.amodal_groups:
                self._show(name, (group,))
                render_pass(self._scene, self._context, SIZE, ids, with_depth=False)
        return np.asarray(pictures[0])

    def close(self) -> None:
        self._context.free()

    def _show(self, name: str, groups: Any) -> None:
        mujoco, world = self._mujoco, self._world
        self._option.geomgroup[:] = [group in groups for group in range(6)]
        camera = mujoco.MjvCamera()
        camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        camera.fixedcamid = world.model.camera(name).id
        every = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(
            world.model, world.data, self._option, None, camera, every, self._scene
        )


@contextmanager
def documented(simulation: Simulation) -> Iterator[Callable[[], Image]]:
    """`mujoco.Renderer` as its documentation shows it, at its default quality.

    Gives a function that renders colour, depth and segmentation of both views; the left picture.
    """
    mujoco = load_mujoco()
    model = copy.deepcopy(simulation.world.model)
    defaults = mujoco.MjSpec().visual.quality
    for name in ("shadowsize", "offsamples", "numslices", "numstacks", "numquads"):
        setattr(model.vis.quality, name, getattr(defaults, name))
    option = mujoco.MjvOption()
    option.geomgroup[:] = 1  # hands, too
    with mujoco.Renderer(model, *SIZE) as renderer:

        def render() -> Image:
            pictures = []
            for name in CAMERAS:
                renderer.update_scene(simulation.world.data, camera=name, scene_option=option)
                pictures.append(renderer.render())
                renderer.enable_depth_rendering()
                renderer.render()
                renderer.disable_depth_rendering()
                renderer.enable_segmentation_rendering()
                renderer.render()
                renderer.disable_segmentation_rendering()
            return np.asarray(pictures[0])

        yield render


def cpu_s(work: Timed) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def measure(name: str) -> tuple[dict[str, float], list[Image]]:
    """CPU time [s] of a stereo frame by each way, the least of three rounds; pictures, BGR."""
    overrides = {"frames": EPISODE_FRAMES, "background_frames": 10}
    job = Job(load_scenario(name), 7000, overrides, System(), use_cache=False)
    times: dict[str, float] = {}
    pictures: list[Image] = []
    with Simulation(performance_of(job)) as simulation:
        renderer = simulation._renderer
        for index in FRAMES:
            simulation.world.place(simulation.performance.script.pose(index / simulation.fps))
            bare = Bare(simulation)
            with documented(simulation) as render:
                ways: dict[str, Timed] = {
                    "mujoco.Renderer, as documented": render,
                    "ours: the same": lambda: renderer.render(amodal=False),
                    "MuJoCo's functions, passes of run": bare.render,
                    "ours: passes of run": renderer.render,
                }
                for way, work in ways.items():
                    work()
                    spent = min(cpu_s(work) for _ in range(3))
                    times[way] = times.get(way, 0.0) + spent / len(FRAMES)
                if index == FRAMES[-1]:
                    pictures = [
                        cv2.cvtColor(p, cv2.COLOR_RGB2BGR) for p in (render(), bare.render())
                    ]
            bare.close()
        ours = renderer.view(0, labels=False, amodal=False).colour
        assert ours is not None
    times["run: a whole episode"] = cpu_s(lambda: play_complete(job)) / EPISODE_FRAMES
    return times, [*pictures, ours]


def main() -> None:
    name, *rest = sys.argv[1:]
    with local_executor(1) as executor:
        (done,) = filter(None, executor.outcomes(measure, {0: name}, 3600.0))
    assert isinstance(done[1], Answer), done[1]
    times, pictures = done[1].value
    for way, seconds in times.items():
        print(f"{1e3 * seconds:7.1f} ms  {way}")
    documented_s, same_s, bare_s, passes_s, whole_s = times.values()
    print(f"{documented_s / same_s:7.2f}  times as fast as mujoco.Renderer, as documented")
    print(f"{bare_s / passes_s:7.2f}  times as fast as MuJoCo's functions, passes of run")
    print(f"{bare_s / whole_s:7.2f}  rate of run against MuJoCo's functions, passes of run")
    print(f"{passes_s / whole_s:7.2f}  rate of run against our renderer, passes of run")
    if rest:
        cv2.imwrite(rest[1], np.hstack(pictures))


if __name__ == "__main__":
    os.environ.setdefault("PJPDAF_BENCH_CACHE", "off")
    main()
