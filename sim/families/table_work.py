"""Work at a table: calm, natural, or with a hand idle."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from sim.families.sizes import BOX, CAN
from sim.motion.lognormal import talk_gesture
from sim.motion.motion import Cue, Hold, MotionPlan, object_at_rest
from sim.motion.planner import HandPlanner, grasp, raised
from sim.motion.stage import STILL_S, Family, Stage, Values, number
from sim.motion.strokes import HandState
from sim.person.kinematics import OUTWARD
from sim.pose import SIDES, Transform
from sim.specs import ObjectSpec


def _calm_objects(values: Values) -> tuple[ObjectSpec, ...]:
    x, y = number(values, "object_x"), number(values, "object_y")
    return (
        ObjectSpec("can", "can", CAN, (0.70, 0.06, 0.06), (x, -y)),
        ObjectSpec("box", "box", BOX, (0.12, 0.40, 0.16), (x - 0.02, y), yaw_rad=-0.45),
    )


def _calm_table(stage: Stage) -> MotionPlan:
    """Reach, lift and slide by turns, and now and then carry the object on that side."""
    rng = stage.streams("actions")
    top = stage.number("speed")
    hands = stage.planners()
    room = stage.scene.room
    objects = (room.objects[0], room.objects[1])
    places = [object_at_rest(room, spec.name) for spec in objects]
    holds: list[Hold] = []
    cues: list[Cue] = []
    clock, turn, side = STILL_S, 0, int(rng.integers(2))
    while clock < stage.duration_s:
        hand = hands[side]
        hand.until(clock)
        begun = hand.clock_s
        speed = top * float(rng.uniform(0.7, 1.0))
        kind = (
            "carry" if turn in (1, 2) or rng.random() < 0.2 else str(rng.choice(["reach", "slide"]))
        )
        # The same draws whatever the kind: a longer sequence begins like a shorter sequence.
        ahead, outward = float(rng.uniform(-0.02, 0.03)), float(rng.uniform(0.0, 0.08))
        lift, pause = float(rng.uniform(0.05, 0.13)), float(rng.uniform(0.3, 1.0))
        goal = stage.rest(side, ahead, outward)
        if kind == "carry":
            places[side], hold = _carry(
                stage, hand, side, objects[side], places[side], top, (ahead, outward)
            )
            holds.append(hold)
            hand.move(goal, speed, [0.0, 0.0, 0.03])
        elif kind == "reach":
            up = raised(
                side,
                goal.position_m + np.array([0.02, 0.0, lift]),
                stage.number("hand_inward"),
                0.1,
                0.5,
                curl=0.25,
            )
            hand.move(up, top)
            hand.wait(pause)
            hand.move(goal, speed)
        else:
            hand.move(goal, top, [0.0, 0.0, 0.012])
        cues.append(Cue(f"{kind}:{SIDES[side]}", begun, hand.clock_s))
        # The other hand often begins before this hand is back.
        overlap = float(rng.choice([0.0, 0.0, 0.3])) * (hand.clock_s - begun)
        clock = hand.clock_s + pause - overlap
        turn += 1
        side = 1 - side if turn < 3 or rng.random() < 0.7 else side
    return stage.plan(hands, tuple(holds), tuple(cues))


def _carry(
    stage: Stage,
    hand: HandPlanner,
    side: int,
    carried: ObjectSpec,
    place: Transform,
    speed: float,
    shift: tuple[float, float],
) -> tuple[Transform, Hold]:
    """Take an object from `place`, set it down `shift` (ahead, outward) [m] from its first place,
    let go.

    Returns the place where it then stands, and the hold.
    """
    taking = grasp(stage.scene, side, carried, place)
    taken_s = hand.take(taking, speed, near=0.7, closing_s=0.45)
    home = object_at_rest(stage.scene.room, carried.name).position_m
    # Near its first place, so that it never wanders off.
    there = home + np.array([0.5 * shift[0], OUTWARD[side] * 0.4 * shift[1], 0.0])
    moved = there - place.position_m
    put = taking.closed.moved(moved)
    lifted = 0.5 * (taking.closed.position_m + put.position_m) + np.array([0.0, 0.0, 0.07])
    hand.move(replace(put, position_m=lifted, air=1.0), speed)
    hand.move(put, speed)
    put_s = hand.clock_s
    hand.let_go(taking, put, moved, speed, 0.7 * speed)
    return (
        Transform(place.position_m + moved, place.rotation),
        Hold(carried.name, side, taken_s, put_s),
    )


@dataclass
class _Worker:
    """A hand at work: its random stream, and the object on its side with its place."""

    stage: Stage
    side: int
    hand: HandPlanner
    rng: np.random.Generator
    own: ObjectSpec
    place: Transform
    speed_mps: float
    talk: float  # share of the actions that are gestures
    pause_s: float  # longest stillness between two actions

    def act(self) -> tuple[Cue, Hold | None]:
        """Add an action and the stillness after it: its cue, and the hold of a carried object."""
        rng, hand = self.rng, self.hand
        begun = hand.clock_s
        speed = self.speed_mps * float(rng.uniform(0.8, 1.0))
        # The same draws whatever the kind: a longer sequence begins like a shorter sequence.
        talks, kind = float(rng.random()), str(rng.choice(["reach", "slide", "carry"]))
        ahead, outward = float(rng.uniform(-0.03, 0.07)), float(rng.uniform(0.0, 0.09))
        lift, pause = float(rng.uniform(0.08, 0.2)), self.pause_s * float(rng.random()) ** 2
        goal, hold = self.stage.rest(self.side, ahead, outward), None
        if talks < self.talk:
            kind = "talk"
            self._talk(speed, goal)
            # The last impulses die away while the hand lies there: stillness enough.
            pause = 0.0
        elif kind == "carry":
            self.place, hold = _carry(
                self.stage, hand, self.side, self.own, self.place, speed, (ahead, outward)
            )
            hand.move(goal, speed, [0.0, 0.0, 0.03])
        elif kind == "reach":
            up = goal.position_m + np.array([0.04, 0.0, lift])
            inward = self.stage.number("hand_inward")
            hand.move(raised(self.side, up, inward, 0.1, 0.5, curl=0.25), speed)
            hand.wait(0.4 * pause)
            hand.move(goal, speed)
        else:
            hand.move(goal, 0.7 * speed, [0.0, 0.0, 0.015])
        cue = Cue(f"{kind}:{SIDES[self.side]}", begun, hand.clock_s)
        hand.wait(pause)
        return cue, hold

    def _talk(self, speed_mps: float, goal: HandState) -> None:
        """Add strokes in the air on the hand's own side that run into each other, down to goal."""
        rng, top = self.rng, self.stage.scene.room.table_height_m
        stops, peaks = [], []
        here = self.hand.state.position_m
        for _ in range(int(rng.integers(2, 6))):
            # The farthest of three places: a gesture is wide, or it would not be seen.
            places = rng.uniform([0.33, 0.16, 0.16], [0.47, 0.38, 0.40], (3, 3))
            places = places * [1.0, OUTWARD[self.side], 1.0] + [0.0, 0.0, top]
            here = places[int(((places - here) ** 2).sum(axis=1).argmax())]
            inward, down, thumb_up, curl = rng.uniform(
                [0.2, -0.6, 0.3, 0.1], [0.6, 0.0, 1.2, 0.4]
            ).tolist()
            stops.append(raised(self.side, here, inward, down, thumb_up, curl))
            peaks.append(speed_mps * float(rng.uniform(0.75, 1.0)))
        stops.append(goal)
        peaks.append(0.8 * speed_mps)
        overlap = float(rng.uniform(-0.2, 0.05))
        hand = self.hand
        ends = (0, len(stops) - 1)
        hand.add(talk_gesture(rng, hand.clock_s, hand.state, stops, peaks, overlap, ends))


