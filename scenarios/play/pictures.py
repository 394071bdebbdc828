"""Pictures and film of an episode, collected while it is played."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pjpdaf.camera import Camera
from pjpdaf.follow import FollowedFrame
from reports.pictures.overlay import overlay_jpeg
from reports.pictures.stills import still
from reports.score.records import Episode, OverlayPicture, Still
from sim.truth import Truth

MAX_FILM_FRAMES = 600
MAX_PICTURES = 12
EVENLY_SPACED_PICTURES = 5


class PictureCollector:
    """Collects pictures and film of an episode; `add` is called for every frame, in order.

    cameras: those that filmed; frame_count: of the episode; pictures: keep overlay pictures of the
    frames that a `PictureChooser` chooses; film: keep a small plain picture of every frame, or, of
    more than `MAX_FILM_FRAMES`, of every second, third, ... frame.
    """

    def __init__(
        self, cameras: Sequence[Camera], frame_count: int, *, pictures: bool, film: bool
    ) -> None:
        self._cameras = cameras
        self._chooser = PictureChooser(frame_count) if pictures else None
        self._film_step = -(-frame_count // MAX_FILM_FRAMES) if film else 0
        self._pictures: list[OverlayPicture] = []
        self._film: list[Still] = []

    def add(self, followed: FollowedFrame, truth: Truth) -> None:
        """Draw the frame, if it is to be kept."""
        frame = followed.frame
        if self._chooser is not None and self._chooser.chooses(truth):
            picture = overlay_jpeg(
                frame, self._cameras, followed.detections, followed.estimates, truth
            )
            self._pictures.append(OverlayPicture(frame.index, picture))
        if self._film_step and frame.index % self._film_step == 0:
            self._film.append(Still(frame.index, still(frame, self._cameras)))

    def added_to(self, episode: Episode) -> Episode:
        """The episode with the collected pictures and film."""
        return replace(episode, pictures=tuple(self._pictures), film=tuple(self._film))


class PictureChooser:
    """Chooses frames to keep as pictures: evenly spaced, and where merges begin or end."""

    def __init__(self, frame_count: int) -> None:
        step = max(1, (frame_count - 1) // (EVENLY_SPACED_PICTURES - 1)) if frame_count > 1 else 1
        self._even = set(range(0, frame_count, step))
        self._merged: tuple[bool, ...] = ()
        self._left = MAX_PICTURES - len(self._even)

    def chooses(self, truth: Truth) -> bool:
        """Whether to keep this frame; called for every frame, in order."""
        merged = tuple(bool(view.merged.any()) for view in truth.views)
        changed = self._merged != merged and bool(self._merged)
        self._merged = merged
        if truth.index in self._even:
            return True
        if changed and self._left > 0:
            self._left -= 1
            return True
        return False
