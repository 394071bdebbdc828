"""Names of a data set's files and folders, and the scales of its 16-bit pictures."""

from __future__ import annotations

import re

KIND = "pjpdaf-bench data set"
SCHEMA_VERSION = 2
OLDEST_VERSION = 1  # that can be read; without skeletons
MANIFEST, CONVENTIONS, CHECKSUMS, CARD = (
    "manifest.json",
    "conventions.json",
    "SHA256SUMS",
    "README.md",
)
TRUTH, OBJECTS, SKELETON, EVENTS, RECIPE, RIG = (
    "truth.parquet",
    "objects.parquet",
    "skeletons.parquet",
    "events.json",
    "recipe.json",
    "rig.json",
)
CALIBRATION = "calib"  # of a sequence, and of the data set where all sequences have the same
ERROR_FREE = "error_free"  # below it, where the calibration that is given has errors
PART = ".part-"  # prefix of the names of unfinished folders

# Labels beside the pictures and the truth; each is one or more folders of a sequence.
LABELS: dict[str, tuple[str, ...]] = {
    "clean": ("clean_left", "clean_right"),
    "depth": ("depth_left", "depth_right"),
    "seg": ("seg_left", "seg_right"),
    "amodal": ("amodal_left", "amodal_right"),
    "disparity": ("disparity_left", "disparity_right", "occlusion_left", "occlusion_right"),
    "correspondence": ("correspondence_left", "correspondence_right"),
    "semantic": ("semantic_left", "semantic_right"),
    "normals": ("normals_left", "normals_right"),
    "flow": (
        *("flow_forward_left", "flow_forward_right"),
        *("flow_backward_left", "flow_backward_right"),
    ),
    "float": ("float_left", "float_right"),
}
DEFAULT_LABELS = ("depth", "seg", "amodal", "disparity")
# Small enough for many frames: nothing of 32 bits, nothing that others say.
TRAINING_LABELS = ("depth", "seg", "disparity", "semantic")
EXPORTS = (  # other formats, beside the sequences
    *("coco", "mot", "webdataset", "parquet"),
    *("yolo-pose", "yolo-seg", "middlebury", "hdf5"),
)
# The label without which a format cannot be made.
EXPORTS_NEED = {"coco": "seg", "yolo-seg": "seg", "middlebury": "disparity"}

DEPTH_UNIT_M = 1e-4
DISPARITY_SCALE = 256.0
FLOW_SCALE, FLOW_ZERO = 64.0, 2**15
_SEQUENCE = re.compile(r"seq_\d{6}")


def sequence_name(index: int) -> str:
    """Name of a sequence's folder; index from 0."""
    return f"seq_{index:06d}"


def is_sequence_name(name: str) -> bool:
    """Whether a name is that of a sequence's folder, which cannot lead out of the data set."""
    return _SEQUENCE.fullmatch(name) is not None


def picture_name(index: int, suffix: str = ".png") -> str:
    """Name of a frame's file; index from 0, files are numbered from 1 as in MOTChallenge."""
    return f"{index + 1:06d}{suffix}"


def frames_with(folder: str, frames: int) -> range:
    """The frames of a sequence that have a file in a folder of labels: flow needs a neighbour."""
    first = int(folder.startswith("flow_backward"))
    return range(first, max(frames - int(folder.startswith("flow_forward")), first))
