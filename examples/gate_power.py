"""Does the gate see bugs, and nothing where there is none?

    python examples/gate_power.py [--suite smoke --suite core] [--seeds 1] [--out runs/gate_power]

Each episode is rendered once; on its frames play the unchanged system, each seeded bug and each
harmless change. Then every one of them is compared with the unchanged system.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from pjpdaf.camera import Camera, StereoRig
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.plugins.registry import make_detector, make_tracker
from reports.gate.gate import compare
from reports.run.load import SavedRun, load
from reports.run.rows import EpisodeRows, rows_of
from reports.run.save import RunInfo, save
from reports.score.records import EpisodeFailure
from scenarios.execute.local import local_executor, worker_count
from scenarios.play.job import Job, System, digest_of
from scenarios.play.plan import PlanRequest, plan
from scenarios.play.play import complete_episode
from scenarios.run.save_run import scenario_record
from scenarios.spec.draw import perform
from sim.processes import Lost
from sim.sequence import Simulation

PRESET = "thesis"
NOTHING = "nothing at all"
TIME_LIMIT_S = 3600.0  # of one episode with all its changes


@dataclass(frozen=True)
class Kept:
    """Footage with its pictures as PNG bytes."""

    fps: float
    frame_count: int
    redrawn: int
    rig: StereoRig
    calibration: StereoRig
    learnt: tuple
    shot: tuple

    def background(self) -> list[StereoFrame]:
        return [opened(frame) for frame in self.learnt]

    def frames(self) -> Iterator:
        for frame, truth in self.shot:
            yield opened(frame), truth


def packed(frame: StereoFrame) -> StereoFrame:
    pictures = [p if p is None else cv2.imencode(".png", p)[1] for p in frame.pictures]
    return replace(frame, pictures=tuple(pictures))


def opened(frame: StereoFrame) -> StereoFrame:
    pictures = [p if p is None else cv2.imdecode(p, cv2.IMREAD_COLOR) for p in frame.pictures]
    return replace(frame, pictures=tuple(pictures))


def kept(job: Job) -> Kept:
    with Simulation(perform(job.scenario, job.seed, job.overrides)) as simulation:
        return Kept(
            simulation.fps,
            simulation.frame_count,
            simulation.redrawn,
            simulation.rig,
            simulation.calibration,
            tuple(packed(frame) for frame in simulation.background()),
            tuple((packed(frame), truth) for frame, truth in simulation.frames()),
        )


# --- what is wrong with a system -----------------------------------------------------------------


def every(change: Callable, kept: Kept) -> Kept:
    """A change of every picture: (view, picture, frame index) -> picture."""

    def changed(frame: StereoFrame) -> StereoFrame:
        pictures = opened(frame).pictures
        out = [p if p is None else change(v, p, frame.index) for v, p in enumerate(pictures)]
        return packed(replace(frame, pictures=tuple(out)))

    return replace(
        kept,
        learnt=tuple(map(changed, kept.learnt)),
        shot=tuple((changed(frame), truth) for frame, truth in kept.shot),
    )


def flipped(kept: Kept) -> Kept:
    return every(lambda v, p, i: cv2.flip(p, 1) if v else p, kept)


def views_swapped(kept: Kept) -> Kept:
    def swapped(frame: StereoFrame) -> StereoFrame:
        return replace(frame, pictures=frame.pictures[::-1])

    return replace(
        kept,
        learnt=tuple(map(swapped, kept.learnt)),
        shot=tuple((swapped(frame), truth) for frame, truth in kept.shot),
    )


def hue(shift: int) -> Callable:
    def turned(view: int, picture: np.ndarray, index: int) -> np.ndarray:
        hsv = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV)
        hsv[..., 0] = (hsv[..., 0].astype(int) + shift) % 180
        return cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)

    return lambda film: every(turned, film)


def rgb(kept: Kept) -> Kept:
    return every(lambda v, p, i: p[..., ::-1].copy(), kept)


def shifted(view: int, dx: float) -> Callable:
    M = np.array([[1.0, 0.0, dx], [0.0, 1.0, 0.0]])

    def moved(v: int, picture: np.ndarray, index: int) -> np.ndarray:
        size = picture.shape[1::-1]
        return cv2.warpAffine(picture, M, size, borderMode=1) if v == view else picture

    return lambda film: every(moved, film)


def late(views: tuple[int, ...]) -> Callable:
    """These views show the frame before."""

    def delayed(kept: Kept) -> Kept:
        before = kept.shot[0][0].pictures
        out = []
        for frame, truth in kept.shot:
            now = frame.pictures
            mixed = tuple(before[v] if v in views else now[v] for v in range(2))
            out.append((replace(frame, pictures=mixed), truth))
            before = now
        return replace(kept, shot=tuple(out))

    return delayed


def clock(factor: float) -> Callable:
    def timed(kept: Kept) -> Kept:
        shot = tuple((replace(f, time_s=factor * f.time_s), truth) for f, truth in kept.shot)
        return replace(kept, shot=shot)

    return timed


def calibrated(change: Callable[[Camera], Camera]) -> Callable:
    """Another right camera than the one that films."""

    def wrong(kept: Kept) -> Kept:
        rig = kept.calibration
        return replace(kept, calibration=StereoRig(rig.left, change(rig.right)))

    return wrong


def baseline(kept: Kept) -> Kept:
    """Its sign: the right camera as far to the left of the left one."""
    left, right = kept.calibration.cameras
    centre = 2 * left.centre_w - right.centre_w
    moved = replace(right, t_cw=-right.R_cw @ centre)
    return replace(kept, calibration=StereoRig(left, moved))


def turned(camera: Camera) -> Camera:
    R = cv2.Rodrigues(np.array([0.0, np.radians(1.0), 0.0]))[0]
    return replace(camera, R_cw=R @ camera.R_cw, t_cw=R @ camera.t_cw)


def longer(camera: Camera) -> Camera:
    K = np.array(camera.K)
    K[0, 0] *= 1.05
    K[1, 1] *= 1.05
    return replace(camera, K=K)


def no_background(kept: Kept) -> Kept:
    """The person sits there while the background is learnt."""
    return replace(kept, learnt=tuple(frame for frame, _ in kept.shot[:10]))


class Wrapped:
    """A part of the system with one thing changed."""

    def __init__(self, inner: object) -> None:
        self.inner = inner

    def __getattr__(self, name: str) -> object:
        return getattr(self.inner, name)


class MirroredDepth(Wrapped):
    """Estimates of the hands exchanged once they are 10 s old."""

    def start(self, seen):
        state = self.inner.start(seen)
        return None if state is None else (state, 0.0)

    def step(self, state, seen, dt_s):
        inner, said = self.inner.step(state[0], seen, dt_s)
        age = state[1] + dt_s
        return (inner, age), exchanged(said) if age > 6 else said

    def estimates(self, state):
        return self.inner.estimates(state[0])

    def predict(self, state, dt_s):
        return self.inner.predict(state[0], dt_s)


def exchanged(said: Estimates) -> Estimates:
    order = [0, 2, 1]
    return Estimates(
        said.positions_m[order],
        said.covariances_m2[order],
        said.velocities_mps[order],
        tuple(said.status[i] for i in order),
    )


class OneBehind(Wrapped):
    """Says what it believed a frame ago."""

    def start(self, seen):
        state = self.inner.start(seen)
        return None if state is None else (state, self.inner.estimates(state))

    def step(self, state, seen, dt_s):
        inner, said = self.inner.step(state[0], seen, dt_s)
        return (inner, said), state[1]

    def estimates(self, state):
        return state[1]

    def predict(self, state, dt_s):
        return self.inner.predict(state[0], dt_s)


class HalfSilent(Wrapped):
    """Crashes at its 20th frame."""

    def step(self, state, seen, dt_s):
        self.steps = getattr(self, "steps", 0) + 1
        if self.steps == 20:
            raise RuntimeError("seeded crash")
        return self.inner.step(state, seen, dt_s)


class Detector(Wrapped):
    """A detector whose output passes through `change`."""

    def __init__(self, inner: object, change: Callable[[Detections], Detections]) -> None:
        super().__init__(inner)
        self.change = change

    def learn(self, background):
        return Detector(self.inner.learn(background), self.change)

    def __call__(self, frame, predicted=None):
        return tuple(self.change(view) for view in self.inner(frame, predicted))


def order(view: Detections) -> Detections:
    return chosen(view, np.arange(len(view))[::-1])


def chosen(view: Detections, rows: np.ndarray) -> Detections:
    return Detections(
        view.centres_px[rows],
        view.covariances_px2[rows],
        view.ellipses[rows],
        view.areas_px[rows],
        view.missing,
    )


def largest_two(view: Detections) -> Detections:
    return chosen(view, np.argsort(-view.areas_px, kind="stable")[:2])


def nudged(size: float) -> Callable[[Detections], Detections]:
    """Centres changed by rounding errors of this size [px]: another order of sums."""

    def change(view: Detections) -> Detections:
        rng = np.random.default_rng(len(view))
        return replace(view, centres_px=view.centres_px + rng.normal(0, size, (len(view), 2)))

    return change


def single(view: Detections) -> Detections:
    return replace(view, centres_px=view.centres_px.astype(np.float32).astype(np.float64))


def tracker(kind: Callable) -> Callable:
    return lambda cameras: kind(make_tracker(PRESET, cameras, {}))


def detector(change: Callable) -> Callable:
    return lambda cameras: Detector(make_detector(PRESET, cameras, {}), change)


one_behind, crash, late_swap = tracker(OneBehind), tracker(HalfSilent), tracker(MirroredDepth)
reordered, two_blobs = detector(order), detector(largest_two)
rounding, float32, seed_like = detector(nudged(1e-9)), detector(single), detector(nudged(0.02))


def own(name: str) -> str:
    return f"gate_power:{name}"


def settings(part: str, **values: str) -> System:
    changed = {key: str(value) for key, value in values.items()}
    return System(PRESET, PRESET, **{f"{part}_settings": changed})


BUGS: dict[str, System | Callable[[Kept], Kept]] = {
    "R x 4": settings("tracker", measurement_px2=60),
    "R x 100": settings("tracker", measurement_px2=1500),
    "gate off": settings("tracker", gate=1e6),
    "gate far too small": settings("tracker", gate=0.5),
    "P_D 0.5": settings("tracker", p_detect=0.5),
    "clutter x 1000": settings("tracker", clutter=100),
    "position noise / 64": settings("tracker", process_position_m2=50e-6),
    "no occlusion rule": settings("tracker", occlusion="none"),
    "printed sum of beta_0, stacked": settings("tracker", beta_0="sum", update="stacked"),
    "one view flipped": flipped,
    "views exchanged": views_swapped,
    "baseline's sign": baseline,
    "right camera turned by 1 degree": calibrated(turned),
    "right focal length + 5 %": calibrated(longer),
    "right picture 3 px aside": shifted(1, 3.0),
    "right picture 1 px aside": shifted(1, 1.0),
    "dt x 3": clock(3.0),
    "right view a frame late": late((1,)),
    "both views a frame late": late((0, 1)),
    "estimates a frame late": System(PRESET, own("one_behind")),
    "hue + 30 degrees": hue(15),
    "red and blue exchanged": rgb,
    "person in the background": no_background,
    "saturation range too narrow": settings("detector", saturation_range="0.45,0.6"),
    "smallest blob x 10": settings("detector", min_area_px=1500),
    "two blobs at most": System(own("two_blobs"), PRESET),
    "hands exchanged after 6 s": System(PRESET, own("late_swap")),
    "crash at frame 20": System(PRESET, own("crash")),
}

HARMLESS: dict[str, System | Callable[[Kept], Kept]] = {
    "detections in another order": System(own("reordered"), PRESET),
    "sums in another order (1e-9 px)": System(own("rounding"), PRESET),
    "centres in single precision": System(own("float32"), PRESET),
    "another k-means seed (0.02 px)": System(own("seed_like"), PRESET),
    NOTHING: System(PRESET, PRESET),
}


# --- playing -------------------------------------------------------------------------------------


def play_all(job: Job) -> dict[str, EpisodeRows]:
    """Every change on one episode."""
    cv2.setNumThreads(1)
    film = kept(job)
    return {name: play_one(job, film, change) for name, change in {**BUGS, **HARMLESS}.items()}


def play_one(job: Job, film: Kept, change: System | Callable[[Kept], Kept]) -> EpisodeRows:
    try:
        if isinstance(change, System):
            return rows_of(complete_episode(replace(job, system=change), film))
        return rows_of(complete_episode(job, change(film)))
    except Exception as fault:
        return rows_of(
            EpisodeFailure(job.name, job.seed, str(fault), job.scenario.group, digest_of(job))
        )


def jobs_of(suite: str, seeds: int) -> list[Job]:
    request = PlanRequest((suite,), seeds, detector=PRESET, tracker=PRESET)
    # A scenario of two suites is another episode in each.
    return [replace(job, label=f"{suite}.{job.name}", keep_pictures=False) for job in plan(request)]


def main() -> None:
    parser = argparse.ArgumentParser(description="Seeded bugs against the gate.")
    parser.add_argument("--suite", action="append")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("runs/gate_power"))
    options = parser.parse_args()
    jobs = [job for s in options.suite or ["smoke", "core"] for job in jobs_of(s, options.seeds)]
    # Under its own name, not `__main__`: workers find it, and its plug-ins, by that name.
    module = importlib.import_module("gate_power")
    episodes: dict[int, dict[str, EpisodeRows]] = {}
    with local_executor(worker_count(None)) as executor:
        for outcome in executor.outcomes(module.play_all, dict(enumerate(jobs)), TIME_LIMIT_S):
            if outcome is None:
                continue
            index, answer = outcome
            if isinstance(answer, Lost):
                raise SystemExit(f"{jobs[index].name} seed {jobs[index].seed}: no result: {answer}")
            episodes[index] = answer.value
            sys.stderr.write(f"\r{len(episodes)} of {len(jobs)} episodes")
    played = {name: [episodes[i][name] for i in sorted(episodes)] for name in {**BUGS, **HARMLESS}}
    entries = {job.name: scenario_record(job) for job in jobs}
    runs = {
        name: load(save(options.out / f"{n:02d}", rows, RunInfo(name, entries=entries)))
        for n, (name, rows) in enumerate(played.items())
    }
    report(runs)


def report(runs: dict[str, SavedRun]) -> None:
    base = runs[NOTHING]
    print("| change | verdict | metrics that fail | error mm | missed % | swapped, lost % |")
    print("|---|---|---|---:|---:|---|")
    caught, flagged = 0, 0
    for name, run in runs.items():
        verdict = compare(base, run)
        by = {m.metric.name: m for m in verdict.metrics}
        failed = [m.metric.name for m in verdict.metrics if m.verdict == "fail"]
        caught += name in BUGS and verdict.verdict == "fail"
        flagged += name in HARMLESS and verdict.verdict == "fail"
        words = f"{verdict.verdict}, identical" if verdict.identical else verdict.verdict
        print(
            f"| {'bug' if name in BUGS else 'harmless'}: {name} | {words} | "
            f"{', '.join(failed) or '-'} | {by['error_mm'].base:.1f} → {by['error_mm'].new:.1f} | "
            f"{100 * by['missed'].base:.1f} → {100 * by['missed'].new:.1f} | "
            f"{100 * by['swapped'].new:.0f}, {100 * by['lost'].new:.0f} |"
        )
    print(f"\n{caught} of {len(BUGS)} bugs caught, {flagged} of {len(HARMLESS)} harmless flagged")


if __name__ == "__main__":
    main()
