"""Work at a table: calm, natural, one hand idle, stirring and wiping, reaching far out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from sim.contact.contact import height_above_table
from sim.families.sizes import BOX, CAN
from sim.motion.curves import Curve, ellipse, figure_eight, rounds
from sim.motion.lognormal import talk_gesture
from sim.motion.motion import Carriage, Cue, Hold, MotionPlan, object_at_rest
from sim.motion.planner import HandPlanner, curled, grasp, raised
from sim.motion.stage import STILL_S, Family, Stage, Values, no_objects, number, side_of
from sim.motion.strokes import HandState, minimum_jerk, quaternion_of
from sim.person.kinematics import OUTWARD, hand_rotation
from sim.pose import SIDES, Transform
from sim.specs import ObjectSpec


def _calm_objects(values: Values) -> tuple[ObjectSpec, ...]:
    x, y = number(values, "object_x"), number(values, "object_y")
    return (
        ObjectSpec("can", "can", CAN, (0.70, 0.06, 0.06), (x, -y)),
        ObjectSpec("box", "box", BOX, (0.12, 0.40, 0.16), (x - 0.02, y), yaw_rad=-0.45),
    )


def _calm_table(stage: Stage) -> MotionPlan:
    """Reach, lift and slide by turns, and now and then carry the thing on that side."""
    rng = stage.streams("actions")
    top = stage.number("speed")
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    room = stage.scene.room
    things = {0: room.objects[0], 1: room.objects[1]}
    places = {side: object_at_rest(room, thing.name) for side, thing in things.items()}
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
        # One draw each whatever the kind, so that a longer sequence begins like a shorter one.
        ahead, outward = float(rng.uniform(-0.02, 0.03)), float(rng.uniform(0.0, 0.08))
        lift, pause = float(rng.uniform(0.05, 0.13)), float(rng.uniform(0.3, 1.0))
        goal = stage.rest(side, ahead, outward)
        if kind == "carry":
            places[side], hold = _carry(
                stage, hand, side, things[side], places[side], top, (ahead, outward)
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
        cues.append(Cue(f"{kind}:{('right', 'left')[side]}", begun, hand.clock_s))
        # The other hand often begins before this one is back.
        overlap = float(rng.choice([0.0, 0.0, 0.3])) * (hand.clock_s - begun)
        clock = hand.clock_s + pause - overlap
        turn += 1
        side = 1 - side if turn < 3 or rng.random() < 0.7 else side
    return stage.plan(hands, tuple(holds), tuple(cues))


def _carry(
    stage: Stage,
    hand: HandPlanner,
    side: int,
    thing: ObjectSpec,
    place: Transform,
    speed: float,
    shift: tuple[float, float],
) -> tuple[Transform, Hold]:
    """Take a thing, set it down a little further, let go: where it then stands, and the hold."""
    taking = grasp(stage.scene, side, thing, place)
    hand.move(taking.before, speed, [0.0, 0.0, 0.03])
    hand.move(taking.open, 0.7 * speed)
    hand.move(taking.closed, speed, least_s=0.45)
    taken_s = hand.clock_s
    home = object_at_rest(stage.scene.room, thing.name).position_m
    # Near its first place, so that it never wanders off.
    there = home + np.array([0.5 * shift[0], OUTWARD[side] * 0.4 * shift[1], 0.0])
    moved = there - place.position_m
    put = replace(taking.closed, position_m=taking.closed.position_m + moved)
    lifted = 0.5 * (taking.closed.position_m + put.position_m) + np.array([0.0, 0.0, 0.07])
    hand.move(replace(put, position_m=lifted, air=1.0), speed)
    hand.move(put, speed)
    put_s = hand.clock_s
    hand.move(replace(put, curls=taking.open.curls), speed, least_s=0.4)
    hand.move(replace(taking.before, position_m=taking.before.position_m + moved), 0.7 * speed)
    return (
        Transform(place.position_m + moved, place.rotation),
        Hold(thing.name, side, taken_s, put_s),
    )


@dataclass
class _Worker:
    """One hand at work: its random stream, and where the thing on its side stands."""

    stage: Stage
    side: int
    hand: HandPlanner
    rng: np.random.Generator
    thing: ObjectSpec
    place: Transform
    speed_mps: float
    talk: float  # share of the actions that are gestures
    pause_s: float  # longest stillness between two actions

    def act(self) -> tuple[Cue, Hold | None]:
        """One action and the stillness after it."""
        rng, hand = self.rng, self.hand
        begun = hand.clock_s
        speed = self.speed_mps * float(rng.uniform(0.8, 1.0))
        # One draw each whatever the kind, so that a longer sequence begins like a shorter one.
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
                self.stage, hand, self.side, self.thing, self.place, speed, (ahead, outward)
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
        """Some strokes in the air on the hand's own side, one running into the next, and down."""
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


