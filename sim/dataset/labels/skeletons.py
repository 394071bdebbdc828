"""Skeletons: 21 joints a hand, COCO's points of the upper body, and the fingers' angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.targets import HEAD
from sim.dataset.labels.keypoints import chain, palm_half_m, placed, placed_hands
from sim.dataset.labels.records import BODY_POINTS, HAND_JOINTS
from sim.dataset.labels.visibility import BodyPoints, project_points
from sim.lens import Lens
from sim.person.geoms import HAND_TARGETS, SKIN
from sim.person.hand import FINGERS, fingers, joint_angles
from sim.person.landmarks import nose_and_eyes
from sim.pose import SIDES, Pose
from sim.scene.world import World

SURFACE_M = 0.010  # depth of the surface around a point that lies on it: nose, eye
# Around the joints of a person of AVERAGE_M [m]: an arm or thigh that points at the camera reaches
# so far before its end.
SHOULDER_M, ELBOW_M, HIP_M = 0.080, 0.080, 0.100
FINGER_M = 0.010  # likewise a finger, pad and knuckle included; a thicker one reaches its radius
AVERAGE_M = 1.72
_BY_SIDE = ("left", "right")  # as in COCO
_INDEX = {side: index for index, side in enumerate(SIDES)}


class Skeletons:
    """The skeletons of a world's person, in the order of `records.SKELETONS`.

    A joint of a hand is where its bones meet, inside the finger; a tip is the end of the last
    bone. Of the body: the tip of the nose and the middle of each eye, on the drawn face; the
    middle of each ear; shoulder, elbow and wrist, where the bones meet; the hip, where the thigh
    begins.
    """

    def __init__(self, world: World) -> None:
        scene = world.scene
        assert scene is not None, "only a scene with a person has skeletons"
        anatomy = scene.anatomy
        self._fingers = fingers(anatomy)
        self._wrist = np.array([-anatomy.wrist_to_palm_m, 0.0, 0.0])
        ears = [_Part.of(world, f"{SKIN}ear:{side}") for side in _BY_SIDE]
        self._face = np.array([*nose_and_eyes(anatomy), *(ear.position_m for ear in ears)])
        self._ear_rotations = np.array([ear.rotation for ear in ears])
        self._hips_m = np.array([_Part.of(world, f"thigh:{side}").origin_m for side in _BY_SIDE])
        palm_m = palm_half_m(anatomy)
        k = anatomy.stature_m / AVERAGE_M
        # The first joint of a finger lies in the palm, the others in the finger.
        joints_m = [
            [palm_m, *(np.full(3, max(r, FINGER_M)) for r in f.radii_m[1:])] for f in self._fingers
        ]
        self._half_m = np.array(
            [
                *(np.full(3, SURFACE_M) for _ in range(3)),
                *(ear.half_m for ear in ears),
                *(np.full(3, k * radius) for radius in (SHOULDER_M, ELBOW_M) for _ in SIDES),
                *(palm_m for _ in SIDES),
                *(np.full(3, k * HIP_M) for _ in SIDES),
                *(2 * [palm_m, *(m for finger in joints_m for m in finger)]),
            ]
        )
        self._shown_by = _shown_by(world)
        assert len(self._half_m) == len(self._shown_by) == len(BODY_POINTS) + 2 * len(HAND_JOINTS)

    def positions(self, pose: Pose) -> Floats:
        """World positions (P, 3) [m]."""
        hands = placed_hands(pose, self._in_hand)
        joints = [
            *(pose.upper_arms[_INDEX[side]].position_m for side in _BY_SIDE),
            *(pose.forearms[_INDEX[side]].position_m for side in _BY_SIDE),
            *(hands[_INDEX[side]][0] for side in _BY_SIDE),
        ]
        return np.concatenate([placed(pose.head, self._face), joints, self._hips_m, *hands])

    def finger_angles(self, pose: Pose) -> Floats:
        """Flexion (2, 5, 3) [rad] of the right and left hand's fingers, from the wrist on."""
        return np.array(
            [
                [joint_angles(f, float(curl)) for f, curl in zip(self._fingers, curls, strict=True)]
                for curls in pose.curls
            ]
        )

    def project(
        self,
        pose: Pose,
        camera: Camera,
        lens: Lens | None,
        geoms: NDArray[np.int32],
        depth_m: NDArray[np.float32],
    ) -> tuple[Floats, NDArray[np.int8]]:
        """Pixels (P, 2) and status (P,) of `project_points` in a view that shows this pose.

        geoms (h, w): geom ids of the view. The surfaces of a joint are those of the two parts that
        meet in it (of a tip the last one's, of the nose and eyes the face's, of an ear its own),
        near enough: an ellipsoid of the size of the palm, a ball of the thickness of a finger, or
        of an average arm or thigh.
        """
        head, hands = pose.head.rotation, [hand.rotation for hand in pose.hands]
        rotations = np.array(
            [
                *(head for _ in range(3)),
                *(head @ ear for ear in self._ear_rotations),
                *(np.eye(3) for _ in range(4)),
                *(hands[_INDEX[side]] for side in _BY_SIDE),
                *(np.eye(3) for _ in SIDES),
                *(hand for hand in hands for _ in HAND_JOINTS),
            ]
        )
        points = BodyPoints(self.positions(pose), rotations, self._half_m, self._shown_by)
        return project_points(points, camera, lens, geoms, depth_m)

    def _in_hand(self, curls: Floats) -> Floats:
        """The right hand's joints (21, 3) in its own frame."""
        chains = [chain(f, float(curl)) for f, curl in zip(self._fingers, curls, strict=True)]
        return np.concatenate([self._wrist[None], *chains])


