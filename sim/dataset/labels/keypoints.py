"""Keypoints of head and hands: their positions, pixels and visibility."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, project, to_camera
from pjpdaf.targets import HEAD, LEFT_HAND, RIGHT_HAND
from sim.anatomy import Anatomy
from sim.dataset.labels.records import KEYPOINTS, NOT_LABELLED, OCCLUDED, VISIBLE
from sim.lens import Lens, real_pixels
from sim.person.hand import FINGERS, fingers, joint_angles, palm_surface
from sim.person.head import head_surface
from sim.pose import Pose, Transform
from sim.vectors import about

# The fold between lower lip and chin, in half heights of the head below its centre; the foremost
# point of the surface's mid-line below the fold is the chin (the pogonion of anatomy).
CHIN_FOLD = 0.62
CHIN_M = 0.010  # depth of the chin's bulge, of which the keypoint is the top
# Parts are no ellipsoids: a nose and the palm's square edges reach up to this much farther, and
# so does the last bone of a finger seen along its length.
MARGIN = 1.5
MIRROR = np.array([1.0, -1.0, 1.0])  # right hand -> left hand


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
        palm = palm_surface(anatomy).vertices_m
        _, broad, thick = np.ptp(palm, axis=0) / 2
        hand = [
            *(np.array([broad, broad, thick]) for _ in ("wrist", "palm_centre")),
            *(np.full(3, finger.radii_m[-1]) for finger in self._fingers),
        ]
        self._half_m = np.array([head, np.full(3, CHIN_M), *hand, *hand])

    def positions(self, pose: Pose) -> Floats:
        """World positions (K, 3) [m]."""
        right, left = (self._in_hand(curls) for curls in pose.curls)
        head = _placed(pose.head, np.array([np.zeros(3), self._chin]))
        hands = [
            _placed(part, own) for part, own in zip(pose.hands, (right, left * MIRROR), strict=True)
        ]
        return np.concatenate([head, *hands])

    def project(
        self,
        pose: Pose,
        camera: Camera,
        lens: Lens | None,
        instances: NDArray[np.uint8],
        depth_m: NDArray[np.float32],
    ) -> tuple[Floats, NDArray[np.int8]]:
        """Real pixels (K, 2) and status (K,) of the keypoints of a pose in a view that shows it.

        VISIBLE: the keypoint's pixel shows its target's skin, and that surface belongs to the part
        of the body around the keypoint: it lies no more than MARGIN times the part's half thickness
        before it, measured along the ray through an ellipsoid of the part's size (head,
        palm, wrist; for a tip its finger's radius, for the chin, on the surface, CHIN_M). So a
        finger before the palm of its own hand hides it, and so do hair and glasses.
        OCCLUDED: anything else inside the picture. NOT_LABELLED: outside it, or behind the camera.
        The pixel is NaN behind the camera and beyond the reach of the lens.
        """
        places = self.positions(pose)
        inside = to_camera(camera, places)
        ideal = project(camera, places).astype(np.float32)
        pixels = np.stack(real_pixels(camera, lens, ideal[:, 0], ideal[:, 1]), axis=-1).astype(
            float
        )
        status = np.full(len(places), NOT_LABELLED, np.int8)
        height, width = depth_m.shape
        parts = {HEAD: pose.head, RIGHT_HAND: pose.hands[0], LEFT_HAND: pose.hands[1]}
        for k, (target, _) in enumerate(KEYPOINTS):
            x, y = np.floor(pixels[k] + 0.5)
            if not (0 <= x < width and 0 <= y < height):
                continue
            at = int(y), int(x)
            range_m = float(np.linalg.norm(inside[k]))
            along = camera.R_cw.T @ (inside[k] / range_m)
            half_m = 1 / np.linalg.norm(parts[target].rotation.T @ along / self._half_m[k])
            before_m = range_m - depth_m[at] * range_m / inside[k, 2]
            mine = instances[at] == 1 + target
            status[k] = VISIBLE if mine and before_m <= MARGIN * half_m else OCCLUDED
        return pixels, status

    def _in_hand(self, curls: Floats) -> Floats:
        """The right hand's keypoints (7, 3) in its own frame."""
        tips = []
        for finger, curl in zip(self._fingers, curls, strict=True):
            at, turned = finger.base_m, finger.rotation
            for length, angle in zip(
                finger.lengths_m, joint_angles(finger, float(curl)), strict=True
            ):
                turned = turned @ about(finger.axis, float(angle))
                at = at + length * turned[:, 0]
            tips.append(at)
        assert len(tips) == len(FINGERS)
        return np.array([self._wrist, np.zeros(3), *tips])


def chin(anatomy: Anatomy) -> Floats:
    """The chin (3,) in the head frame [m]: a vertex of the drawn face, in its mid-line."""
    face = head_surface(anatomy).vertices_m
    middle = face[(np.abs(face[:, 1]) < 1e-9) & (face[:, 0] > 0)]
    below = middle[middle[:, 2] < -CHIN_FOLD * anatomy.head_height_m / 2]
    return np.asarray(below[np.argmax(below[:, 0])])


def _placed(part: Transform, points: Floats) -> Floats:
    """Points (n, 3) of a part's frame in the world."""
    return np.asarray(part.position_m + points @ part.rotation.T)
