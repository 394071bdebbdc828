"""Records of a played episode before it is scored: frozen, picklable, nothing computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.targets import TARGETS
from sim.truth import Truth

VIEWS = ("left", "right")
STAGES = ("render", "detect", "track")
# Levels of the error budget, each with one more cause of error than the level before.
BUDGET_LEVELS = ("grid", "surface", "detector", "filter", "association")


@dataclass(frozen=True, eq=False)
class FrameOutcome:
    """A frame: truth, the tracker's estimates, the detector's detections.

    detections: per view, may be empty; stage_s: wall time of a stage of `STAGES` [s].
    """

    truth: Truth
    estimates: Estimates
    detections: tuple[Detections, ...] = ()
    stage_s: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class OverlayPicture:
    """Both views of a frame with overlays, a JPEG of `overlay.overlay_jpeg`."""

    frame: int
    jpeg: bytes


@dataclass(frozen=True)
class Still:
    """Both views of a frame, small and plain, a WebP of `stills.still`."""

    frame: int
    webp: bytes


@dataclass(frozen=True, eq=False)
class Episode:
    """A scenario played with one seed.

    cameras: left, right, as the cameras really are; frames in order, at least one;
    digest: of the concrete scenario; values: its drawn parameters; redrawn: how many draws of this
    seed were thrown away because they could not be posed; film: some frames, or all of them.
    blame: (kind, target, first) of an event -> the stage at fault for it. budget_m: level of
    `BUDGET_LEVELS` -> error (F, T) [m], NaN where a level has none. renderer: description of the
    OpenGL renderer of its pictures, "" where not known; replayed: they were in the cache;
    detections_kept: so were all of its detections, whose time is that which they took once.
    Raises ValueError where views, targets or frames do not fit together.
    """

    scenario: str
    group: str
    seed: int
    fps: float
    cameras: tuple[Camera, ...]
    frames: tuple[FrameOutcome, ...]
    digest: str = ""
    values: Mapping[str, float | str] = field(default_factory=dict)
    pictures: tuple[OverlayPicture, ...] = ()
    redrawn: int = 0
    film: tuple[Still, ...] = ()
    blame: Mapping[tuple[str, int, int], str] = field(default_factory=dict)
    budget_m: Mapping[str, Floats] = field(default_factory=dict)
    renderer: str = ""
    replayed: bool = False
    detections_kept: bool = False

    def __post_init__(self) -> None:
        name = f"Episode {self.scenario!r} seed {self.seed}"
        if len(self.cameras) != len(VIEWS):
            raise ValueError(f"{name} must have {len(VIEWS)} cameras, got {len(self.cameras)}")
        if not self.frames:
            raise ValueError(f"{name} must have at least one frame")
        if not self.fps > 0:
            raise ValueError(f"{name}: fps must be > 0, got {self.fps}")
        for outcome in self.frames:
            truth, status = outcome.truth, outcome.estimates.status
            if len(truth.centres_m) != len(TARGETS) or len(status) != len(TARGETS):
                raise ValueError(f"{name} frame {truth.index} must have {len(TARGETS)} targets")
            if len(truth.views) != len(VIEWS):
                raise ValueError(f"{name} frame {truth.index} must have {len(VIEWS)} views")


FailureKind = Literal["unposable", "plug-in", "time limit", "worker died", "exception"]


@dataclass(frozen=True)
class EpisodeFailure:
    """An episode that gave no result. kind: for programs; reason: a line for people."""

    scenario: str
    seed: int
    reason: str
    group: str = ""
    digest: str = ""
    kind: FailureKind = "exception"