def _shown_by(world: World) -> NDArray[np.bool_]:
    """Whether a geom is of the part around a point (P, ngeom + 1); the last is of no geom."""
    model = world.model
    bodies = np.array([model.body(int(b)).name for b in model.geom_bodyid])
    names = np.array([model.geom(g).name for g in range(model.ngeom)])
    skin = world.targets
    ears = [names == f"{SKIN}ear:{side}" for side in _BY_SIDE]
    face = (skin == HEAD) & ~ears[0] & ~ears[1]
    arms = [f"{part}:{side}" for part in ("upper_arm", "forearm") for side in SIDES]
    clothed = {body: (bodies == body) & (skin < 0) for body in ("torso", *arms)}
    palms = {
        side: (bodies == f"hand:{side}") & (skin == target)
        for side, target in zip(SIDES, HAND_TARGETS, strict=True)
    }
    rows = [
        *(face for _ in range(3)),
        *ears,
        *(clothed["torso"] | clothed[f"upper_arm:{side}"] for side in _BY_SIDE),
        *(clothed[f"upper_arm:{side}"] | clothed[f"forearm:{side}"] for side in _BY_SIDE),
        *(clothed[f"forearm:{side}"] | palms[side] for side in _BY_SIDE),
        *(clothed["torso"] | (names == f"thigh:{side}") for side in _BY_SIDE),
    ]
    for side, target in zip(SIDES, HAND_TARGETS, strict=True):
        rows.append(palms[side])
        for finger in FINGERS:
            parts = [(bodies == f"{finger}{i}:{side}") & (skin == target) for i in range(3)]
            meeting = [palms[side], *parts]
            rows += [a | b for a, b in zip(meeting, [*parts, parts[-1]], strict=True)]
    return np.pad(np.array(rows), ((0, 0), (0, 1)))


@dataclass(frozen=True, eq=False)
class _Part:
    """A geom of the person, in the frame of its body (the world's, for a part that never moves).

    position_m (3,), rotation (3, 3), half_m (3,): its box; origin_m (3,): of the mesh as it was
    added.
    """

    position_m: Floats
    rotation: Floats
    half_m: Floats
    origin_m: Floats

    @staticmethod
    def of(world: World, name: str) -> _Part:
        model = world.model
        geom = model.geom(name).id
        mesh = int(model.geom_dataid[geom])
        own = Rotation.from_quat(model.geom_quat[geom], scalar_first=True).as_matrix()
        # MuJoCo moves a mesh into its principal axes, and the geom by as much.
        moved = Rotation.from_quat(model.mesh_quat[mesh], scalar_first=True).as_matrix()
        at = np.array(model.geom_pos[geom])
        origin = at - own @ moved.T @ model.mesh_pos[mesh]
        return _Part(at, own, np.array(model.geom_aabb[geom, 3:]), origin)
