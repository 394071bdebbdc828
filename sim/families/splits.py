"""All and objects: targets in one blob, or a target in two."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sim.contact.contact import hand_capsules, height_above_table
from sim.families.on_head import Laying, laid_on_head
from sim.motion.motion import Cue, Hold, MotionPlan, object_at_rest
from sim.motion.planner import HandPlanner, curled, grasp, raised
from sim.motion.stage import STILL_S, Family, Stage, Values, no_objects, number, side_of
from sim.motion.strokes import HandState, quaternion_of
from sim.person.kinematics import OUTWARD, hand_rotation
from sim.pose import Transform
from sim.specs import ObjectSpec
from sim.vectors import cross, norm

SIDES = ("right", "left")


# Both hands on the head.

# Where the left hand lies, in shares of the head's half axes (x out of the face, y outward, z up),
# and where its fingers point, in the head's frame.
_PLACES: Mapping[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "cheeks": ((0.62, 0.72, -0.25), (-0.15, 0.0, 1.0)),
    "forehead": ((0.85, 0.45, 0.35), (0.0, -0.35, 0.9)),
    "face": ((0.95, 0.45, -0.20), (-0.1, -0.15, 1.0)),
}
_BETWEEN_M = 0.004  # from either hand to the head's mid-plane, so that tremor is not contact


def _on_head(stage: Stage, side: int) -> HandState:
    """The hand laid on its place of the head while the other one is laid there too."""
    spot, fingers = np.array([1.0, OUTWARD[side], 1.0]) * _PLACES[str(stage.values["where"])]
    laying = Laying(
        spot,
        fingers,
        np.array([0.0, 0.0, -0.17 * stage.scene.anatomy.hand_breadth_m]),
        curled(stage.number("curl")),
        own_side_m=_BETWEEN_M,
        twists_rad=(0.0, 0.15, -0.15),
        tilts_rad=(0.0, 0.12, 0.25, 0.4),
    )
    # The head is where it will be while both hands follow it.
    like, other = (
        replace(
            stage.rest(hand),
            air=0.1,
            with_head=1.0,
            nod_rad=0.5 * stage.number("nod"),
            swivel_rad=stage.number("swivel"),
        )
        for hand in (side, 1 - side)
    )
    return laid_on_head(stage, side, laying, like, other)


def _both_hands_to_head(stage: Stage) -> MotionPlan:
    """Both hands go to the head, stay, and come back."""
    speed = stage.number("speed")
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    on = (_on_head(stage, 0), _on_head(stage, 1))
    before = [
        replace(h, position_m=h.position_m + 0.08 * (h.rotation[:, 2] + [1, 0, 0])) for h in on
    ]
    begun = STILL_S + stage.number("wait")
    late = stage.number("lag")
    for side in (0, 1):
        hands[side].until(begun + (late if side == stage.side("second") else 0.0))
        # Forward of the shoulder: no elbow folds enough for the straight way.
        away = np.array([0.12, OUTWARD[side] * 0.03, 0.0])
        hands[side].move(before[side], speed, away)
        hands[side].move(on[side], 0.5 * speed)
    there = max(hand.clock_s for hand in hands)
    left = there + stage.number("hold")
    for side in (0, 1):
        hands[side].until(left)
        hands[side].move(before[side], 0.5 * speed)
        hands[side].move(stage.rest(side), speed, [0.12, OUTWARD[side] * 0.03, 0.0])
    cues = (
        Cue("to_head", begun, there),
        Cue("on_head", there, left),
        Cue("back", left, max(hand.clock_s for hand in hands)),
    )
    return stage.plan(hands, cues=cues)


# A dark thing over a hand.

_BEHIND_M = 0.06  # of the thing, beyond the little finger of the hand that holds it
_IN_FIST_M = np.array([0.028, 0.0, -0.022])  # the thing's axis in the hand's frame


def _tool_size(values: Values) -> tuple[float, float, float]:
    if values["what"] == "rod":
        return number(values, "length"), number(values, "thickness"), number(values, "thickness")
    return number(values, "length"), number(values, "breadth"), 0.008


def _tool_objects(values: Values) -> tuple[ObjectSpec, ...]:
    """The thing; it is in the hand from the start, so that its place here is never seen."""
    kind = {"rod": "rod", "board": "sheet"}[str(values["what"])]
    dark = (0.07, 0.075, 0.085)
    return (ObjectSpec("tool", kind, _tool_size(values), dark, (0.45, 0.0)),)


def _over_hand(stage: Stage) -> tuple[HandState, HandState, Transform]:
    """The hand that holds the tool: at rest, and with the tool laid over the other hand; the grip.

    The tool lies across the fingers of the other hand, whichever way that one is turned.
    """
    side, scene, tool = stage.side("hand"), stage.scene, stage.scene.room.objects[0]
    anatomy, top, holder = scene.anatomy, scene.room.table_height_m, 1 - side
    lying = stage.rest(side)
    length, breadth, thick = tool.size_m
    up = np.array([0.0, 0.0, 1.0])
    forward = lying.rotation[:, 0] * [1.0, 1.0, 0.0]
    forward = forward / norm(forward)
    across = OUTWARD[side] * np.array([-forward[1], forward[0], 0.0])
    placed = np.column_stack([across, cross(up, across), up])
    shape = hand_capsules(anatomy, side, lying.curls).placed(lying.position_m, lying.rotation)
    under = 0.002 + float((np.maximum(shape.starts_m, shape.ends_m)[:, 2] + shape.radii_m).max())
    # What lies higher covers, seen from the cameras, a place further back.
    rig, palm_z = scene.rig, float(lying.position_m[2])
    back = (rig.distance_m - float(lying.position_m[0])) / (rig.height_m - palm_z)
    if stage.values["what"] == "rod":
        line = stage.number("across") + back * (under + 0.5 * thick - palm_z)
    else:  # from the palm's centre to the tips: 0.57 of the hand
        line = 0.57 * anatomy.hand_length_m - stage.number("bare") - 0.5 * breadth
        line += back * (under + thick - palm_z)
    # Its end is a little past the lying hand's outer edge.
    beyond = 0.5 * anatomy.hand_breadth_m + 0.025
    middle = lying.position_m + line * forward + (beyond - 0.5 * length) * across
    middle[2] = under
    rotation = hand_rotation(holder, stage.number("holder_inward"), 0.0, 0.0)
    fist = curled(0.62, thumb=0.5)
    in_fist = middle - (0.5 * length - _BEHIND_M) * across + np.array([0.0, 0.0, 0.5 * thick])
    palm = in_fist - rotation @ _IN_FIST_M
    grip = Transform(rotation.T @ (middle - palm), rotation.T @ placed)
    laid = HandState(palm, quaternion_of(rotation), fist, air=0.0)
    # At rest neither the fist nor the tool is in the table.
    low = max(height_above_table(anatomy, holder, rotation, fist), float(palm[2]) - under) + 0.001
    place = stage.rest(holder, -0.02, 0.06).position_m
    start = replace(laid, position_m=np.array([place[0], place[1], top + low]))
    return start, laid, grip


def _object_splits_hand(stage: Stage) -> MotionPlan:
    """One hand lays what it holds across the other, which lies on the table, and takes it back."""
    side, speed = stage.side("hand"), stage.number("speed")
    holder, tool = 1 - side, stage.scene.room.objects[0]
    start, laid, grip = _over_hand(stage)
    lift = np.array([0.0, 0.0, stage.number("lift")])
    above = replace(laid, position_m=laid.position_m + lift, air=1.0)
    hand, lying = HandPlanner(start), HandPlanner(stage.rest(side))
    hand.until(STILL_S + stage.number("wait"))
    hand.move(above, speed, [0.0, 0.0, 0.04])
    hand.move(laid, 0.5 * speed)
    laid_s = hand.clock_s
    hand.wait(stage.number("hold"))
    lifted_s = hand.clock_s
    hand.move(above, 0.5 * speed)
    hand.move(start, speed, [0.0, 0.0, 0.04])
    # One second more than the film: it is never let go.
    hold = Hold(tool.name, holder, 0.0, stage.duration_s + 1.0, grip=grip, put_down=False)
    hands = (hand, lying) if holder == 0 else (lying, hand)
    return stage.plan(hands, (hold,), (Cue("covered", laid_s, lifted_s),))


# A thing of the colour of skin.


def _wood_objects(values: Values) -> tuple[ObjectSpec, ...]:
    """A block of wood near the colour of skin."""
    tone = number(values, "tone")
    red, green, blue = 0.80 * tone, 0.58 * tone, 0.43 * tone
    outward = OUTWARD[side_of(values, "hand")]
    place = (number(values, "block_x"), outward * number(values, "block_y"))
    size = (0.055, 0.07, number(values, "tall"))
    return (ObjectSpec("block", "block", size, (red, green, blue), place, yaw_rad=0.2 * outward),)


def _skin_coloured_object(stage: Stage) -> MotionPlan:
    """A hand takes the block, shows it before the chest, sets it down further out, and rests."""
    side, speed = stage.side("hand"), stage.number("speed")
    outward, block = OUTWARD[side], stage.scene.room.objects[0]
    taking = grasp(stage.scene, side, block, object_at_rest(stage.scene.room, block.name))
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    hand = hands[side]
    hand.until(STILL_S + stage.number("wait"))
    hand.move(taking.before, speed, [0.0, 0.0, 0.03])
    hand.move(taking.open, 0.5 * speed)
    hand.move(taking.closed, speed, least_s=0.4)
    taken = hand.clock_s
    rng = stage.streams("shows")
    for _ in range(round(stage.number("shows"))):
        shift = np.array([-0.04, outward * 0.1, 0.1]) + rng.uniform(
            [-0.03, -0.06, 0.0], [0.03, 0.06, 0.14]
        )
        shown = replace(taking.closed, position_m=taking.closed.position_m + shift, air=1.0)
        hand.move(shown, speed, [0.0, 0.0, 0.02])
        hand.wait(stage.number("pause"))
    moved = np.array([0.0, outward * stage.number("put_dy"), 0.0])
    put = replace(taking.closed, position_m=taking.closed.position_m + moved)
    hand.move(put, speed)
    put_s = hand.clock_s
    hand.move(replace(put, curls=taking.open.curls), speed, least_s=0.4)
    away = replace(taking.before, position_m=taking.before.position_m + moved)
    hand.move(away, 0.5 * speed)
    hand.move(stage.rest(side), speed, [0.0, 0.0, 0.03])
    return stage.plan(
        hands, (Hold(block.name, side, taken, put_s),), (Cue("carried", taken, put_s),)
    )


# Bare forearms.


def _bare_forearm(stage: Stage) -> MotionPlan:
    """Talking hands: forearms stood up, laid forward, spread; they are skin, but no target."""
    hands = (HandPlanner(stage.rest(0)), HandPlanner(stage.rest(1)))
    top = stage.scene.room.table_height_m
    cues = []
    for side in (0, 1):
        hand, rng = hands[side], stage.streams(f"gestures-{side}")
        hand.until(STILL_S + stage.number("wait") + 0.8 * rng.random())
        while hand.clock_s < stage.duration_s:
            # One draw each whatever the kind, so that a longer sequence begins like a shorter one.
            kind = str(rng.choice(["stand", "forward", "spread"], p=[0.5, 0.25, 0.25]))
            ahead, out, up = rng.random(3).tolist()
            speed = stage.number("speed") * rng.uniform(0.6, 1.0)
            pause = stage.number("pause") * rng.uniform(0.5, 1.5)
            outward = OUTWARD[side]
            if kind == "stand":
                place = [0.22 + 0.06 * ahead, outward * (0.2 + 0.08 * out), top + 0.24 + 0.1 * up]
                to = raised(side, place, 0.2, -1.0, 0.9, curl=0.2)
            elif kind == "forward":
                place = [0.38 + 0.06 * ahead, outward * (0.14 + 0.1 * out), top + 0.1 + 0.05 * up]
                to = raised(side, place, 0.3, 0.0, 0.7, curl=0.2)
            else:
                place = [0.28 + 0.06 * ahead, outward * (0.34 + 0.1 * out), top + 0.16 + 0.1 * up]
                to = raised(side, place, -0.2, -0.4, 0.9, curl=0.15)
            begun = hand.clock_s
            hand.move(to, speed, [0.0, outward * 0.02, 0.02])
            hand.wait(pause)
            cues.append(Cue(f"{kind}:{SIDES[side]}", begun, hand.clock_s))
    return stage.plan(hands, cues=tuple(cues))


FAMILIES: Mapping[str, Family] = {
    "both_hands_to_head": Family(
        ("where", "second", "lag", "speed", "wait", "hold", "nod", "curl", "swivel"),
        no_objects,
        _both_hands_to_head,
    ),
    "object_splits_hand": Family(
        (
            "hand",
            "what",
            "length",
            "thickness",
            "breadth",
            "across",
            "bare",
            "holder_inward",
            "speed",
            "wait",
            "hold",
            "lift",
        ),
        _tool_objects,
        _object_splits_hand,
    ),
    "skin_coloured_object": Family(
        (
            "hand",
            "tone",
            "tall",
            "block_x",
            "block_y",
            "put_dy",
            "shows",
            "pause",
            "speed",
            "wait",
        ),
        _wood_objects,
        _skin_coloured_object,
    ),
    "bare_forearm": Family(("speed", "pause", "wait"), no_objects, _bare_forearm),
}