def _worker(stage: Stage, side: int, hand: HandPlanner) -> _Worker:
    own = stage.scene.room.objects[side]
    return _Worker(
        stage,
        side,
        hand,
        stage.streams(f"actions-{side}"),
        own,
        object_at_rest(stage.scene.room, own.name),
        stage.number("speed"),
        stage.number("talk"),
        stage.number("pause"),
    )


def _at_work(
    stage: Stage, begins_s: Callable[[_Worker], float], first_cues: tuple[Cue, ...] = ()
) -> MotionPlan:
    """Plan both hands at work, each in its own time from begins_s(its worker) [s] on."""
    hands = stage.planners()
    cues, holds = list(first_cues), []
    for side in (0, 1):
        worker = _worker(stage, side, hands[side])
        hands[side].until(begins_s(worker))
        while worker.hand.clock_s < stage.duration_s:
            cue, hold = worker.act()
            cues.append(cue)
            holds += [] if hold is None else [hold]
    return stage.plan(hands, tuple(holds), tuple(cues))


def _natural_table(stage: Stage) -> MotionPlan:
    """Both hands at work: gestures between reaching, sliding, carrying."""
    return _at_work(stage, lambda worker: STILL_S + worker.pause_s * float(worker.rng.random()))


def _one_hand_idle(stage: Stage) -> MotionPlan:
    """A hand lies flat while the other works; at last it works as well."""
    idle = stage.side("idle_hand")
    still_s = STILL_S + stage.number("idle")
    return _at_work(
        stage,
        lambda worker: still_s if worker.side == idle else STILL_S,
        (Cue(f"idle:{SIDES[idle]}", STILL_S, still_s),),
    )


_WORK = ("speed", "talk", "pause", "object_x", "object_y")


FAMILIES: Mapping[str, Family] = {
    "calm_table": Family(("speed", "object_x", "object_y"), _calm_table, _calm_objects),
    "natural_table": Family(_WORK, _natural_table, _calm_objects),
    "one_hand_idle": Family((*_WORK, "idle_hand", "idle"), _one_hand_idle, _calm_objects),
}