def _worker(stage: Stage, side: int, hand: HandPlanner, speed_mps: float, stream: str) -> _Worker:
    room = stage.scene.room
    thing = room.objects[side]
    return _Worker(
        stage,
        side,
        hand,
        stage.streams(stream),
        thing,
        object_at_rest(room, thing.name),
        speed_mps,
        stage.number("talk"),
        stage.number("pause"),
    )


def _work(worker: _Worker, until_s: float) -> tuple[list[Cue], list[Hold]]:
    """Action after action, the last one begun before until_s."""
    cues, holds = [], []
    while worker.hand.clock_s < until_s:
        cue, hold = worker.act()
        cues.append(cue)
        if hold is not None:
            holds.append(hold)
    return cues, holds


def _natural_table(stage: Stage) -> MotionPlan:
    """Both hands at work, each in its own time: gestures between reaching, sliding, carrying."""
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    cues: list[Cue] = []
    holds: list[Hold] = []
    for side in (0, 1):
        worker = _worker(stage, side, hands[side], stage.number("speed"), f"actions-{side}")
        hands[side].until(STILL_S + worker.pause_s * float(worker.rng.random()))
        done, held = _work(worker, stage.duration_s)
        cues += done
        holds += held
    return stage.plan(hands, tuple(holds), tuple(cues))


def _one_hand_idle(stage: Stage) -> MotionPlan:
    """One hand lies flat while the other works; at last it works as well."""
    idle = stage.side("idle_hand")
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    still_s = STILL_S + stage.number("idle")
    cues = [Cue(f"idle:{SIDES[idle]}", STILL_S, still_s)]
    holds: list[Hold] = []
    for side in (0, 1):
        worker = _worker(stage, side, hands[side], stage.number("speed"), f"actions-{side}")
        hands[side].until(still_s if side == idle else STILL_S)
        done, held = _work(worker, stage.duration_s)
        cues += done
        holds += held
    return stage.plan(hands, tuple(holds), tuple(cues))


_ROD = (0.23, 0.011, 0.011)
_CLOTH = (0.18, 0.16, 0.006)
_CUP_HEIGHT_M = 0.105


def _stir_objects(values: Values) -> tuple[ObjectSpec, ...]:
    outward = OUTWARD[side_of(values, "hand")]
    x, y = number(values, "place_x"), number(values, "place_y")
    stirs = values["task"] == "stir"
    # Wide enough for the round inside its walls.
    wide = (number(values, "stir_size") + 0.036) / 0.74
    # The handle, at the cup's +y, points to the cameras.
    cup_at = (x, outward * y) if stirs else (x + 0.10, -outward * 0.06)
    cup = ObjectSpec(
        "cup", "cup", (wide, wide, _CUP_HEIGHT_M), (0.78, 0.78, 0.74), cup_at, -0.5 * math.pi
    )
    if stirs:
        lying = (x + 0.05, outward * (y + 0.235))
        turned = -outward * number(values, "hand_inward") + 0.5 * math.pi
        return (cup, ObjectSpec("rod", "rod", _ROD, (0.55, 0.56, 0.58), lying, turned))
    spread = (x + 0.01, outward * (y + 0.15))
    return (cup, ObjectSpec("cloth", "sheet", _CLOTH, (0.20, 0.38, 0.52), spread))


