"""The pictures that the page of footage shows."""

from __future__ import annotations

from collections.abc import Callable

from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Estimates
from pjpdaf.targets import TARGETS
from reports.words import LABELS

MAX_EVEN_PICTURES = 12
MAX_EVENT_PICTURES = 5


class Gallery:
    """Evenly spaced frames of footage of unknown length, and the first frames of each event."""

    def __init__(self) -> None:
        self._stride = 1
        self._even: dict[int, bytes] = {}
        self._events: dict[int, tuple[str, bytes]] = {}
        self._known: set[str] = set()

    def offer(self, frame: StereoFrame, estimates: Estimates, picture: Callable[[], bytes]) -> None:
        """Consider the next frame; `picture` makes its JPEG and is called only if it is kept."""
        new_events = self._new_events(frame, estimates)
        wanted = frame.index % self._stride == 0
        if wanted and len(self._even) == MAX_EVEN_PICTURES:
            self._stride *= 2
            self._even = {i: p for i, p in self._even.items() if i % self._stride == 0}
            wanted = frame.index % self._stride == 0
        if not (new_events or wanted):
            return
        jpeg = picture()
        if wanted:
            self._even[frame.index] = jpeg
        if new_events:
            self._events[frame.index] = (", ".join(new_events), jpeg)

    def pictures(self, period_s: float) -> list[tuple[str, bytes]]:
        """Caption and JPEG of the kept frames, in order."""
        pictures = self._even | {i: p for i, (_, p) in self._events.items()}
        captioned = []
        for index, jpeg in sorted(pictures.items()):
            events = self._events[index][0] if index in self._events else ""
            caption = f"frame {index}, {index * period_s:.1f} s"
            captioned.append((f"{caption}: {events}" if events else caption, jpeg))
        return captioned

    def _new_events(self, frame: StereoFrame, estimates: Estimates) -> list[str]:
        """Events of a frame that no earlier frame had."""
        if len(self._events) >= MAX_EVENT_PICTURES:
            return []
        events = []
        if "waiting" not in estimates.status:
            events.append("tracking begins")
        if any(p is None for p in frame.pictures):
            events.append("picture missing")
        events += [
            f"{LABELS[target]} lost"
            for target, status in zip(TARGETS, estimates.status, strict=True)
            if status == "lost"
        ]
        new_events = [event for event in events if event not in self._known]
        self._known.update(events)
        return new_events
