"""Poses of a script over the frames of a sequence, as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.motion.motion import Performer, object_at_rest
from sim.pose import Transform
from sim.scene.extras import WithExtras
from sim.script import Script
from sim.silhouettes.arms_over import ArmsOver
from sim.silhouettes.planned_arms import planned_arms


@dataclass(frozen=True, eq=False)
class Places:
    """Rigid poses over F frames: positions_m (F, 3), rotations (F, 3, 3) part -> world."""

    positions_m: Floats
    rotations: Floats

    def moved(self, points_m: Floats) -> Floats:
        """Points of the part (n, 3), or (F, n, 3), in the world (F, n, 3)."""
        return np.asarray(points_m @ self.rotations.swapaxes(1, 2) + self.positions_m[:, None])


@dataclass(frozen=True, eq=False)
class PoseTrack:
    """Poses at times_s (F,), frames as in `sim.pose.Pose`; pairs are right, left.

    torso, head, hands: places; shoulders_m, elbows_m, wrists_m (F, 2, 3); curls (F, 2, 5);
    objects: name -> places.
    """

    times_s: Floats
    torso: Places
    head: Places
    hands: tuple[Places, Places]
    shoulders_m: Floats
    elbows_m: Floats
    wrists_m: Floats
    curls: Floats
    objects: Mapping[str, Places]

    @property
    def centres_m(self) -> Floats:
        """Centres of head, right palm, left palm (F, 3, 3)."""
        parts = (self.head, *self.hands)
        return np.stack([part.positions_m for part in parts], axis=1)


def pose_track(script: Script, anatomy: Anatomy, times_s: Sequence[float]) -> PoseTrack:
    """The poses of a script at these times: a performer's all at once, others' one by one.

    All at once differs from `Script.pose` by rounding only.
    """
    if isinstance(script, WithExtras):
        track = pose_track(script.script, anatomy, times_s)
        moved = {
            name: _places([extra.at(t_s) for t_s in times_s])
            for name, extra in script.extras.tracks.items()
        }
        return replace(track, objects={**track.objects, **moved})
    if isinstance(script, Performer):
        return _performer_track(script, times_s)
    return one_by_one(script, anatomy, times_s)


def one_by_one(script: Script, anatomy: Anatomy, times_s: Sequence[float]) -> PoseTrack:
    """The poses of a script at these times, each by `Script.pose`."""
    poses = [script.pose(t_s) for t_s in times_s]
    hands = (_places([p.hands[0] for p in poses]), _places([p.hands[1] for p in poses]))
    palm = anatomy.wrist_to_palm_m
    wrists = [hand.positions_m - palm * hand.rotations[:, :, 0] for hand in hands]
    return PoseTrack(
        times_s=np.array(times_s, dtype=np.float64),
        torso=_places([p.torso for p in poses]),
        head=_places([p.head for p in poses]),
        hands=hands,
        shoulders_m=np.array([[arm.position_m for arm in p.upper_arms] for p in poses]),
        elbows_m=np.array([[arm.position_m for arm in p.forearms] for p in poses]),
        wrists_m=np.stack(wrists, axis=1),
        curls=np.array([p.curls for p in poses]),
        objects={n: _places([p.objects[n] for p in poses]) for n in poses[0].objects},
    )


def _performer_track(performer: Performer, times_s: Sequence[float]) -> PoseTrack:
    planned = planned_arms(performer, times_s)
    joints = np.stack([_joints(arm) for arm in planned.arms], axis=1)  # (F, 2, 4, 3)
    turned = np.stack([arm.hand for arm in planned.arms], axis=1)
    for frame in np.flatnonzero(planned.may_touch).tolist():
        for side, solved in enumerate(performer.body(times_s[frame]).arms):
            joints[frame, side] = (
                solved.shoulder_m,
                solved.elbow_m,
                solved.wrist_m,
                solved.palm_m,
            )
            turned[frame, side] = solved.hand
    places = (
        Places(joints[:, 0, 3], turned[:, 0]),
        Places(joints[:, 1, 3], turned[:, 1]),
    )
    return PoseTrack(
        times_s=planned.times_s,
        torso=Places(*planned.torso),
        head=Places(*planned.head),
        hands=places,
        shoulders_m=joints[:, :, 0],
        elbows_m=joints[:, :, 1],
        wrists_m=joints[:, :, 2],
        curls=np.stack(planned.curls, axis=1),
        objects=_objects_over(performer, planned.times_s, places),
    )


def _joints(arm: ArmsOver) -> Floats:
    return np.stack([arm.shoulder_m, arm.elbow_m, arm.wrist_m, arm.palm_m], axis=1)


def _objects_over(
    performer: Performer, times_s: Floats, hands: tuple[Places, Places]
) -> Mapping[str, Places]:
    """Places of the room's objects, held and put down as the plan has it."""
    frames, room = len(times_s), performer.scene.room
    objects = {}
    for spec in room.objects:
        rest = object_at_rest(room, spec.name)
        objects[spec.name] = Places(
            np.tile(rest.position_m, (frames, 1)), np.tile(rest.rotation, (frames, 1, 1))
        )
    for hold, grip, down in performer.carried:
        places, hand = objects[hold.name], hands[hold.side]
        held = (times_s >= hold.from_s) & (times_s < hold.to_s)
        turn = hand.rotations[held]
        places.positions_m[held] = hand.positions_m[held] + turn @ grip.position_m
        places.rotations[held] = turn @ grip.rotation
        left = times_s >= hold.to_s
        places.positions_m[left], places.rotations[left] = down.position_m, down.rotation
    return objects


def _places(transforms: Sequence[Transform]) -> Places:
    positions = np.array([t.position_m for t in transforms])
    rotations = np.array([t.rotation for t in transforms])
    return Places(positions, rotations)
