"""conventions.json: the units, axes and meanings of a data set's numbers."""

from __future__ import annotations

from typing import Any

from pjpdaf.targets import TARGETS
from sim.camera.normal_shader import STEPS, ZERO
from sim.dataset.files.layout import DEPTH_UNIT_M, DISPARITY_SCALE, FLOW_SCALE, FLOW_ZERO
from sim.dataset.labels.classes import CLASS_GROUPS, CLASSES
from sim.dataset.labels.records import (
    HIDDEN,
    KEYPOINTS,
    NO_SURFACE,
    OUT_OF_FRAME,
    SEEN,
    SKELETONS,
)
from sim.scene.world import CAMERAS, ZFAR_M, ZNEAR_M


def conventions() -> dict[str, Any]:
    """Content of conventions.json: units, axes and the meaning of every number."""
    return {
        "units": "metres, seconds, radians, pixels; names end in _m, _mps, _s, _rad, _px",
        "world": "x from the person towards the cameras, y to the person's left, z up; origin on "
        "the floor under the mid-shoulder point",
        "camera": "OpenCV axes: x right, y down, z forward; X_camera = R_cw X_world + t_cw; "
        "X_right = R X_left + T",
        "pixel": "(0, 0) is the centre of the top-left pixel",
        "left_right": "hands are the person's own; cameras are those of the robot that looks at "
        "the person, so the person's left hand is on the right of the picture",
        "frames": "frame_index counts from 0; files and MOTChallenge count from 1",
        "quaternion": "w, x, y, z, part to world",
        "velocity": "central difference over 10 ms",
        "targets": "head = skin of face, ears and visible neck; hand = skin of palm, fingers and "
        "wrist; position = centre of the head, of the palm; surface = mean of the visible skin's "
        "surface points over both views",
        "left": "8 bit BGR order on reading with OpenCV, RGB in the file",
        "depth": {
            "meaning": "planar z, not range, at the pixel centre",
            "unit_m": DEPTH_UNIT_M,
            "invalid": 0,
            "range_m": [ZNEAR_M, min(ZFAR_M, round(65535 * DEPTH_UNIT_M, 4))],
        },
        "seg": "one byte an instance, named in rig.json",
        "amodal": {"bit_0": "head", "bit_1": "right_hand", "bit_2": "left_hand"},
        "amodal_meaning": "the target's skin with all other things removed; its own hair, collar "
        "and cuff still cover it",
        "visible_fraction": "visible / amodal pixels, both inside the picture",
        "truncation": "share of the amodal target outside the picture, out to half a picture's "
        "size beyond each border",
        "box": "x, y, width, height of the visible skin, 0-based, width = max - min + 1",
        "keypoints": [f"{TARGETS[target]}:{name}" for target, name in KEYPOINTS],
        "keypoint_meaning": "a finger tip is the end of its last bone, 6 to 8 mm inside the drawn "
        "tip",
        "skeletons": {name: list(points) for name, points in SKELETONS.items()},
        "skeleton_meaning": "joints of a hand: where its bones meet, inside the finger; cmc, mcp, "
        "ip of the thumb, mcp, pip, dip of a finger, tip as of the keypoints; person: COCO's "
        "points of the upper body: tip of the nose and middle of each eye on the drawn face, "
        "middle of each ear, joints of shoulder, elbow, wrist and hip",
        "finger_angles_rad": "flexion of each joint of thumb, index, middle, ring and little "
        "finger, from the wrist on; 0 is straight; the first against the finger's own direction in "
        "the palm, the others against the bone before",
        "keypoint_status": {"0": "outside the picture", "1": "occluded", "2": "visible"},
        "disparity": {
            "meaning": "x_left - x_right on the pair rectified by R1 R2 P1 P2 of extrinsics.yml",
            "scale": DISPARITY_SCALE,
            "invalid": 0,
        },
        "occlusion": {
            str(NO_SURFACE): "no surface, or outside the real picture",
            str(SEEN): "seen in the other view",
            str(HIDDEN): "hidden in the other view",
            str(OUT_OF_FRAME): "outside the other view",
            "bound": "within 1 px behind an edge, hidden may be called seen",
        },
        "correspondence": {
            "meaning": "where the surface of a pixel lies in the other view's picture; channels of "
            "the file, 16 bit: dx, dy, status as in occlusion",
            "scale": FLOW_SCALE,
            "zero": FLOW_ZERO,
            "formula": "x_other = x + (channel_0 - zero) / scale, likewise y",
        },
        "semantic": {
            "classes": {str(i): name for i, name in enumerate(CLASSES)},
            "groups": {name: list(classes) for name, classes in CLASS_GROUPS.items()},
            "meaning": "one byte a class; face: skin of face and ears, with painted brows, lips "
            "and beard; hand: skin of palm, fingers and wrist; arm: bare skin above the wrist; "
            "table: with its legs; shelf: shelves, boards, bookcases and cupboards with books; "
            "chair: with its cushion; other_person: in the background; clutter: anything "
            "else of the room; objects are the instances of seg",
        },
        "normals": {
            "meaning": "unit normal of the surface as it is lit, in the camera's frame (x right, y "
            "down, z forward, so z < 0 faces the camera); red, green, blue of the file are x, y, "
            "z; of a mesh, interpolated between its vertices",
            "scale": STEPS,
            "zero": ZERO,
            "formula": "component = (byte - zero) / scale; 0 0 0 where there is no surface",
            "bound_deg": 0.4,
        },
        "flow": {
            "meaning": "where the surface of a pixel is in the same view's picture of the next "
            "frame (flow_forward) or the one before (flow_backward); channels, scale and zero as "
            "in correspondence: the status is 1 seen, 2 hidden, 3 outside the other picture; "
            "of the renders, also where a picture was lost; the last frame has no forward flow, "
            "the first no backward",
            "scale": FLOW_SCALE,
            "zero": FLOW_ZERO,
            "bound": "within 1 px behind an edge, hidden may be called seen; 511 px at most",
        },
        "float": "NPZ of float32: depth_m, and disparity_px and places_px where they are written",
        "shutter_skew": "the right view's pictures and masks are of its own, later moment; all 3-D "
        "truth, disparity and correspondence are of the left view's",
        "time": "time_s: when the frame was taken; stamp_s: what it says",
        "cameras": list(CAMERAS),
    }
