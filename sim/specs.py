"""What a simulated sequence is made of: plain frozen records, everything in SI units."""

from __future__ import annotations

from dataclasses import dataclass, field

from sim.anatomy import Anatomy

RGB = tuple[float, float, float]  # linear 0-1, as MuJoCo's rgba


@dataclass(frozen=True)
class Appearance:
    """How the person looks."""

    skin_rgb: RGB = (0.84, 0.58, 0.45)
    hair_rgb: RGB = (0.16, 0.10, 0.07)
    shirt_rgb: RGB = (0.15, 0.22, 0.52)
    short_sleeves: bool = False  # bare forearms: skin that belongs to no target
    beard: bool = False
    glasses: bool = False
    hair: str = "short"  # one of sim.head.HAIR
    shirt_pattern: str = "plain"  # one of sim.textures.PATTERNS


@dataclass(frozen=True)
class ObjectSpec:
    """A thing: kind is one of sim.objects.KINDS; (x, y) of its base's centre, z up.

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
class RoomSpec:
    """Table, chair, walls, light. World: origin on the floor under the mid-shoulder point."""

    table_height_m: float = 0.73
    table_near_x_m: float = 0.16  # edge on the person's side
    table_depth_m: float = 0.75
    table_width_m: float = 1.5
    table_rgb: RGB = (0.47, 0.50, 0.53)
    table_surface: str = "wood"  # one of sim.textures.SURFACES
    wall_rgb: RGB = (0.62, 0.63, 0.60)
    light_gain: float = 1.0
    light_rgb: RGB = (1.0, 1.0, 1.0)  # colour of all lights
    texture_seed: int = 0
    objects: tuple[ObjectSpec, ...] = ()


@dataclass(frozen=True)
class RigSpec:
    """Two cameras on one head, looking at the person (thesis: wide-field cameras, 640 x 480)."""

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


@dataclass(frozen=True)
class SensorSpec:
    """What a real camera does to a picture, in the order in which it does it.

    Light is linear until the picture is encoded; `sim.sensor` has the formulas.
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
    jpeg_quality: int = 100  # 100 = not compressed


@dataclass(frozen=True)
class ClockSpec:
    """When pictures are taken, and which arrive."""

    jitter_s: float = 0.0  # a picture is taken up to this much before or after its time
    stamps: str = "true"  # frames carry the time at which they were taken; or "nominal"
    dropped: float = 0.0  # chance that a view's picture does not arrive


@dataclass(frozen=True)
class CalibrationError:
    """How the calibration that a tracker is given differs from the rig that films.

    The left camera keeps its place. baseline: share by which the distance is overstated; focal:
    likewise of both focal lengths; rotation_rad: of the right camera about its own x, y, z.
    """

    baseline: float = 0.0
    focal: float = 0.0
    rotation_rad: tuple[float, float, float] = (0.0, 0.0, 0.0)


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
