"""Surroundings without a thing in them, for tests to put some in."""

from sim.specs import Surroundings

PLAIN = Surroundings(
    arrangement=1,
    depth_m=1.6,
    half_width_m=2.0,
    wall="paint",
    floor="planks",
    floor_rgb=(0.5, 0.4, 0.3),
    door="none",
    window="none",
    shelves="none",
    pictures=0,
    poster=False,
    plants=0,
    screen="none",
    chair="slats",
    table_shape="straight",
    table_legs="four",
    clutter=0,
    floor_clutter=0,
    bystander="none",
    light_elevation_rad=0.7,
    light_softness=0.8,
    light_contrast=0.5,
    lamp="none",
)
