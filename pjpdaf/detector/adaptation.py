"""Parts of the blob detector that adapt to room, light and person, each on or off."""

from __future__ import annotations

from dataclasses import dataclass, field

from pjpdaf.detector.background import BackgroundParameters
from pjpdaf.detector.parameters import DetectorParameters


@dataclass(frozen=True)
class AdaptationParameters:
    """The blob detector's adaptions; the thesis's detector has none."""

    # Noisy pictures are smoothed.
    smooth_noise: bool = True
    # Log chroma is tested against the background, beside hue, saturation and value.
    test_chroma: bool = True
    # The picture is balanced to the face's colour where the skin range does not hold it.
    balance_light: bool = True
    # The face is looked for where the head is expected, not at the top of another silhouette.
    expect_face: bool = True
    # The face is looked for above the shoulders alone, not in the shirt below it.
    to_shoulders: bool = True
    # Clothes of a colour near skin are told from skin.
    split_clothes: bool = True
    # Clothes whose colour is far from the face's are told from skin where they are small too.
    clear_clothes: bool = True
    # What is only uncovered, where something of the background is gone, is no skin.
    drop_ghosts: bool = True
    # A rotation of the cameras that the calibration missed is taken out.
    align_views: bool = True


@dataclass(frozen=True)
class BlobDetectorParameters(DetectorParameters):
    """Parameters of the blob detector: the thesis's, and which adaptions are on."""

    # Beside a strong lamp a shadow keeps less than half of the light.
    background: BackgroundParameters = field(
        default_factory=lambda: BackgroundParameters(shadow_min=0.3)
    )
    adaptation: AdaptationParameters = field(default_factory=AdaptationParameters)
