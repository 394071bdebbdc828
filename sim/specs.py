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


@dataclass(frozen=True)
class ObjectSpec:
    """A thing on the table: kind is one of sim.room.KINDS; (x, y) of its base's centre."""

    name: str
    kind: str
    size_m: tuple[float, float, float]  # extent along x, y, z
    rgb: RGB
    position_xy_m: tuple[float, float]
    yaw_rad: float = 0.0


@dataclass(frozen=True)
class RoomSpec:
    """Table, chair, walls, light. World: origin on the floor under the mid-shoulder point."""

    table_height_m: float = 0.73
    table_near_x_m: float = 0.16  # edge on the person's side
    table_depth_m: float = 0.75
    table_width_m: float = 1.5
    table_rgb: RGB = (0.47, 0.50, 0.53)
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
    """What a real camera does to a picture."""

    noise_sd: float = 3.0  # grey levels


@dataclass(frozen=True)
class SceneSpec:
    """Everything that stands still in a sequence."""

    anatomy: Anatomy = field(default_factory=Anatomy.of)
    appearance: Appearance = field(default_factory=Appearance)
    room: RoomSpec = field(default_factory=RoomSpec)
    rig: RigSpec = field(default_factory=RigSpec)
    sensor: SensorSpec = field(default_factory=SensorSpec)
