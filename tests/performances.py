"""Shared by tests of motion: performances played once a process, and what to measure on them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cache

import cv2
import numpy as np

from scenarios.spec.draw import concrete, perform
from scenarios.spec.names import load_scenario
from sim.camera.render import StereoRenderer
from sim.contact.contact import penetration
from sim.labels import view_truth
from sim.pose import Pose
from sim.scene.world import build
from sim.script import Performance

HANDS = ("right", "left")


@cache
def performance(name: str, seed: int, **overrides) -> Performance:
    """The performance of a shipped scenario."""
    return perform(load_scenario(name), seed, overrides)


def drawn(name: str, seed: int, **overrides) -> dict:
    """The parameter values of `performance`."""
    redrawn = performance(name, seed, **overrides).redrawn
    return concrete(load_scenario(name), seed, overrides, redrawn)


def end_s(played: Performance) -> float:
    """When the film ends [s]."""
    return played.frames / played.fps


def cues(played: Performance, start: str = "") -> list:
    """The cues whose names start so, in order of the plan."""
    return [cue for cue in played.script.plan.cues if cue.name.startswith(start)]


def cue(played: Performance, name: str):
    """The only cue of this name."""
    (found,) = (cue for cue in played.script.plan.cues if cue.name == name)
    return found


@cache
def body(name: str, seed: int, t_s: float):
    """The body of a performance at a moment, posed once."""
    return performance(name, seed).script.body(t_s)


def bodies(name: str, seed: int, dt_s: float) -> tuple[np.ndarray, list]:
    """Times (n,) of the whole film, dt_s apart, and the bodies then."""
    times = np.arange(0.0, end_s(performance(name, seed)), dt_s)
    return times, [body(name, seed, t) for t in times.tolist()]


def palms(script, times: Iterable[float]) -> np.ndarray:
    """Palms (n, 2, 3) [m] as posed."""
    return np.array([[arm.palm_m for arm in script.body(t).arms] for t in times])


def planned(hand, from_s: float, to_s: float, dt_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) and the places (n, 3) [m] to which the plan sends a hand."""
    times = np.arange(from_s, to_s, dt_s)
    return times, np.array([hand.at(t).position_m for t in times.tolist()])


def speeds(path: np.ndarray, dt_s: float) -> np.ndarray:
    """Speeds [m/s] along a path (n, ..., 3)."""
    return np.linalg.norm(np.diff(path, axis=0), axis=-1) / dt_s


def gap_m(script, t_s: float) -> float:
    """Air between the hands [m], negative where they overlap."""
    body = script.body(t_s)
    obstacles = script.obstacles(body.torso, body.head)
    return -penetration(script.scene.anatomy, body.arms, body.curls, obstacles).hands_m


def renders(played: Performance, times: Iterable[float], colour: bool = False) -> list:
    """(views, truths of the views, world) at each of the times."""
    shown = []
    with StereoRenderer(build(played.scene)) as renderer:
        for t_s in times:
            renderer.world.place(played.script.pose(t_s))
            views = renderer.render(colour=colour)
            shown.append((views, [view_truth(view) for view in views], renderer.world))
    return shown


def truths(played: Performance, times: Iterable[float]) -> list:
    """Truths of both views at each of the times."""
    return [views for _, views, _ in renders(played, times)]


def halved(played: Performance) -> Performance:
    """The same performance filmed with a quarter of the pixels: the same shares of everything."""
    rig = played.scene.rig
    small = replace(
        rig, width_px=rig.width_px // 2, height_px=rig.height_px // 2, focal_px=rig.focal_px / 2
    )
    return replace(played, scene=replace(played.scene, rig=small))


def assert_same(a: Pose, b: Pose) -> None:
    """Every part and object in the very same place."""
    for first, second in (
        (a.torso, b.torso),
        (a.head, b.head),
        *zip(a.upper_arms + a.forearms + a.hands, b.upper_arms + b.forearms + b.hands, strict=True),
        *((a.objects[name], b.objects[name]) for name in a.objects | b.objects),
    ):
        np.testing.assert_array_equal(first.position_m, second.position_m)
        np.testing.assert_array_equal(first.rotation, second.rotation)
    np.testing.assert_array_equal(a.curls, b.curls)


def fractions(played: Performance, times: Iterable[float]) -> np.ndarray:
    """Visible fractions (times, views, targets), NaN where a target is out of the picture."""
    return np.array(
        [
            [np.where(view.amodal_px > 0, view.visible_fractions, np.nan) for view in views]
            for views in truths(played, times)
        ]
    )


def frame_times(played: Performance, from_s: float, to_s: float) -> list[float]:
    """Times of the frames between two moments [s]."""
    first, last = np.ceil(from_s * played.fps), np.floor(to_s * played.fps)
    return (np.arange(first, last + 1) / played.fps).tolist()


def components_px(mask: np.ndarray) -> list[int]:
    """Sizes of the connected components of a mask, the largest first."""
    _, _, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    return sorted(stats[1:, cv2.CC_STAT_AREA].tolist(), reverse=True)


def same_pictures(a, b) -> bool:
    """Whether two simulated frames show the same, byte for byte."""
    return all(
        np.array_equal(first, second)
        for first, second in zip(a.frame.pictures, b.frame.pictures, strict=True)
    )
