"""Specifications of a simulated sequence: plain frozen records, everything in SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from sim.anatomy import Anatomy

RGB = tuple[float, float, float]  # linear 0-1, as MuJoCo's rgba

STAMPS = ("actual", "nominal")  # times that frames carry


@dataclass(frozen=True)
class Appearance:
    """The appearance of the person."""

    skin_rgb: RGB = (0.84, 0.58, 0.45)
    hair_rgb: RGB = (0.16, 0.10, 0.07)
    shirt_rgb: RGB = (0.15, 0.22, 0.52)
    sleeves: str = "long"  # one of sim.person.sleeves.SLEEVES
    beard: bool = False
    glasses: bool = False
    hair: str = "short"  # one of sim.person.hair.HAIR
    shirt_pattern: str = "plain"  # one of sim.surfaces.textures.PATTERNS
    expression: str = "neutral"  # one of sim.person.face.EXPRESSIONS


@dataclass(frozen=True)
class ObjectSpec:
    """An object: kind is one of sim.scene.objects.KINDS; (x, y) of its base's centre, z up.

    base_m: height of its base above the floor, None = it stands on the table.
    """

    name: str
    kind: str
    size_m: tuple[float, float, float]  # extent along x, y, z
    rgb: RGB
    position_xy_m: tuple[float, float]
    yaw_rad: float = 0.0
    base_m: float | None = None


@dataclass(frozen=True)
class Surroundings:
    """All of a room about table and person that is drawn from the seed (`sim.surroundings`).

    arrangement: seed of places, sizes, patterns and colours that no field names. The walls stand
    depth_m behind the mid-shoulder point and half_width_m beside it. Words are those of
    `sim.surroundings.words`; pictures, plants, clutter, floor_clutter are numbers of things.
    light_elevation_rad: of the key light above the horizon; light_softness 0-1: of its shadows'
    edges; light_contrast 0-1: from even light to light of one side; shadow_lights: 1 or 2.
    """

    arrangement: int
    depth_m: float
    half_width_m: float
    wall: str
    floor: str
    floor_rgb: RGB
    door: str
    window: str
    shelves: str
    pictures: int
    poster: bool
    plants: int
    screen: str
    chair: str
    table_shape: str
    table_legs: str
    clutter: int
    floor_clutter: int
    bystander: str
    light_elevation_rad: float
    light_softness: float
    light_contrast: float
    lamp: str
    shadow_lights: int = 1


@dataclass(frozen=True)
class RoomSpec:
    """Table, chair, walls, light. World: origin on the floor under the mid-shoulder point."""

    table_height_m: float = 0.73
    table_near_x_m: float = 0.16  # edge on the person's side
    table_depth_m: float = 0.75
    table_width_m: float = 1.5
    table_rgb: RGB = (0.47, 0.50, 0.53)
    table_surface: str = "wood"  # one of sim.surfaces.textures.SURFACES
    wall_rgb: RGB = (0.62, 0.63, 0.60)
    light_gain: float = 1.0
    light_rgb: RGB = (1.0, 1.0, 1.0)  # colour of all lights
    light_azimuth_rad: float = 0.0  # the key light, turned about the vertical
    texture_seed: int = 0
    objects: tuple[ObjectSpec, ...] = ()
    surroundings: Surroundings | None = None  # None: the nominal room


@dataclass(frozen=True)
class RigSpec:
    """Two cameras on a common head that face the person (thesis: wide-field cameras, 640 x 480).

    distortion: OpenCV's coefficients k1, k2, p1, p2, ... of both lenses, empty for none. Raises
    ValueError for numbers that no rig has.
    """

    focal_px: float = 540.0
    baseline_m: float = 0.09
    height_m: float = 1.35
    distance_m: float = 1.30  # along x from the mid-shoulder point to the mid-point of the cameras
    tilt_rad: float = 0.29  # downwards
    vergence_rad: float = 0.0  # total angle between the optical axes
    width_px: int = 640
    height_px: int = 480
    principal_offset_px: tuple[float, float] = (0.0, 0.0)  # from the picture's centre, both views
    distortion: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for name in ("focal_px", "baseline_m", "width_px", "height_px"):
            _within(self, name, least=0.0, open_end=True)
        for name in ("height_m", "distance_m", "tilt_rad", "vergence_rad"):
            _within(self, name)
        _within(self, "principal_offset_px")
        _within(self, "distortion")


@dataclass(frozen=True)
class SensorSpec:
    """Effects of a real camera on a picture, in the order in which they arise.

    Light is linear until the picture is encoded; `sim.camera.sensor` has the formulas. Raises
    ValueError for numbers that no camera has.
    """

    exposure_time_s: float = 0.0  # 0 = no blur; the picture is the mean over this time
    skew_s: float = 0.0  # the right view is exposed this much later than the left
    exposure_ev: float = 0.0  # gain of the light, powers of two
    white_balance_rgb: RGB = (1.0, 1.0, 1.0)  # gains of the light's red, green, blue
    flicker: float = 0.0  # share by which the light swings
    flicker_hz: float = 100.0
    flicker_rad: float = 0.0  # its phase at t = 0
    noise_sd: float = 3.0  # read noise, grey levels
    shot_noise_sd: float = 0.0  # shot noise at grey level 128, grey levels
    jpeg_quality: int = 100  # 1 to 99; 100 = not compressed

    def __post_init__(self) -> None:
        for name in ("exposure_time_s", "skew_s", "flicker_hz", "noise_sd", "shot_noise_sd"):
            _within(self, name, least=0.0)
        _within(self, "white_balance_rgb", least=0.0)
        _within(self, "flicker", least=0.0, most=1.0)
        _within(self, "jpeg_quality", least=1, most=100)
        for name in ("exposure_ev", "flicker_rad"):
            _within(self, name)


@dataclass(frozen=True)
class ClockSpec:
    """When pictures are taken, and which arrive. Raises ValueError for impossible numbers."""

    jitter_s: float = 0.0  # pictures are taken up to this much before or after their time
    stamps: str = "actual"  # frames carry when they were taken; "nominal": when they should be
    dropped: float = 0.0  # chance that a view's picture does not arrive

    def __post_init__(self) -> None:
        _within(self, "jitter_s", least=0.0)
        _within(self, "dropped", least=0.0, most=1.0)
        if self.stamps not in STAMPS:
            known = " or ".join(STAMPS)
            raise ValueError(f"ClockSpec.stamps must be {known}, got {self.stamps!r}")


@dataclass(frozen=True)
class CalibrationError:
    """How the calibration that a tracker is given differs from the rig that films.

    The left camera keeps its place. baseline: share by which the distance is overstated; focal:
    likewise of both focal lengths; rotation_rad: of the right camera about its own x, y, z, as one
    rotation vector. Raises ValueError for numbers that leave no rig.
    """

    baseline: float = 0.0
    focal: float = 0.0
    rotation_rad: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name in ("baseline", "focal"):
            _within(self, name, least=-1.0, open_end=True)
        _within(self, "rotation_rad")


@dataclass(frozen=True)
class SceneSpec:
    """Everything that stands still in a sequence."""

    anatomy: Anatomy = field(default_factory=Anatomy.of)
    appearance: Appearance = field(default_factory=Appearance)
    room: RoomSpec = field(default_factory=RoomSpec)
    rig: RigSpec = field(default_factory=RigSpec)
    sensor: SensorSpec = field(default_factory=SensorSpec)
    clock: ClockSpec = field(default_factory=ClockSpec)
    calibration_error: CalibrationError = field(default_factory=CalibrationError)


def _within(
    record: object,
    name: str,
    least: float = -math.inf,
    most: float = math.inf,
    open_end: bool = False,
) -> None:
    """Raise ValueError where a field, or one of its values, is not finite or out of bounds."""
    value = getattr(record, name)
    for number in value if isinstance(value, tuple) else (value,):
        if math.isfinite(number) and least <= number <= most and not (open_end and number == least):
            continue
        if number < least == 0 and most == math.inf:
            rule = "must not be negative"
        elif not math.isfinite(number):
            rule = "must be finite"
        elif open_end:
            rule = f"must be above {least:g}"
        else:
            rule = f"must be from {least:g} to {most:g}"
        raise ValueError(f"{type(record).__name__}.{name} {rule}, got {value}")
