"""Poses of a script over the frames of a sequence, as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.pose import Pose, Transform
from sim.script import Script


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
    """The poses of a script at these times, one after the other."""
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
        objects=_objects(poses),
    )


def _objects(poses: Sequence[Pose]) -> Mapping[str, Places]:
    return {name: _places([p.objects[name] for p in poses]) for name in poses[0].objects}


def _places(transforms: Sequence[Transform]) -> Places:
    positions = np.array([t.position_m for t in transforms])
    rotations = np.array([t.rotation for t in transforms])
    return Places(positions, rotations)
