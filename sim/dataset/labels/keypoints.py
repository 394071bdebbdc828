"""Keypoints of head and hands: their positions, pixels and visibility."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from sim.anatomy import Anatomy
from sim.dataset.labels.records import KEYPOINTS
from sim.dataset.labels.visibility import BodyPoints, project_points
from sim.lens import Lens
from sim.person.hand import Finger, fingers, joint_angles, palm_surface
from sim.person.head import head_surface
from sim.pose import Pose, Transform
from sim.vectors import about

# The fold between lower lip and chin, in half heights of the head below its centre; the foremost
# point of the surface's mid-line below the fold is the chin (the pogonion of anatomy).
CHIN_FOLD = 0.62
CHIN_M = 0.010  # depth of the chin's bulge, of which the keypoint is the top
MIRROR = np.array([1.0, -1.0, 1.0])  # right hand -> left hand
_OWNERS = np.array([target for target, _ in KEYPOINTS])
_SHOWN_BY = np.arange(256) == 1 + _OWNERS[:, None]  # by instance ids


class Keypoints:
    """The keypoints of a person, in the order of `records.KEYPOINTS`.

    head_centre is the head frame's origin, inside the head; chin the foremost point of the drawn
    face's chin, on its surface; wrist and palm_centre as in `sim.pose.Pose`, inside the hand; a
    finger's tip is the end of its last bone, the middle of the drawn finger's round end, which
    reaches farther by its radius (6 to 8 mm).
    """

    def __init__(self, anatomy: Anatomy) -> None:
        self._fingers = fingers(anatomy)
        self._wrist = np.array([-anatomy.wrist_to_palm_m, 0.0, 0.0])
        self._chin = chin(anatomy)
        # Half axes of the ellipsoid that stands for the part of the body around each keypoint.
        head = np.array([anatomy.head_depth_m, anatomy.head_breadth_m, anatomy.head_height_m]) / 2
        hand = [
            *(palm_half_m(anatomy) for _ in ("wrist", "palm_centre")),
            *(np.full(3, finger.radii_m[-1]) for finger in self._fingers),
        ]
        self._half_m = np.array([head, np.full(3, CHIN_M), *hand, *hand])

    def positions(self, pose: Pose) -> Floats:
        """World positions (K, 3) [m]."""
        head = placed(pose.head, np.array([np.zeros(3), self._chin]))
        return np.concatenate([head, *placed_hands(pose, self._in_hand)])

    def project(
        self,
        pose: Pose,
        camera: Camera,
        lens: Lens | None,
        instances: NDArray[np.uint8],
        depth_m: NDArray[np.float32],
    ) -> tuple[Floats, NDArray[np.int8]]:
        """Pixels (K, 2) and status (K,) of `project_points` in a view that shows this pose.

        The part of the body around a keypoint is an ellipsoid of the size of the head, palm or
        wrist; for a tip of its finger's radius, for the chin, on the surface, of CHIN_M.
        """
        turns = np.array([pose.head.rotation, *(hand.rotation for hand in pose.hands)])
        points = BodyPoints(self.positions(pose), turns[_OWNERS], self._half_m, _SHOWN_BY)
        return project_points(points, camera, lens, instances, depth_m)

    def _in_hand(self, curls: Floats) -> Floats:
        """The right hand's keypoints (7, 3) in its own frame."""
        chains = [chain(f, float(curl)) for f, curl in zip(self._fingers, curls, strict=True)]
        return np.array([self._wrist, np.zeros(3), *(points[-1] for points in chains)])


def chain(finger: Finger, curl: float) -> Floats:
    """The joints and the tip (4, 3) of a finger in the right hand's frame [m]."""
    at, turned = finger.base_m, finger.rotation
    points = [at]
    for length, angle in zip(finger.lengths_m, joint_angles(finger, curl), strict=True):
        turned = turned @ about(finger.axis, float(angle))
        at = at + length * turned[:, 0]
        points.append(at)
    return np.array(points)


def chin(anatomy: Anatomy) -> Floats:
    """The chin (3,) in the head frame [m]: a vertex of the drawn face, in its mid-line."""
    face = head_surface(anatomy).vertices_m
    middle = face[(np.abs(face[:, 1]) < 1e-9) & (face[:, 0] > 0)]
    below = middle[middle[:, 2] < -CHIN_FOLD * anatomy.head_height_m / 2]
    return np.asarray(below[np.argmax(below[:, 0])])


def palm_half_m(anatomy: Anatomy) -> Floats:
    """Half axes (3,) [m] of the ellipsoid that stands for a palm, as wide along it as across."""
    _, broad, thick = np.ptp(palm_surface(anatomy).vertices_m, axis=0) / 2
    return np.array([broad, broad, thick])


def placed_hands(pose: Pose, in_hand: Callable[[Floats], Floats]) -> list[Floats]:
    """Points (n, 3) of the right and the left hand in the world.

    in_hand: gives those of a right hand in its own frame, of its fingers' curls (5,).
    """
    right, left = (in_hand(curls) for curls in pose.curls)
    return [placed(part, own) for part, own in zip(pose.hands, (right, left * MIRROR), strict=True)]


def placed(part: Transform, points: Floats) -> Floats:
    """Points (n, 3) of a part's frame in the world."""
    return np.asarray(part.position_m + points @ part.rotation.T)
