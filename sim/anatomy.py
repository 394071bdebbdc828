"""The dimensions of a person, from stature and proportions."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Anatomy:
    """Lengths of a seated adult [m]; `of` derives them from the stature H.

    Segment ratios: Drillis and Contini as in Winter's Biomechanics (upper arm .162 H here measured
    shoulder to elbow along the rendered arm, forearm .1545 H, wrist to palm centre .045 H).
    """

    stature_m: float
    upper_arm_m: float
    forearm_m: float
    wrist_to_palm_m: float
    hand_length_m: float
    hand_breadth_m: float
    head_breadth_m: float
    head_depth_m: float
    head_height_m: float
    shoulder_half_breadth_m: float
    mid_shoulder_height_m: float  # above the floor, seated upright
    neck_to_head_centre_m: float  # mid-shoulder point to head centre, upright
    shoulder_drop_m: float  # shoulder joints below the mid-shoulder point

    @staticmethod
    def of(
        stature_m: float = 1.72,
        arm_scale: float = 1.0,
        hand_scale: float = 1.0,
        head_scale: float = 1.0,
        shoulder_scale: float = 1.0,
    ) -> Anatomy:
        """Anatomy of a person of this stature; the scales vary its proportions (1 = average)."""
        H = stature_m
        return Anatomy(
            stature_m=H,
            upper_arm_m=0.162 * H * arm_scale,
            forearm_m=0.1545 * H * arm_scale,
            wrist_to_palm_m=0.045 * H * hand_scale,
            hand_length_m=0.109 * H * hand_scale,
            hand_breadth_m=0.0495 * H * hand_scale,
            head_breadth_m=0.0885 * H * head_scale,
            head_depth_m=0.115 * H * head_scale,
            head_height_m=0.131 * H * head_scale,
            shoulder_half_breadth_m=0.108 * H * shoulder_scale,
            # Sitting acromion height .345 H above a seat at .245 H.
            mid_shoulder_height_m=0.590 * H,
            neck_to_head_centre_m=0.125 * H,
            shoulder_drop_m=0.012 * H,
        )
