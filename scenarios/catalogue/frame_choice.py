"""Chooses the frames of a sequence that show most: for a sheet, and for a single picture."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence

from sim.camera.render import StereoRenderer
from sim.labels import truth_of, velocities
from sim.scene.world import build
from sim.script import Performance
from sim.truth import Truth

HIDDEN_SHARE = 0.3  # of its skin; a target that shows less is hardly truths
STILL_FRAMES = 3  # at the start of a sequence, before anything moves


def truths_without_pictures(performance: Performance, indices: Iterable[int]) -> Iterator[Truth]:
    """Yield the truth of frames without rendering colour: a quarter of the time."""
    world, script = build(performance.scene), performance.script
    with StereoRenderer(world) as renderer:
        for index in indices:
            t_s = index / performance.fps
            pose = script.pose(t_s)
            world.place(pose)
            views = renderer.render(colour=False)
            speeds, events = velocities(script, t_s), script.events(t_s)
            yield truth_of(index, pose, speeds, views, world.rig.cameras, events)


def difficulty(truth: Truth) -> int:
    """The number of merged pairs and of hardly visible targets, over both views."""
    merged = sum(int(view.merged.sum()) // 2 for view in truth.views)
    return merged + sum(int((view.visible_fractions < HIDDEN_SHARE).sum()) for view in truth.views)


def representative_frames(truths: Sequence[Truth], most: int) -> list[int]:
    """Choose at most `most` frames that show all that happens; returns their positions, in order.

    The first frame, the middle of every stretch of equal events and merges (the most difficult
    first where there are too many), then frames in the widest gaps.
    """
    stretches: list[list[int]] = []
    for i, truth in enumerate(truths):
        if i == 0 or _situation(truths[i - 1]) != _situation(truth):
            stretches.append([])
        stretches[-1].append(i)
    middles = [s[len(s) // 2] for s in stretches if any(_situation(truths[s[0]]))]
    middles.sort(key=lambda i: (-difficulty(truths[i]), i))
    chosen = {0, *middles[: most - 1]}
    while len(chosen) < min(most, len(truths)):
        edges = [-1, *sorted(chosen), len(truths)]
        low, high = max(itertools.pairwise(edges), key=lambda gap: gap[1] - gap[0])
        chosen.add((low + high) // 2)
    return sorted(chosen)


def hardest_frame(truths: Sequence[Truth]) -> Truth:
    """The middle of the longest stretch with the most merged or hidden targets.

    Where no target is ever merged or hidden: the middle of the longest event.
    """
    most = max(map(difficulty, truths))
    if most:
        stretches = _stretches(truths, lambda truth: difficulty(truth) == most)
    else:
        stretches = _stretches(truths[STILL_FRAMES:], lambda truth: truth.script_events)
    longest = max(stretches, key=len, default=list(truths))
    return longest[len(longest) // 2]


def _situation(truth: Truth) -> tuple[object, ...]:
    return truth.script_events, *(
        view.merged.tobytes() for view in truth.views if view.merged.any()
    )


def _stretches(truths: Sequence[Truth], key: Callable[[Truth], object]) -> list[list[Truth]]:
    """Runs of consecutive frames with the same key, where it is true."""
    return [list(run) for value, run in itertools.groupby(truths, key) if value]
