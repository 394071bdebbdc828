"""Teaches the detector of a session the person-free scene and the skin of the person."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from pjpdaf.camera import undistort_picture
from pjpdaf.detector.blob_detector import BlobDetector
from pjpdaf.detector.detector import SkinDetector
from pjpdaf.detector.skin import SkinRange, learn_skin_from_head
from pjpdaf.detector.undistortion import UndistortPicture
from pjpdaf.errors import BenchError
from pjpdaf.interfaces import Detector
from pjpdaf.presets.override import with_values
from pjpdaf.sources import (
    stereo_frames,
)
from scenarios.footage.session import TrackSession
from scenarios.footage.skin_sample import HEAD
from scenarios.footage.usual_scene import usual_frames
from scenarios.play.settings import read_settings

HEAD_FRAMES = 30  # of the footage, after its background, that teach the skin
BROAD_SKIN = SkinRange((340.0, 50.0), (0.1, 0.85), 0.15)  # of any person, in usual light


def learn_scene(session: TrackSession, warn: Callable[[str], None]) -> TrackSession:
    """Learn the background and, where asked for, the skin of the head. Raises BenchError.

    Returns the session with the detector that has learnt them.
    """
    if session.request.detections is not None:
        return session
    detector = learn_background(session, warn)
    if session.request.skin_sample != Path(HEAD):
        return dataclasses.replace(session, detector=detector)
    base = detector.base if isinstance(detector, BlobDetector) else detector
    if not isinstance(base, SkinDetector):
        raise BenchError(f"--skin-sample {HEAD} is of the presets' detector; give a picture.")
    values = asdict(skin_of_head(session, base))
    given = read_settings(session.request.settings).detector
    values = {key: value for key, value in values.items() if key not in given}
    parameters = with_values(base.parameters, values)
    changed = dataclasses.replace(base, parameters=parameters)
    taught: Detector = changed
    if isinstance(detector, BlobDetector):
        taught = dataclasses.replace(detector, base=changed)
    named = {f"detector.{key}": value for key, value in values.items()}
    return dataclasses.replace(
        session,
        detector=taught,
        parameters={**session.parameters, **named},
        changed={**session.changed, **named},
    )


def learn_background(session: TrackSession, warn: Callable[[str], None]) -> Detector:
    """Learn the person-free scene; returns the detector that knows it. Raises BenchError."""
    request = session.request
    if request.no_background:
        warn(
            "--no-background: everything of the colour of skin is taken for skin, so a wall, a "
            "table or clothes of such a colour hide the hands."
        )
        return session.detector
    if request.background_from_footage:
        frames, parts = usual_frames(session.frames(), session.total)
        warn(
            "--background-from-footage: what rests becomes background, but for "
            f"{parts} parts of the colour of skin that are no larger than a head and inside the "
            "picture: they are taken for the person, and so is a box or a lamp of such a colour."
        )
        return session.detector.learn(frames)
    if request.background_first is not None:
        count = request.background_first
        if session.total is not None and count > session.total:
            raise BenchError(
                f"--background-first {count}: the footage has only {session.total} frames"
            )
        # Silent: the same pictures are named when they are tracked.
        return session.detector.learn(itertools.islice(session.frames(), count))
    left, right = request.background_left, request.background_right
    assert left is not None
    # Each view learns for itself: unlike lengths do no harm.
    return session.detector.learn(
        stereo_frames(left, right, session.rate_hz, session.sizes_px, warn, True, request.layout)
    )


def skin_of_head(session: TrackSession, detector: SkinDetector) -> SkinRange:
    """Learn the skin range from the highest skin-like region of the foreground (thesis 3.6)."""
    start = session.request.background_first or 0
    wide = dataclasses.replace(detector.parameters, skin=BROAD_SKIN)
    broad = dataclasses.replace(detector, parameters=wide, keep_masks=True)
    whole = isinstance(detector.parameters.undistort, UndistortPicture)
    pictures, masks = [], []
    for frame in itertools.islice(session.frames(), start, start + HEAD_FRAMES):
        for camera, picture, detections in zip(
            session.rig.cameras, frame.pictures, broad(frame), strict=True
        ):
            if picture is not None and detections.mask is not None:
                pictures.append(undistort_picture(camera, picture) if whole else picture)
                masks.append(detections.mask)
    return learn_skin_from_head(pictures, BROAD_SKIN, masks)
