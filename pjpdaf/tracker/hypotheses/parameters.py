"""Parameters of the hypothesis tracker, by role."""

from __future__ import annotations

from dataclasses import dataclass, field

FRAME_S = 1 / 3  # the unit of the motion parameters [s]


@dataclass(frozen=True)
class CandidateParameters:
    """What a view offers as places of a target.

    halves: split hand blobs in two; beside_head: split a hand off the head's blob; ends: the far
    ends of a long blob, for bare forearms. draw_together: share of the distance between the two
    halves that is kept [1].
    """

    halves: bool = True
    beside_head: bool = True
    ends: bool = True
    palm: float = 0.75
    draw_together: float = 0.7
    split_area_m2: float = 0.008
    bare_length_m: float = 0.205
    hand_length_m: float = 0.17
    head_scale: float = 1.15
    beside_area_m2: float = 0.0012


@dataclass(frozen=True)
class MotionParameters:
    """Displacement in FRAME_S as a mixture of Gaussians: weights [1], deviations per axis [m]."""

    weights: tuple[float, ...] = (0.3, 0.45, 0.25)
    deviations_m: tuple[float, ...] = (0.012, 0.08, 0.32)
    head_weights: tuple[float, ...] = (0.8, 0.2)
    head_deviations_m: tuple[float, ...] = (0.012, 0.1)


@dataclass(frozen=True)
class NoiseParameters:
    """Deviations of a candidate's centre [px at 640 columns]: common to both views, and between
    them, for whole blobs, for parts of a blob, and for a hand held at the face.
    """

    whole_px: tuple[float, float] = (2.5, 0.7)
    part_px: tuple[float, float] = (8.0, 2.0)
    face_m: float = 0.06


@dataclass(frozen=True)
class CostParameters:
    """Negative logarithms of odds, beside a hand seen where it was expected."""

    epipolar_px: float = 4.0
    hand_area_m2: float = 0.011
    log_area_sd: float = 0.55
    log_area_up_sd: float = 0.35
    area_memory: float = 0.1
    stay_hidden: float = 5.0
    unexplained: float = 6.0
    miss: float = 9.0
    face: float = 4.0
    same_blob: float = 4.0
    lone_half: float = 4.0
    split: float = 0.0
    single_view: float = 3.0
    end: float = 0.5
    whole_arm: float = 2.0
    piece: float = 6.0


@dataclass(frozen=True)
class SleeveParameters:
    """The arm that is fitted to the silhouette [m] and what its evidence is worth."""

    weight: float = 6.0
    clip: float = 3.0
    memory_s: float = 1.0
    upper_arm_m: float = 0.280
    forearm_m: float = 0.345
    width_m: float = 0.076
    swivels: int = 16
    background: float = 1.5
    side_m: float = 0.175
    down_m: float = 0.165
    back_m: float = 0.06
    inward: float = 0.15
    axis: float = 0.7


@dataclass(frozen=True)
class HypothesisParameters:
    """All of the tracker's parameters."""

    candidates: CandidateParameters = field(default_factory=CandidateParameters)
    motion: MotionParameters = field(default_factory=MotionParameters)
    noise: NoiseParameters = field(default_factory=NoiseParameters)
    costs: CostParameters = field(default_factory=CostParameters)
    sleeve: SleeveParameters = field(default_factory=SleeveParameters)
    hypotheses: int = 5
    mean_within: float = 2.0
    lost_after_s: float = 1.0
    hand_offset_m: tuple[float, float, float] = (0.0, -0.003, 0.008)
    head_offset_m: tuple[float, float, float] = (0.0, -0.027, 0.015)
