"""Names and numbers of a data set on disk; what `conventions.json` tells its readers."""

from __future__ import annotations

import re
from typing import Any

from pjpdaf.targets import TARGETS
from sim.dataset.labels.records import HIDDEN, KEYPOINTS, NO_SURFACE, OUT_OF_FRAME, SEEN
from sim.scene.world import CAMERAS, ZFAR_M, ZNEAR_M

KIND = "pjpdaf-bench data set"
SCHEMA_VERSION = 1
MANIFEST, CONVENTIONS, CHECKSUMS, CARD = (
    "manifest.json",
    "conventions.json",
    "SHA256SUMS",
    "README.md",
)
TRUTH, OBJECTS, EVENTS, RECIPE, RIG = (
    "truth.parquet",
    "objects.parquet",
    "events.json",
    "recipe.json",
    "rig.json",
)
CALIBRATION = "calib"  # of a sequence, and of the data set where all sequences have the same
ERROR_FREE = "error_free"  # below it, where the calibration that is given has errors
PART = ".part-"  # begins the names of folders that are still written

# What can be written beside the pictures and the truth; each is one or more folders of a sequence.
LABELS: dict[str, tuple[str, ...]] = {
    "clean": ("clean_left", "clean_right"),
    "depth": ("depth_left", "depth_right"),
    "seg": ("seg_left", "seg_right"),
    "amodal": ("amodal_left", "amodal_right"),
    "disparity": ("disparity_left", "disparity_right", "occlusion_left", "occlusion_right"),
    "correspondence": ("correspondence_left", "correspondence_right"),
    "float": ("float_left", "float_right"),
}
DEFAULT_LABELS = ("depth", "seg", "amodal", "disparity")
EXPORTS = ("coco", "mot", "webdataset", "parquet")  # other formats, beside the sequences

DEPTH_UNIT_M = 1e-4
DISPARITY_SCALE = 256.0
FLOW_SCALE, FLOW_ZERO = 64.0, 2**15
_SEQUENCE = re.compile(r"seq_\d{6}")


def sequence_name(index: int) -> str:
    """Folder of the sequence of this number, from 0."""
    return f"seq_{index:06d}"


def is_sequence_name(name: str) -> bool:
    """Whether a manifest may name this folder: nothing outside the data set has such a name."""
    return _SEQUENCE.fullmatch(name) is not None


def picture_name(index: int, suffix: str = ".png") -> str:
    """File of the frame of this index (from 0); files are numbered from 1, as MOTChallenge does."""
    return f"{index + 1:06d}{suffix}"


def conventions() -> dict[str, Any]:
    """Everything that a reader must know to use the numbers."""
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
        "keypoints": [f"{target}:{name}" for target, name in _keypoint_names()],
        "keypoint_meaning": "a finger tip is the end of its last bone, 6 to 8 mm inside the drawn "
        "tip",
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
        "float": "NPZ of float32: depth_m, and disparity_px and places_px where they are written",
        "shutter_skew": "the right view's pictures and masks are of its own, later moment; all 3-D "
        "truth, disparity and correspondence are of the left view's",
        "time": "time_s: when the frame was taken; stamp_s: what it says",
        "cameras": list(CAMERAS),
    }


def _keypoint_names() -> list[tuple[str, str]]:
    return [(TARGETS[target], name) for target, name in KEYPOINTS]
