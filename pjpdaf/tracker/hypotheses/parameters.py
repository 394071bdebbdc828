"""Parameters of the hypothesis tracker, by role."""

from __future__ import annotations

from dataclasses import dataclass, field

from pjpdaf.checks import AboveZero, AboveZeroInt, NotNegative, check_bounds

FRAME_S = 1 / 3  # the unit of time of the motion parameters [s]
OWNER = "HypothesisParameters"


@dataclass(frozen=True)
class CandidateParameters:
    """Parts of blobs that may be hands."""

    # Hand blobs are split in two halves.
    halves: bool = True
    # A blob that both views show is cut in both at once, where the outlines' depths part.
    halve_together: bool = True
    # Hands are split off the head's blob.
    beside_head: bool = True
    # The hand is an end of a long blob where forearms are bare.
    ends: bool = True
    # Two hands on bare arms that meet are in the middle between the ends.
    middles: bool = True
    # Least thickness of a blob that is a bare arm, its short axis [m].
    arm_thickness_m: NotNegative = 0.03
    # A hand that was near the head and is seen nowhere else is in the head's blob.
    missing_hand: bool = True
    # A head's blob that is larger only because the head came nearer shows nothing but the head.
    nearer_head: bool = True
    # Of two pieces of one bare arm the nearer one is the hand, at the start.
    arm_pieces: bool = True
    # Pieces of the head, as a fringe or glasses cut it, are one blob.
    join_head: bool = True
    # How much of two halves' distance goes for each share of two hands' area that is hidden [1].
    draw_together: NotNegative = 1.5
    # Share of the vector from the fingers to the palm by which a whole hand's centre is moved up or
    # down, fitted [1].
    palm: NotNegative = 0.85
    # Smallest blob that is split [m^2].
    split_area_m2: AboveZero = 0.008
    # Mean length of the longer hand's blob from which forearms are bare [m].
    bare_length_m: AboveZero = 0.205
    # Length of a hand [m].
    hand_length_m: AboveZero = 0.15
    # Size of the head's ellipse whose outside is no head, over the remembered one [1].
    head_scale: AboveZero = 1.15
    # Smallest piece beside the head [m^2].
    beside_area_m2: AboveZero = 0.0012

    def __post_init__(self) -> None:
        check_bounds(OWNER, self)


@dataclass(frozen=True)
class MotionParameters:
    """Displacement in FRAME_S, per axis: a mixture of Gaussians (resting, moving, fast)."""

    # Weights of a hand's modes [1] and their deviations [m].
    weights: tuple[float, float, float] = (0.3, 0.45, 0.25)
    deviations_m: tuple[float, float, float] = (0.012, 0.08, 0.32)
    # The same of the head.
    head_weights: tuple[float, float] = (0.8, 0.2)
    head_deviations_m: tuple[float, float] = (0.012, 0.1)
    # A hand that vanishes goes on for as long, ever slower; 0: it stays where it was seen [s].
    coast_s: NotNegative = 0.35
    # Movement from frame to frame at which motion counts half for the names of two places [m]; 0 =
    # motion counts in full, however fast the hands are.
    naming_step_m: NotNegative = 0.08
    # Time over which the speed is a mean [s].
    speed_memory_s: AboveZero = 0.3

    def __post_init__(self) -> None:
        check_bounds(OWNER, self)


@dataclass(frozen=True)
class NoiseParameters:
    """Deviations of the places of candidates: common to both views, and between them.

    Half a hand that is hidden moves both views' centres alike, which says nothing of the depth.
    """

    # Of whole blobs [px at 640 columns].
    whole_px: tuple[float, float] = (2.5, 0.7)
    # Of parts of blobs [px at 640 columns].
    part_px: tuple[float, float] = (8.0, 2.0)
    # How far the outlines of halves that are cut together are behind the hands: fingers go on
    # behind the palm where hands meet before the person, fitted [m].
    halves_behind_m: float = 0.02
    # How far the centre of a whole hand is behind that of its skin for each metre by which the palm
    # is above it: fingers that point down in the picture point at the camera, fitted [1].
    tilt: float = 1.0
    # Of a whole hand's centre between the views, in its radii for each unit of the logarithm by
    # which the views' areas differ: one view alone hides a part of it [1].
    hidden_share: NotNegative = 0.35
    # A difference between the moments of the two views is learnt and taken out.
    learn_skew: bool = True
    # Of a hand somewhere at the face, per axis [m].
    face_m: AboveZero = 0.06
    # Places before the face, from its middle: sideways and up or down [m]; 0 = its middle alone.
    face_reach_m: NotNegative = 0.05

    def __post_init__(self) -> None:
        check_bounds(OWNER, self)


