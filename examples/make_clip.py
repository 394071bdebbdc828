"""Makes scenarios/catalog/clips/story.csv: hands of somebody who tells a story, seated.

Nobody was recorded: minimum-jerk strokes between the poses below, through this project's own body,
which gives shoulders, elbows and wrists. `python examples/make_clip.py OUT.csv` writes it again.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from sim.clips.clips import ARM_JOINTS
from sim.motion.motion import MotionPlan, Performer
from sim.motion.planner import HandPlanner, raised
from sim.motion.strokes import wobble
from sim.pose import SIDES
from sim.randomness import generator
from sim.specs import SceneSpec

HZ = 30
# What is said, when both hands are there [s], and where: ahead, outward, above the shoulders [m].
STORY = (
    ("so", 0.0, (0.31, 0.16, -0.17), (0.31, 0.15, -0.17)),
    ("there was", 0.9, (0.36, 0.12, -0.09), (0.32, 0.16, -0.16)),
    ("a fish", 1.5, (0.38, 0.16, -0.13), (0.32, 0.17, -0.15)),
    ("this big", 2.5, (0.34, 0.33, -0.05), (0.35, 0.32, -0.06)),
    ("no, that big", 3.3, (0.32, 0.42, 0.02), (0.33, 0.41, 0.00)),
    ("in the lake", 4.3, (0.37, 0.14, -0.15), (0.36, 0.15, -0.16)),
    ("far over there", 5.2, (0.36, 0.15, -0.15), (0.42, 0.31, 0.08)),
    ("behind the trees", 6.1, (0.35, 0.16, -0.13), (0.38, 0.44, 0.02)),
    ("and I", 6.9, (0.22, 0.12, -0.07), (0.35, 0.16, -0.15)),
    ("threw the line", 7.6, (0.45, 0.24, 0.10), (0.36, 0.15, -0.14)),
    ("wound it in", 8.3, (0.36, 0.10, -0.08), (0.31, 0.10, -0.14)),
    ("and in", 8.8, (0.33, 0.10, -0.13), (0.36, 0.10, -0.07)),
    ("and in", 9.3, (0.37, 0.10, -0.08), (0.32, 0.10, -0.13)),
    ("and it was gone", 10.4, (0.34, 0.38, -0.03), (0.34, 0.37, -0.02)),
    ("what can you do", 11.4, (0.32, 0.30, -0.11), (0.32, 0.31, -0.11)),
    ("well", 12.4, (0.31, 0.16, -0.17), (0.31, 0.15, -0.17)),
)
BOW_M = 0.035  # of each stroke: upward, and outward by half as much


def performer(scene: SceneSpec) -> Performer:
    """The person of a scene, telling the story."""
    rng = generator(0, "make_clip")
    hands = []
    for side, outward in enumerate((-1.0, 1.0)):
        poses = []
        for _, _, *places in STORY:
            ahead, aside, above = places[side]
            place = np.array([ahead, outward * aside, scene.anatomy.mid_shoulder_height_m + above])
            poses.append(raised(side, place, 0.45, 0.0, 0.9))
        hand = HandPlanner(poses[0])
        for (_, before_s, *_), (_, there_s, *_), pose in zip(
            STORY, STORY[1:], poses[1:], strict=False
        ):
            # The rest of the time between two poses is a hold.
            length_s = min((there_s - before_s) * rng.uniform(0.70, 0.95), rng.uniform(0.45, 0.65))
            hand.until(there_s - length_s)
            bow = BOW_M * np.array([0.2, 0.5 * outward, 1.0])
            hand.move(pose, 10.0, bow, least_s=length_s)
        hands.append(hand.path())
    plan = MotionPlan(
        hands=(hands[0], hands[1]),
        sway=wobble(rng, 0.012, 0.2, 0.5),
        tremor=(wobble(rng, 0.003, 0.5, 1.6), wobble(rng, 0.003, 0.5, 1.6)),
        swivel_rad=0.5,
    )
    return Performer(scene, plan)


def story() -> str:
    """The clip as CSV text: time and places in the torso's frame, .5 for 0.5."""
    scene = SceneSpec()
    told = performer(scene)
    origin = np.array(
        [0.0, 0.0, scene.anatomy.mid_shoulder_height_m - scene.anatomy.shoulder_drop_m]
    )
    joints = ("head", *(f"{side}_{joint}" for side in SIDES for joint in ARM_JOINTS))
    lines = [
        "# Made by examples/make_clip.py, not recorded: free to use like the rest of the project.",
        "# Metres, torso frame: x forward, y to the person's left, z up, origin mid-shoulder.",
        ",".join(["time_s", *(f"{joint}_{axis}" for joint in joints for axis in "xyz")]),
    ]
    for index in range(round(STORY[-1][1] * HZ) + 1):
        body = told.body(index / HZ)
        places = [body.head.position_m]
        for arm in body.arms:
            places += [arm.shoulder_m, arm.elbow_m, arm.wrist_m, arm.palm_m]
        numbers = (np.array(places) - origin).ravel().tolist()
        cells = [f"{index / HZ:.3f}", *(f"{value + 0.0:.3f}" for value in numbers)]
        lines.append(
            ",".join(cell.replace("0.", ".", 1) if abs(float(cell)) < 1 else cell for cell in cells)
        )
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    out = Path(sys.argv[1] if len(sys.argv) > 1 else "scenarios/catalog/clips/story.csv")
    out.write_text(story(), encoding="utf-8")
    print(f"{out}: {out.stat().st_size / 1000:.1f} kB")