def _holding(stage: Stage, hands: tuple[HandPlanner, HandPlanner], side: int) -> None:
    """The hand of this side goes to the cup and stays round it."""
    cup = stage.scene.room.objects[0]
    taking = grasp(stage.scene, side, cup, object_at_rest(stage.scene.room, cup.name))
    hand, speed = hands[side], stage.number("speed")
    hand.move(taking.before, speed, [0.0, 0.0, 0.03])
    hand.move(taking.open, 0.5 * speed)
    hand.move(taking.closed, speed, least_s=0.4)


def _round(stage: Stage, size_m: float, rng: np.random.Generator) -> Curve:
    """One round of the task, flat, of this greatest width, begun at its centre's front or back."""
    a, turn = float(rng.uniform(0.0, 2.0 * math.pi)), float(rng.choice([-1.0, 1.0]))
    first = 0.5 * size_m * np.array([math.cos(a), math.sin(a), 0.0])
    second = 0.5 * size_m * turn * np.array([-math.sin(a), math.cos(a), 0.0])
    shape = stage.values["shape"]
    if shape == "eight":
        return figure_eight(first, 0.45 * second, np.zeros(3))
    return ellipse(first, second if shape == "circle" else 0.55 * second, np.zeros(3))


def _bouts(stage: Stage, hand: HandPlanner, centre: HandState, size_m: float) -> list[Cue]:
    """Bouts of rounds about a state, with stillness between."""
    task, cues = str(stage.values["task"]), []
    rng = stage.streams("rounds")
    for _ in range(round(stage.number("bouts"))):
        curve = _round(stage, size_m, rng)
        begins = replace(centre, position_m=centre.position_m + curve.at(0.0))
        hand.move(begins, 0.15)
        hertz = stage.number("rounds") * float(rng.uniform(0.93, 1.07))
        hertz = min(max(hertz, 0.3), 1.4)
        bout = rounds(hand.clock_s, begins, curve, hertz, stage.number("bout"), 0.7)
        hand.add(bout)
        cues.append(Cue(task, bout.start_s, bout.end_s))
        hand.wait(stage.number("pause") * float(rng.uniform(0.6, 1.4)))
    return cues


def _stir_and_wipe(stage: Stage) -> MotionPlan:
    """One hand stirs in the cup or wipes with a cloth; the other holds the cup or rests."""
    side = stage.side("hand")
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    for hand in hands:
        hand.until(STILL_S + stage.number("wait"))
    other = hands[1 - side]
    holds: list[Hold] = []
    if stage.values["other"] == "holds_cup":
        _holding(stage, hands, 1 - side)
    held_s = other.clock_s
    act = _stir if stage.values["task"] == "stir" else _wipe
    hold, cues = act(stage, side, hands[side])
    holds.append(hold)
    hands[side].move(stage.rest(side), stage.number("speed"), [0.0, 0.0, 0.04])
    if other.moves:
        other.until(hands[side].clock_s - 1.0)
        holds.append(Hold("cup", 1 - side, held_s, other.clock_s))
        cues.append(Cue("hold_cup", held_s, other.clock_s))
        other.move(replace(other.state, curls=curled(0.12, thumb=0.05)), 0.3, least_s=0.4)
        away = np.array([-0.05, OUTWARD[1 - side] * 0.05, 0.02])
        other.move(replace(other.state, position_m=other.state.position_m + away), 0.2)
        other.move(stage.rest(1 - side), stage.number("speed"), [0.0, 0.0, 0.03])
    return stage.plan(hands, tuple(holds), tuple(cues))