@dataclass(frozen=True)
class CostParameters:
    """Negative log-odds, beside those of a hand seen where it was expected."""

    # Deviation of a point from two views' rays [px at 640 columns].
    epipolar_px: AboveZero = 4.0
    # Visible area of an open hand [m^2], and the deviations of its logarithm below and above [1].
    hand_area_m2: AboveZero = 0.011
    log_area_sd: AboveZero = 0.55
    log_area_up_sd: AboveZero = 0.35
    # Share of a frame in the learnt area [1].
    area_memory: NotNegative = 0.1
    # Hands that the picture's edge cuts in one view have their depth from the side that is left.
    cut_hands: bool = True
    # Pieces beside the head have their depth from the outlines that are their own.
    contours: bool = True
    # A blob like a hand that is nobody's.
    unexplained: NotNegative = 6.0
    # A blob like a hand that only one view shows and is nobody's.
    unexplained_single: NotNegative = 3.0
    # A hand that is not seen, in the first such frame and after.
    miss: NotNegative = 9.0
    stay_hidden: NotNegative = 5.0
    # A hand at the face while the head's blob hides it.
    face: NotNegative = 4.0
    # A hand behind the head; 0 = no hand is taken to be there.
    behind: NotNegative = 2.0
    # Two hands on one blob, undivided.
    same_blob: NotNegative = 4.0
    # Of two hands on one blob of bare arms, one at an end, where the other is no hand: the elbow.
    end_and_half: NotNegative = 4.0
    # A half whose other half is nobody's.
    lone_half: NotNegative = 4.0
    # A split.
    split: NotNegative = 0.0
    # A hand that only one view shows.
    single_view: NotNegative = 3.0
    # An end of a bare arm.
    end: NotNegative = 0.0
    # An end of a bare arm that is further away than the other, for each of these lengths [m].
    forward_m: float = 0.04
    # A piece of face or neck.
    piece: NotNegative = 6.0
    # A blob that no arm joins to the person; 0 = nothing is asked of the silhouette.
    apart: NotNegative = 6.0

    def __post_init__(self) -> None:
        check_bounds(OWNER, self)


@dataclass(frozen=True)
class SleeveParameters:
    """The arm that is fitted to the silhouette, and what its evidence is worth."""

    # Log-odds per difference of the two sides' scores, 0 = no sleeve evidence; their bound.
    sleeve_weight: NotNegative = 8.0
    sleeve_clip: NotNegative = 4.0
    # Time in which evidence of earlier frames fades to 1/e [s]: successive frames of one merge are
    # not independent.
    memory_s: NotNegative = 1.0
    # Shoulder to elbow, elbow to palm, width of a sleeve [m].
    upper_arm_m: AboveZero = 0.280
    forearm_m: AboveZero = 0.345
    sleeve_width_m: AboveZero = 0.076
    # Places of the elbow that are tried, round the line from shoulder to hand.
    swivels: AboveZeroInt = 16
    # Background under the arm counts this much against it [1]; clothes outside the torso count 1.
    bare_background: NotNegative = 1.5
    # Skin under a sleeve, which would hide it, counts this much against the arm [1].
    covered_skin: NotNegative = 0.5
    # Shoulders from the centre of the head's skin, camera axes: to the side, down, away [m].
    side_m: float = 0.175
    down_m: float = 0.165
    back_m: float = 0.06
    # Penalty of an elbow turned inwards or up.
    inward_penalty: NotNegative = 0.15
    # Weight of the fingers' direction, which goes on along the forearm.
    finger_weight: NotNegative = 1.2
    # The fingers' length of a half of two merged hands, over that of a hand by itself; 0 = not
    # looked for [1].
    half_fingers: NotNegative = 3.0
    # Half the thickness below which a part of such a half is fingers [m].
    thin_m: AboveZero = 0.02
    # Share of the vector to a wrist, a thick part of the hand beside the palm, that counts as
    # fingers on the other side [1].
    wrist_share: float = 1.0

    # The same length for an end of a bare arm, which points away from the arm's middle [1].
    bare_arm_fingers: NotNegative = 0.25

    def __post_init__(self) -> None:
        check_bounds(OWNER, self)


