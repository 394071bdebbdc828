"""Where the CPU time of a rendered episode goes, stage by stage.

python examples/profile_episode.py calm_table drink touch_face cross     # entries of the suite core
python examples/profile_episode.py cross frames=12                        # with changed parameters

The time of a stage is its own, without that of stages inside it. OpenGL is made to finish after
each pass, and Mesa draws in a worker's own thread, so that a pass has all of its own time.
"""

from __future__ import annotations

import functools
import importlib
import os
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from tempfile import TemporaryDirectory
from typing import Any

from scenarios.execute.local import local_executor
from scenarios.play.job import Job, System
from scenarios.play.plan import PlanRequest, plan
from scenarios.play.play import make_system, play_complete
from sim.gl import load_mujoco
from sim.processes import Answer
from sim.scene.rig import stereo_rig
from sim.specs import RigSpec

PASSES = ("shadow map", "colour pass", "ids pass", "amodal pass")
# Stage -> the functions that do it, each as module and name within it.
STAGES = {
    "drawing the scenario": ("scenarios.play.footage:performance_of",),
    "compiling the scene": ("sim.sequence:build",),
    "OpenGL context, textures": ("sim.camera.canvas:Canvas.__init__",),
    "self-test": ("sim.camera.selftest:check_once",),
    "the still scene": ("sim.camera.render:StereoRenderer._still_scene",),
    "pose and kinematics": ("sim.motion.motion:Performer.pose", "sim.scene.world:World.place"),
    "windows": ("sim.camera.still:StillScene.windows",),
    "scene to MuJoCo": ("mujoco:mjv_updateScene", "mujoco:mjv_addGeoms"),
    "read-back": ("mujoco:mjr_readPixels",),
    "colour: samples to pixels": ("sim.camera.render:StereoRenderer._colour",),
    "ids and depth to labels": ("sim.camera.render:StereoRenderer._labels",),
    "amodal masks": ("sim.camera.render:StereoRenderer._skin",),
    "truth": ("sim.sequence:truth_of",),
    "sensor": ("sim.sequence:sense", "sim.recording.recorder:background_frames"),
    "cache": (
        "sim.recording.writer:RecordingWriter.add_frame",
        "sim.recording.writer:RecordingWriter.finish",
    ),
    "blame, error budget": (
        "scenarios.play.play:with_blame",
        "scenarios.play.play:with_error_budget",
    ),
}
METHODS = {  # of whatever detector and tracker the preset is made of
    "detector": ("__call__",),
    "learning the background": ("learn",),
    "tracker": ("predict", "start", "step", "estimates"),
}
ONCE = (  # an episode
    "drawing the scenario",
    "compiling the scene",
    "OpenGL context, textures",
    "self-test",
    "the still scene",
    "learning the background",
)


class Stopwatch:
    """Adds up the CPU time [s] of stages, each without the stages inside it.

    A stage of ONCE keeps the time of what is inside it.
    """

    def __init__(self) -> None:
        self.spent_s: defaultdict[str, float] = defaultdict(float)
        self._stack: list[str] = []
        self._since_s = time.process_time()

    def enter(self, stage: str) -> None:
        self._charge()
        self._stack.append(stage)

    def leave(self) -> None:
        self._charge()
        self._stack.pop()

    def _charge(self) -> None:
        now_s = time.process_time()
        whole = next((stage for stage in self._stack if stage in ONCE), None)
        stage = whole or (self._stack[-1] if self._stack else "the rest")
        self.spent_s[stage] += now_s - self._since_s
        self._since_s = now_s

    def timed(self, stage_of: Callable[..., str], work: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(work)
        def wrapper(*arguments: Any, **options: Any) -> Any:
            self.enter(stage_of(*arguments))
            try:
                return work(*arguments, **options)
            finally:
                self.leave()

        return wrapper


def put_around(watch: Stopwatch, stage: str, owner: Any, name: str) -> None:
    """Let the stopwatch run for a stage while a function of a module or class runs."""
    setattr(owner, name, watch.timed(lambda *_: stage, getattr(owner, name)))


def attach(watch: Stopwatch) -> None:
    """Put the stopwatch around all stages of this process."""
    mujoco = load_mujoco()
    for stage, places in STAGES.items():
        for place in places:
            module, _, path = place.partition(":")
            *outer, name = path.split(".")
            owner = functools.reduce(getattr, outer, importlib.import_module(module))
            put_around(watch, stage, owner, name)
    for part in make_system(System(), stereo_rig(RigSpec())):
        for stage, names in METHODS.items():
            for name in filter(vars(type(part)).__contains__, names):
                put_around(watch, stage, type(part), name)
    render = mujoco.mjr_render

    def finished(viewport: Any, scene: Any, context: Any) -> None:
        render(viewport, scene, context)
        mujoco.mjr_finish()

    def pass_of(_: Any, scene: Any, __: Any) -> str:
        if scene.camera[0].orthographic:
            return PASSES[0]
        if not scene.flags[mujoco.mjtRndFlag.mjRND_SEGMENT]:
            return PASSES[1]
        return PASSES[2 if scene.ngeom > 60 else 3]

    mujoco.mjr_render = watch.timed(pass_of, finished)


def profile(jobs: Sequence[Job]) -> tuple[defaultdict[str, float], int]:
    """CPU time [s] of all stages of these jobs, and their stereo frames."""
    watch = Stopwatch()
    attach(watch)
    play_complete(Job(jobs[0].scenario, 0, {"frames": 2}, System(), use_cache=False))  # warms up
    watch.spent_s.clear()
    frames = 0
    for job in jobs:
        frames += len(play_complete(job).frames)
    watch.enter("")
    watch.leave()
    return watch.spent_s, frames


def main() -> None:
    settings = tuple(word for word in sys.argv[1:] if "=" in word)
    only = tuple(word for word in sys.argv[1:] if "=" not in word)
    jobs = plan(PlanRequest(("core",), 1, 7000, settings=settings, only=only))
    with TemporaryDirectory() as folder:
        os.environ["PJPDAF_BENCH_CACHE"] = folder
        with local_executor(1) as executor:
            (answer,) = filter(None, executor.outcomes(profile, {0: jobs}, 3600.0))
    assert isinstance(answer[1], Answer), answer[1]
    spent_s, frames = answer[1].value
    total_s = sum(spent_s.values())
    print(f"CPU time, {len(jobs)} episodes, {frames} stereo frames:")
    for stage in (*PASSES, *STAGES, *METHODS, "the rest"):
        if stage not in ONCE:
            print(f"  {stage:28} {1e3 * spent_s[stage] / frames:7.2f} ms a frame")
    for stage in ONCE:
        print(f"  {stage:28} {1e3 * spent_s[stage] / len(jobs):7.0f} ms an episode")
    print(f"  {'all':28} {1e3 * total_s / frames:7.1f} ms a frame")
    hours = total_s / len(jobs) / 3.6
    print(f"1000 episodes of {frames / len(jobs):.0f} frames: {hours:.1f} core-hours")


if __name__ == "__main__":
    main()
