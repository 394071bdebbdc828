"""Hand and hand: clasped, clapping, rolling, passing a thing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.contact.contact import Capsules, capsule_gap, hand_capsules
from sim.motion.motion import Cue, HandMotion, Hold, MotionPlan, object_at_rest
from sim.motion.planner import HandPlanner, curled, grasp, raised
from sim.motion.stage import STILL_S, Family, Stage, Values, no_objects, number, side_of
from sim.motion.strokes import HandPath, HandState, between, quaternion_of
from sim.person.kinematics import OUTWARD, hand_rotation
from sim.pose import Transform
from sim.specs import RGB, ObjectSpec
from sim.vectors import about_z

_SIDES = ("right", "left")
_RISING_M = np.array([0.0, 0.0, 0.02])
_THINGS: Mapping[str, tuple[str, tuple[float, float, float], RGB, float]] = {
    # kind, extents, colour, yaw: the cup's handle points to the person, between the hands
    "cup": ("cup", (0.100, 0.100, 0.100), (0.20, 0.55, 0.30), 0.5 * math.pi),
    "box": ("box", (0.075, 0.095, 0.100), (0.62, 0.12, 0.40), 0.0),
    "ball": ("ball", (0.110, 0.110, 0.110), (0.15, 0.45, 0.70), 0.0),
}


@dataclass(frozen=True)
class Tempo:
    """A count of whole cycles at a frequency, begun and ended over one period each.

    The frequency rises and falls along a minimum-jerk profile, so that whatever follows the phase
    begins and ends with neither speed nor acceleration.
    """

    start_s: float
    frequency_hz: float
    cycles: int

    @property
    def end_s(self) -> float:
        """When the last cycle is over [s]."""
        return self.start_s + (self.cycles + 1) / self.frequency_hz

    def phase(self, t_s: float) -> float:
        """Cycles done at t_s, 0 to `cycles`."""
        done = (t_s - self.start_s) * self.frequency_hz
        left = self.cycles + 1 - done
        if done <= 0.0:
            return 0.0
        if left <= 0.0:
            return float(self.cycles)
        if done < 1.0:
            return _run_up(done)
        return self.cycles - _run_up(left) if left < 1.0 else done - 0.5


def _run_up(s: float) -> float:
    """Integral of the minimum-jerk profile from 0 to s, 1/2 at s = 1."""
    return s * s * s * s * (2.5 + s * (s - 3.0))


@dataclass(frozen=True, eq=False)
class Clapping:
    """A hand that goes from open to closed and back once a cycle, within a path that waits."""

    path: HandPath
    tempo: Tempo
    open: HandState
    closed: HandState

    def at(self, t_s: float) -> HandState:
        """The state at t_s [s], any t."""
        if not self.tempo.start_s < t_s < self.tempo.end_s:
            return self.path.at(t_s)
        share = 0.5 - 0.5 * math.cos(2.0 * math.pi * self.tempo.phase(t_s))
        return between(self.open, self.closed, share)


@dataclass(frozen=True, eq=False)
class Rolling:
    """A hand on an upright circle of radius_m (3,), from its centre to where the path waits.

    towards: 1 rolls its top towards the cameras, -1 towards the person.
    """

    path: HandPath
    tempo: Tempo
    radius_m: Floats
    towards: float

    def at(self, t_s: float) -> HandState:
        """The state at t_s [s], any t."""
        state = self.path.at(t_s)
        if not self.tempo.start_s < t_s < self.tempo.end_s:
            return state
        angle = 2.0 * math.pi * self.towards * self.tempo.phase(t_s)
        x, _, z = self.radius_m.tolist()
        c, s = math.cos(angle), math.sin(angle)
        turned = np.array([c * x + s * z, 0.0, c * z - s * x])
        return replace(state, position_m=state.position_m - self.radius_m + turned)


def _bars(stage: Stage, side: int, state: HandState) -> Capsules:
    shape = hand_capsules(stage.scene.anatomy, side, state.curls)
    return shape.placed(state.position_m, state.rotation)


def _brought(stage: Stage, side: int, state: HandState, way: Floats, to: Capsules) -> HandState:
    """The hand, which overlaps with `to` or not, moved along a unit vector (3,) until it touches.

    From 0.25 m back along the way, so that it comes from outside.
    """

    def at(share_m: float) -> HandState:
        return replace(state, position_m=state.position_m + share_m * way)

    clear, inside = -0.25, 0.05
    for _ in range(20):
        middle = 0.5 * (clear + inside)
        if capsule_gap(_bars(stage, side, at(middle)), to)[0] > 0.0:
            inside = middle
        else:
            clear = middle
    return at(clear)


def _closed(stage: Stage, side: int, state: HandState, most: Floats, round_: Capsules) -> HandState:
    """The hand with each finger curled, up to `most` (5,), until it touches what it closes on."""
    curls = state.curls.copy()
    for finger in range(5):
        first = 4 + 3 * finger  # after the palm's bars, three of each finger
        for curl in np.linspace(curls[finger], most[finger], 40).tolist():
            trial = curls.copy()
            trial[finger] = curl
            bars = _bars(stage, side, replace(state, curls=trial))
            of_finger = slice(first, first + 3)
            chain = Capsules(
                bars.starts_m[of_finger], bars.ends_m[of_finger], bars.radii_m[of_finger]
            )
            if capsule_gap(chain, round_)[0] > 0.0:
                break
            curls = trial
    return replace(state, curls=curls)


def _both(hands: tuple[HandPlanner, HandPlanner], wait_s: float = 0.0) -> float:
    """Both clocks to the later one, and on by wait_s; returns them."""
    ready = max(hand.clock_s for hand in hands) + wait_s
    for hand in hands:
        hand.until(ready)
    return ready


def _start(stage: Stage) -> tuple[HandPlanner, HandPlanner]:
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    for hand in hands:
        hand.until(STILL_S + stage.number("wait"))
    return hands


def _centre(stage: Stage) -> Floats:
    """Where the hands meet (3,) [m]."""
    height = stage.scene.room.table_height_m + stage.number("height")
    return np.array([stage.number("centre_x"), 0.0, height])


def _shifted(state: HandState, by_m: Floats) -> HandState:
    return replace(state, position_m=state.position_m + by_m)


def _merge_and_hold(stage: Stage) -> MotionPlan:
    """One hand is laid as a fist into the other, which closes round it; they stay, and part."""
    speed, outer = stage.number("speed"), stage.side("outer")
    inner, rng = 1 - outer, stage.streams("drift")
    hands = _start(stage)
    centre = _centre(stage)
    fist = raised(inner, centre, 0.85, -0.1, 1.25, swivel_rad=0.1)
    fist = replace(fist, curls=curled(0.78, thumb=0.5), air=0.0)
    way = fist.rotation[:, 0]  # into the other palm, knuckles first
    palm = raised(outer, centre, 0.6, -0.15, 1.45, curl=0.12, swivel_rad=0.1)
    # The knuckles meet the middle of the palm and the roots of its fingers.
    knuckles = centre + 0.03 * way
    palm = replace(palm, air=0.0, position_m=knuckles - 0.012 * palm.rotation[:, 0])
    touching = _brought(stage, outer, palm, -way, _bars(stage, inner, fist))
    most = curled(0.62, thumb=0.6)
    clasp = _closed(stage, outer, touching, most, _bars(stage, inner, fist))
    apart = 0.5 * stage.number("apart")
    aside = np.array([0.0, apart, 0.0])
    begun = hands[0].clock_s
    for side, state in ((inner, fist), (outer, touching)):
        ready = replace(_shifted(state, OUTWARD[side] * aside), air=1.0)
        hands[side].move(replace(ready, curls=curled(0.2)), stage.number("raise_speed"), _RISING_M)
    _both(hands, 0.3)
    hands[inner].move(fist, speed, least_s=0.5)
    hands[outer].move(touching, speed, least_s=0.5)
    _both(hands)
    hands[outer].move(clasp, speed, least_s=0.35)
    clasped = _both(hands)
    drift = stage.number("drift") * rng.uniform(-1.0, 1.0, 3) * np.array([0.5, 1.0, 0.7])
    hold_s = stage.number("hold")
    for side, state in ((inner, fist), (outer, clasp)):
        hands[side].move(_shifted(state, drift), 1.0, least_s=hold_s)
    opening = _both(hands)
    hands[outer].move(_shifted(touching, drift), speed, least_s=0.3)
    _both(hands)
    for side, state in ((inner, fist), (outer, touching)):
        away = _shifted(state, drift + OUTWARD[side] * aside)
        hands[side].move(replace(away, curls=curled(0.2), air=1.0), speed, least_s=0.5)
    parted = _both(hands, 0.3)
    for side in (0, 1):
        hands[side].move(stage.rest(side), stage.number("raise_speed"), _RISING_M)
    return stage.plan(
        hands,
        cues=(
            Cue("come_together", begun, clasped),
            Cue("clasp", clasped, opening),
            Cue("part", opening, parted),
        ),
    )


def _clap(stage: Stage) -> MotionPlan:
    """Palms meet at a steady tempo a number of times, wider the slower, and rest."""
    f, lift = stage.number("frequency"), stage.number("finger_lift")
    turn = 0.5 * stage.number("palm_turn")
    hands = _start(stage)
    centre = _centre(stage)
    # Speed pi f D / 2 of each hand at its fastest: a wide clap has to be a slow one.
    wide = min(stage.number("opening"), 2.0 * stage.number("top_speed") / (math.pi * f))
    flat = []
    for side in (0, 1):
        state = raised(side, centre, 0.0, -(lift - OUTWARD[side] * turn), 0.5 * math.pi, curl=0.08)
        flat.append(replace(state, air=0.0))
    to_right = np.array([0.0, OUTWARD[0], 0.0])
    met = _brought(stage, 1, flat[1], to_right, _bars(stage, 0, flat[0]))
    half = 0.5 * (met.position_m - flat[0].position_m)
    closed = (_shifted(flat[0], -half), _shifted(met, -half))
    opened = []
    for side in (0, 1):
        turned = about_z(-OUTWARD[side] * 0.12) @ closed[side].rotation
        aside = np.array([0.0, 0.5 * wide * OUTWARD[side], 0.0])
        opened.append(replace(_shifted(closed[side], aside), quaternion=quaternion_of(turned)))
        hands[side].move(opened[side], stage.number("raise_speed"), _RISING_M)
    begun = _both(hands, 0.3)
    tempo = Tempo(begun, f, round(stage.number("claps")))
    for side in (0, 1):
        hands[side].until(tempo.end_s + 0.3)
        hands[side].move(stage.rest(side), stage.number("raise_speed"), _RISING_M)
    paths: tuple[HandMotion, HandMotion] = (
        Clapping(hands[0].path(), tempo, opened[0], closed[0]),
        Clapping(hands[1].path(), tempo, opened[1], closed[1]),
    )
    # The k-th meeting is half a cycle into it; the tenth of a second about it counts.
    meetings = [begun + (k + 1) / f for k in range(tempo.cycles)]
    claps = tuple(Cue("clap", m - 0.05, m + 0.05) for m in meetings)
    return stage.plan(paths, cues=(Cue("clapping", begun, tempo.end_s), *claps))


def _roll_forearms(stage: Stage) -> MotionPlan:
    """The forearms roll round each other before the chest, fists closed."""
    radius = stage.number("radius")
    hands = _start(stage)
    centre = _centre(stage)
    towards = {"towards_cameras": 1.0, "towards_person": -1.0}[str(stage.values["direction"])]
    upper = stage.side("upper")
    spokes = []
    for side in (0, 1):
        spoke = np.array([0.0, 0.0, radius if side == upper else -radius])
        beside = np.array([0.0, OUTWARD[side] * stage.number("beside"), 0.0])
        state = raised(
            side, centre + spoke + beside, 1.15, 0.0, stage.number("thumb_up"), swivel_rad=0.55
        )
        fist = replace(state, curls=curled(0.7, thumb=0.5), air=1.0)
        hands[side].move(fist, stage.number("raise_speed"), _RISING_M)
        spokes.append(spoke)
    begun = _both(hands, 0.3)
    tempo = Tempo(begun, stage.number("frequency"), round(stage.number("turns")))
    for side in (0, 1):
        hands[side].until(tempo.end_s + 0.3)
        hands[side].move(stage.rest(side), stage.number("raise_speed"), _RISING_M)
    paths: tuple[HandMotion, HandMotion] = (
        Rolling(hands[0].path(), tempo, spokes[0], towards),
        Rolling(hands[1].path(), tempo, spokes[1], towards),
    )
    return stage.plan(paths, cues=(Cue("roll", begun, tempo.end_s),))


def _thing(values: Values) -> tuple[ObjectSpec, ...]:
    kind, size, rgb, yaw = _THINGS[str(values["thing"])]
    outward = OUTWARD[side_of(values, "giver")]
    place = (number(values, "thing_x"), outward * number(values, "thing_y"))
    return (ObjectSpec("thing", kind, size, rgb, place, yaw),)


def _thing_bars(thing: ObjectSpec, place: Transform) -> Capsules:
    """An upright thing as bars, for fingers to close on."""
    half = 0.5 * np.array(thing.size_m)
    if thing.kind == "ball":
        starts, radii = np.array([[0.0, 0.0, half[2]]]), half[:1]
        ends = starts + np.array([0.0, 0.0, 1e-4])
    else:
        thin = 0.012 if thing.kind == "box" else 0.82 * half[0]
        x, y = np.meshgrid(*(np.linspace(thin - h, h - thin, 4) for h in half[:2]))
        if thing.kind != "box":
            x = y = np.zeros(1)
        starts = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, min(thin, half[2]))])
        ends = starts + np.array([0.0, 0.0, max(thing.size_m[2] - 2.0 * thin, 1e-4)])
        radii = np.full(x.size, thin)
    return Capsules(starts, ends, radii).placed(place.position_m, place.rotation)


def _pass_object(stage: Stage) -> MotionPlan:
    """One hand brings a thing to the middle, the other takes it there and sets it down."""
    giver, speed = stage.side("giver"), stage.number("speed")
    taker = 1 - giver
    hands = _start(stage)
    thing = stage.scene.room.objects[0]  # what moves by itself comes after
    place = object_at_rest(stage.scene.room, thing.name)
    taking = grasp(stage.scene, giver, thing, place)
    gripped = _closed(stage, giver, taking.open, curled(0.7, thumb=0.7), _thing_bars(thing, place))
    begun = hands[giver].clock_s
    hands[giver].move(taking.before, speed, [0.0, 0.0, 0.03])
    hands[giver].move(taking.open, 0.5 * speed)
    hands[giver].move(gripped, speed, least_s=0.4)
    taken = hands[giver].clock_s
    # Up and to the middle; the hand turns so that its palm faces the other's.
    middle = Transform(_centre(stage), about_z(_turn_of(giver)) @ place.rotation)
    giving = _carried(gripped, place, middle)
    hands[giver].move(giving, speed, [0.02, 0.0, 0.03])
    brought = hands[giver].clock_s
    mirror = np.array([1.0, -1.0, 1.0])
    rotation = hand_rotation(taker, 0.45 - abs(_turn_of(giver)), 0.0, 1.45)
    facing = HandState(
        middle.position_m + mirror * (giving.position_m - middle.position_m),
        quaternion_of(rotation),
        taking.open.curls,
    )
    around = _together(_thing_bars(thing, middle), _bars(stage, giver, giving))
    inward = np.array([0.0, -OUTWARD[taker], 0.0])
    open_ = _brought(stage, taker, facing, inward, around)
    held = _closed(stage, taker, open_, curled(0.7, thumb=0.7), around)
    before = replace(_shifted(open_, -0.09 * inward - [0.05, 0.0, 0.0]), air=1.0)
    hands[taker].until(max(taken, brought - 0.8))
    hands[taker].move(before, speed, _RISING_M)
    _both(hands)
    hands[taker].move(open_, 0.6 * speed)
    hands[taker].move(held, speed, least_s=0.4)
    both = _both(hands)
    over = _both(hands, stage.number("both_hold"))
    away = np.array([-0.05, 0.09 * OUTWARD[giver], 0.0])
    hands[giver].move(replace(giving, curls=taking.open.curls), speed, least_s=0.35)
    hands[giver].move(
        replace(_shifted(giving, away), curls=taking.open.curls, air=1.0), 0.7 * speed
    )
    released = hands[giver].clock_s
    hands[giver].move(stage.rest(giver), speed, _RISING_M)
    # The taker goes on when the other hand has let go.
    hands[taker].until(released)
    y = OUTWARD[taker] * stage.number("put_y")
    down_m = np.array([stage.number("put_x"), y, place.position_m[2]])
    down = Transform(down_m, about_z(-_turn_of(taker)) @ middle.rotation)
    put = _carried(held, middle, down)
    hands[taker].move(replace(put, air=0.0), speed, [0.02, 0.0, 0.03])
    put_s = hands[taker].clock_s
    hands[taker].move(replace(put, curls=taking.open.curls, air=0.0), speed, least_s=0.4)
    back = -0.06 * put.rotation[:, 0] + 0.035 * put.rotation[:, 2] + np.array([0.0, 0.0, 0.01])
    hands[taker].move(replace(_shifted(put, back), curls=taking.open.curls, air=1.0), 0.5 * speed)
    hands[taker].move(stage.rest(taker), speed, [0.0, 0.0, 0.03])
    return stage.plan(
        hands,
        holds=(
            Hold(thing.name, giver, taken, over, put_down=False),
            Hold(thing.name, taker, over, put_s),
        ),
        cues=(
            Cue("reach", begun, taken),
            Cue(f"held_by:{_SIDES[giver]}", taken, both),
            Cue("held_by:both", both, over),
            Cue(f"held_by:{_SIDES[taker]}", over, put_s),
        ),
    )


def _turn_of(side: int) -> float:
    """How far a hand turns a thing about the vertical [rad] on its way to the middle."""
    return OUTWARD[side] * 0.35


def _carried(hand: HandState, thing: Transform, to: Transform) -> HandState:
    """The hand that held the thing where it was, now that it is at `to`; upright both times."""
    turn = to.rotation @ thing.rotation.T
    return replace(
        hand,
        position_m=to.position_m + turn @ (hand.position_m - thing.position_m),
        quaternion=quaternion_of(turn @ hand.rotation),
    )


def _together(a: Capsules, b: Capsules) -> Capsules:
    return Capsules(
        np.concatenate([a.starts_m, b.starts_m]),
        np.concatenate([a.ends_m, b.ends_m]),
        np.concatenate([a.radii_m, b.radii_m]),
    )


FAMILIES: Mapping[str, Family] = {
    "merge_and_hold": Family(
        (
            "outer",
            "hold",
            "speed",
            "raise_speed",
            "apart",
            "drift",
            "height",
            "centre_x",
            "wait",
        ),
        no_objects,
        _merge_and_hold,
    ),
    "clap": Family(
        (
            "frequency",
            "claps",
            "opening",
            "top_speed",
            "finger_lift",
            "palm_turn",
            "raise_speed",
            "height",
            "centre_x",
            "wait",
        ),
        no_objects,
        _clap,
    ),
    "roll_forearms": Family(
        (
            "frequency",
            "turns",
            "radius",
            "beside",
            "direction",
            "upper",
            "thumb_up",
            "raise_speed",
            "height",
            "centre_x",
            "wait",
        ),
        no_objects,
        _roll_forearms,
    ),
    "pass_object": Family(
        (
            "giver",
            "thing",
            "both_hold",
            "speed",
            "thing_x",
            "thing_y",
            "put_x",
            "put_y",
            "height",
            "centre_x",
            "wait",
        ),
        _thing,
        _pass_object,
    ),
}