@dataclass(frozen=True)
class OffsetParameters:
    """From the centre of the visible skin to the centre of the body, camera axes [m]."""

    hand_offset_m: tuple[float, float, float] = (0.0, 0.0025, -0.0015)
    head_offset_m: tuple[float, float, float] = (0.0, -0.027, 0.010)
    # How far outwards the palm's centre is from that of the hand's skin, as fingers point inwards,
    # fitted [m].
    outward_m: float = 0.0125
    # Share of the height by which the hair's top is above the average that the centre of the head's
    # skin is lower, fitted [1].
    crown_share: float = 0.65
    # Share of the breadth beyond the average that it is higher, fitted [1].
    breadth_share: float = 0.98
    # Shares that the width of hair beside the face and the height of the skin, beyond the average,
    # have in the depth of the head's centre behind its skin, fitted [1].
    beside_share: float = 0.32
    height_share: float = 0.19
    # How much the offsets differ, per axis [m].
    hand_offset_sd_m: NotNegative = 0.010
    head_offset_sd_m: NotNegative = 0.006
    # The same of halves of two merged hands besides, fitted.
    halves_sd_m: NotNegative = 0.025

    def __post_init__(self) -> None:
        check_bounds(OWNER, self)


@dataclass(frozen=True)
class IdentityParameters:
    """The doubt of right and left."""

    # Added to the log-odds of the exchanged hypotheses' weight: fitted, so that of the frames with
    # a stated probability of 20 % about 20 % are exchanged.
    exchange_log_odds: float = -0.4
    # Probability that two fast hands in one blob are named wrongly, whatever the hypotheses say:
    # fitted, 0 = no such doubt.
    halves_doubt: NotNegative = 0.1
    # Time in which, both hands hidden, it comes to within 1/e of 1/2 [s], 0 = no such doubt.
    hidden_memory_s: NotNegative = 2.0
    # Speed at which hidden hands are taken to change places [m/s].
    hidden_speed_mps: NotNegative = 0.5

    def __post_init__(self) -> None:
        check_bounds(OWNER, self)


@dataclass(frozen=True)
class HypothesisParameters:
    """All parameters of the hypothesis tracker."""

    candidates: CandidateParameters = field(default_factory=CandidateParameters)
    motion: MotionParameters = field(default_factory=MotionParameters)
    noise: NoiseParameters = field(default_factory=NoiseParameters)
    costs: CostParameters = field(default_factory=CostParameters)
    sleeve: SleeveParameters = field(default_factory=SleeveParameters)
    offsets: OffsetParameters = field(default_factory=OffsetParameters)
    identity: IdentityParameters = field(default_factory=IdentityParameters)
    # Before head and both hands are seen apart, the head and a lone hand are told already.
    early: bool = True
    # Hypotheses kept.
    hypotheses: AboveZeroInt = 5
    # The estimate is the mean of the hypotheses within this of the best [log-odds].
    mean_within: NotNegative = 0.7
    # With a lag: how much the costs of later frames count for an earlier one [1]. They are no
    # independent evidence, and hands that roll round each other move by less than they seem to.
    later_share: NotNegative = 0.1
    # A target that is unseen for this time is lost [s].
    lost_after_s: AboveZero = 1.0

    def __post_init__(self) -> None:
        check_bounds(OWNER, self)