def _stir(stage: Stage, side: int, hand: HandPlanner) -> tuple[Hold, list[Cue]]:
    """Take the rod from the table, stir, lay it back."""
    room, speed = stage.scene.room, stage.number("speed")
    cup, rod = room.objects[:2]  # what moves by itself comes after
    lying, cup_place = object_at_rest(room, "rod"), object_at_rest(room, "cup")
    thumb = -OUTWARD[side]  # along the hand's y
    length, radius = rod.size_m[0], 0.5 * rod.size_m[1]
    flat = hand_rotation(side, stage.number("hand_inward"), 0.0, 0.0)
    # Under the palm, the longer end out at the little finger.
    below = 0.19 * stage.scene.anatomy.hand_breadth_m + radius + 0.003
    rod_in_hand = np.array([0.028, -thumb * (0.5 * length - 0.045), -below])
    on_rod = lying.position_m + np.array([0.0, 0.0, radius]) - flat @ rod_in_hand
    taken = HandState(on_rod, quaternion_of(flat), curled(0.08, thumb=0.1))
    above = replace(taken, position_m=on_rod + np.array([-0.02, 0.0, 0.05]), air=1.0)
    begun = hand.clock_s
    hand.move(above, speed, [0.0, 0.0, 0.03])
    hand.move(taken, 0.5 * speed, least_s=0.4)
    from_s = hand.clock_s
    upright = hand_rotation(side, 0.55, 0.0, 1.5)
    lower_end = rod_in_hand - np.array([0.0, thumb * (0.5 * length - radius), 0.0])
    bottom = cup_place.position_m + np.array([0.0, 0.0, 0.1 * cup.size_m[2] + 0.008])
    stirring = HandState(
        bottom - upright @ lower_end, quaternion_of(upright), curled(0.72, thumb=0.6), air=0.3
    )
    over = replace(
        stirring,
        position_m=stirring.position_m + np.array([0.0, 0.0, cup.size_m[2] + 0.02]),
        air=1.0,
    )
    lifted = replace(over, position_m=0.5 * (over.position_m + on_rod) + [0.0, 0.0, 0.10])
    half_up = hand_rotation(side, 0.5, 0.0, 0.9)
    lifted = replace(lifted, quaternion=quaternion_of(half_up))
    hand.move(lifted, speed)
    hand.move(over, speed)
    hand.move(stirring, 0.5 * speed)
    cues = [Cue("take", begun, hand.clock_s)]
    cues += _bouts(stage, hand, stirring, stage.number("stir_size"))
    leaving = hand.clock_s
    hand.move(over, 0.5 * speed)
    hand.move(lifted, speed)
    hand.move(taken, speed, least_s=0.8)
    to_s = hand.clock_s
    hand.move(above, 0.5 * speed)
    cues.append(Cue("put_back", leaving, to_s))
    return Hold("rod", side, from_s, to_s), cues


def _wipe(stage: Stage, side: int, hand: HandPlanner) -> tuple[Hold, list[Cue]]:
    """Lay the hand on the cloth, wipe, leave it."""
    room, speed = stage.scene.room, stage.number("speed")
    cloth = room.objects[1]
    spread = object_at_rest(room, cloth.name).position_m
    flat = hand_rotation(side, stage.number("hand_inward"), 0.0, 0.0)
    curls = curled(0.05, thumb=0.05)
    lies = height_above_table(stage.scene.anatomy, side, flat, curls) + cloth.size_m[2] + 1e-3
    # The palm a little behind the cloth's middle: the fingers lie on it too.
    place = spread + np.array([-0.015, 0.0, lies])
    on_cloth = HandState(place, quaternion_of(flat), curls)
    begun = hand.clock_s
    hand.move(on_cloth, speed, [0.0, 0.0, 0.05])
    from_s = hand.clock_s
    cues = [Cue("take", begun, from_s)]
    cues += _bouts(stage, hand, on_cloth, stage.number("wipe_size"))
    hand.move(on_cloth, 0.2)
    return Hold(cloth.name, side, from_s, hand.clock_s), cues


