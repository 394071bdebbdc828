"""Semantic classes against the instance ids, and against another frame of the still room."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sim.dataset.check.fault import Fault
from sim.dataset.check.frame.arrays import FrameArrays, present
from sim.dataset.check.frame.view import still_pixels
from sim.dataset.labels.classes import CLASSES, class_id
from sim.dataset.labels.instances import FIRST_OBJECT, MAX_ID, NOTHING, PERSON, ROOM, TABLE

_ROOM = CLASSES[class_id("floor") :]
_PARTS: dict[int, tuple[str, ...]] = {
    NOTHING: ("nothing",),
    1: ("face", "neck"),
    2: ("hand",),
    3: ("hand",),
    PERSON: ("hair", "glasses", "arm", "hand", "face", "clothes"),
    TABLE: ("table",),
    ROOM: _ROOM,
    **dict.fromkeys(range(FIRST_OBJECT, MAX_ID + 1), ("object", "other_person")),
}
_ALLOWED = np.zeros((MAX_ID + 1, 256), bool)  # by instance id and class
for _id, _names in _PARTS.items():
    _ALLOWED[_id, [class_id(name) for name in _names]] = True


def check_classes(frame: FrameArrays, view: int, reference: FrameArrays | None) -> Iterator[Fault]:
    """Check the classes of a view, given ids without fault; the first fault.

    reference: a frame without fault; table and room show the same classes there.
    """
    own, file = frame.views[view], frame.file("semantic", view)
    seg, classes = present(own.seg), present(own.classes)
    if int(classes.max()) >= len(CLASSES):
        yield Fault(file, f"has the class {int(classes.max())}; known are 0 to {len(CLASSES) - 1}")
        return
    wrong = ~_ALLOWED[seg, classes]
    if wrong.any():
        y, x = np.argwhere(wrong)[0].tolist()
        text = f"{CLASSES[classes[y, x]]} where the id is {seg[y, x]}"
        yield Fault(file, f"calls {int(wrong.sum())} pixels other than their ids allow: {text}")
        return
    if reference is None:
        return
    before = reference.views[view]
    if before.seg is None or before.classes is None:
        return
    changed = int(np.count_nonzero(still_pixels(own, before) & (classes != before.classes)))
    if changed:
        other = reference.file("semantic", view)
        yield Fault(file, f"has other classes at {changed} pixels of the still room than {other}")