@dataclass(frozen=True, eq=False)
class _Leans:
    """A `sim.motion.motion.CarriageMotion`: from one carriage to the next, each move minimum-jerk.

    moves: (start_s, duration_s, forward_rad, sideways_rad, turn_rad), in order of time.
    """

    moves: tuple[tuple[float, float, float, float, float], ...]

    def at(self, t_s: float) -> Carriage:
        """The carriage at t_s [s], any t."""
        held = np.zeros(3)
        for start, duration, *goal in self.moves:
            held = held + minimum_jerk((t_s - start) / duration) * (np.array(goal) - held)
        forward, sideways, turn = held.tolist()
        return Carriage(forward, sideways, turn)


def _out_there(stage: Stage, side: int, x_m: float, aside_m: float) -> HandState:
    """The hand flat on the table, so far ahead of the upright shoulders and so far out."""
    turned = hand_rotation(side, 0.1, 0.05, 0.1)
    curls = curled(0.12, thumb=0.1)
    lies = height_above_table(stage.scene.anatomy, side, turned, curls) + 1e-3
    place = [x_m, OUTWARD[side] * aside_m, stage.scene.room.table_height_m + lies]
    return HandState(np.array(place), quaternion_of(turned), curls)


def _lean_and_reach(stage: Stage) -> MotionPlan:
    """The torso leans and a hand reaches far out on the table, and back; some times over."""
    rng = stage.streams("reaches")
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    speed, lean = stage.number("speed"), stage.number("lean")
    moves: list[tuple[float, float, float, float, float]] = []
    cues: list[Cue] = []
    clock, side = STILL_S + stage.number("wait"), stage.side("hand")
    for turn in range(round(stage.number("reaches"))):
        # The first lean is the declared one; the others are a little less.
        forward = lean * (1.0 if turn == 0 else float(rng.uniform(0.75, 1.0)))
        sideways = stage.number("sideways") * float(rng.uniform(-1.0, 1.0))
        twist = -OUTWARD[side] * stage.number("twist") * float(rng.uniform(0.3, 1.0))
        far = stage.number("reach") * float(rng.uniform(0.93, 1.0))
        aside = float(rng.uniform(0.05, 0.25))
        hand = hands[side]
        hand.until(clock)
        reach = hand.move(
            _out_there(stage, side, far, aside), speed, [0.0, OUTWARD[side] * 0.02, 0.06]
        )
        # The body leans for as long as the hand goes, a little ahead of it.
        ahead = 0.1 * reach.duration_s
        moves.append((clock, reach.duration_s - ahead, forward, sideways, twist))
        hand.wait(stage.number("hold") * float(rng.uniform(0.7, 1.3)))
        back_s = hand.clock_s
        back = hand.move(stage.rest(side), speed, [0.0, OUTWARD[side] * 0.02, 0.06])
        moves.append((back_s + ahead, back.duration_s - ahead, 0.0, 0.0, 0.0))
        cues += [
            Cue("lean", clock, reach.end_s),
            Cue("leant", reach.end_s, back_s),
            Cue("back", back_s, back.end_s),
        ]
        clock = hand.clock_s + stage.number("wait") * float(rng.uniform(0.6, 1.4))
        side = 1 - side if rng.random() < 0.6 else side
    return stage.plan(hands, cues=tuple(cues), carriage=_Leans(tuple(moves)))


_WORK = ("speed", "talk", "pause", "object_x", "object_y")

FAMILIES: Mapping[str, Family] = {
    "calm_table": Family(("speed", "object_x", "object_y"), _calm_objects, _calm_table),
    "natural_table": Family(_WORK, _calm_objects, _natural_table),
    "one_hand_idle": Family((*_WORK, "idle_hand", "idle"), _calm_objects, _one_hand_idle),
    "stir_and_wipe": Family(
        (
            "task",
            "hand",
            "other",
            "shape",
            "rounds",
            "stir_size",
            "wipe_size",
            "bouts",
            "bout",
            "pause",
            "speed",
            "wait",
            "place_x",
            "place_y",
        ),
        _stir_objects,
        _stir_and_wipe,
    ),
    "lean_and_reach": Family(
        (
            "hand",
            "speed",
            "lean",
            "sideways",
            "twist",
            "reach",
            "reaches",
            "hold",
            "wait",
        ),
        no_objects,
        _lean_and_reach,
    ),
}
