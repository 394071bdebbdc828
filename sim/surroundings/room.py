"""A room of drawn surroundings: all that stands still in it but the objects."""

from __future__ import annotations

import numpy as np

from pjpdaf.arrays import Floats
from sim.specs import RoomSpec, Surroundings
from sim.surfaces.assets import Assets, check_word
from sim.surroundings import words
from sim.surroundings.furniture import add_bookcase, add_boxes, add_cupboard, add_standing_lamp
from sim.surroundings.layout import in_a_row
from sim.surroundings.lights import add_lights
from sim.surroundings.on_walls import (
    POSTER_M,
    add_board,
    add_picture,
    add_poster,
    add_screen,
)
from sim.surroundings.openings import DOOR_M, add_door, add_window
from sim.surroundings.plants import add_plant
from sim.surroundings.seat_and_table import add_chair, add_table
from sim.surroundings.shell import HEIGHT_M, Wall, add_shell

_POSTER_SKIN = ((0.84, 0.58, 0.45), (0.62, 0.42, 0.31), (0.42, 0.27, 0.20))
_BREADTHS = {"board": 0.95, "bookcase": 0.95, "cupboard": 1.05}


def add_surroundings(assets: Assets, room: RoomSpec, around: Surroundings, aim_m: Floats) -> None:
    """Add walls, openings, furniture, the person's table and chair, and the lights.

    Raises ValueError for a word that is not known.
    """
    for name, known in (
        ("wall", words.WALLS),
        ("floor", words.FLOORS),
        ("door", words.DOORS),
        ("window", words.WINDOWS),
        ("shelves", words.SHELVES),
        ("screen", words.SCREENS),
        ("chair", words.CHAIRS),
        ("table_shape", words.TABLE_SHAPES),
        ("table_legs", words.TABLE_LEGS),
        ("lamp", words.LAMPS),
    ):
        check_word(f"Surroundings.{name}", getattr(around, name), known)
    back, right, left = add_shell(assets, room, around)
    _furnish(assets, around, (back, right, left))
    add_table(assets, room, around)
    add_chair(assets, around.chair)
    add_lights(assets, room, around, aim_m)


def _furnish(assets: Assets, around: Surroundings, walls: tuple[Wall, Wall, Wall]) -> None:
    """Hand out all things to the walls, the back wall first, each with its place in a row."""
    rng = assets.rng("furnish")
    # Per wall the things wanted: name -> breadth [m], the most important first.
    rows: dict[str, dict[str, float]] = {wall.name: {} for wall in walls}
    names = [wall.name for wall in walls]

    def wish(thing: str, breadth_m: float, at_back: float) -> None:
        on_back = rng.random() < at_back
        name = "back" if on_back else names[1 + int(rng.integers(2))]
        rows[name][thing] = breadth_m

    if around.window != "none":
        wish("window", float(rng.uniform(0.9, 1.5)) + 0.35, 0.55)
    if around.door != "none":
        wish("door", DOOR_M, 0.6)
    if around.shelves != "none":
        wish("shelves", _BREADTHS[around.shelves], 0.75)
    if around.screen == "wall":
        wish("screen", 1.25, 0.8)
    if around.poster:
        wish("poster", POSTER_M[0] + 0.06, 0.85)
    for number in range(around.pictures):
        wish(f"picture:{number}", float(rng.uniform(0.24, 0.62)) + 0.08, 0.7)
    if around.lamp == "standing":
        wish("lamp", 0.45, 0.7)
    for number in range(around.plants):
        wish(f"plant:{number}", 0.5, 0.7)
    for number in range(around.floor_clutter):
        wish(f"floor:{number}", 0.45, 0.7)
    for wall in walls:
        wanted = rows[wall.name]
        ends = wall.ends_m[0] + 0.08, wall.ends_m[1] - 0.08
        places = in_a_row(rng, ends, list(wanted.values()))
        for (thing, breadth), place in zip(wanted.items(), places, strict=True):
            if place is not None:
                _add(assets, around, wall, thing, place, breadth, rng)
    if around.lamp == "ceiling":
        _ceiling_lamp(assets)


def _add(
    assets: Assets,
    around: Surroundings,
    wall: Wall,
    thing: str,
    y: float,
    breadth_m: float,
    rng: np.random.Generator,
) -> None:
    kind, _, number = thing.partition(":")
    if kind == "window":
        add_window(assets, wall, y, breadth_m - 0.35, around.window)
    elif kind == "door":
        add_door(assets, wall, y, around.door)
    elif kind == "shelves" and around.shelves == "bookcase":
        add_bookcase(assets, wall, y, breadth_m)
    elif kind == "shelves" and around.shelves == "cupboard":
        add_cupboard(assets, wall, y, breadth_m - 0.05)
        add_picture(assets, wall, 90, y, float(rng.uniform(1.45, 1.65)), 0.5)
    elif kind == "shelves":
        add_board(assets, wall, y, breadth_m, float(rng.uniform(1.05, 1.5)))
    elif kind == "screen":
        add_screen(assets, wall, y)
    elif kind == "poster":
        add_poster(assets, wall, y, _POSTER_SKIN[int(rng.integers(len(_POSTER_SKIN)))])
    elif kind == "picture":
        z = float(rng.uniform(1.25, 1.70))
        add_picture(assets, wall, int(number), y, z, breadth_m - 0.08)
    elif kind == "lamp":
        add_standing_lamp(assets, wall, y)
    elif kind == "plant":
        at = (float(rng.uniform(0.28, 0.38)), y, 0.0)
        add_plant(
            assets,
            wall.body,
            f"plant:{wall.name}:{number}",
            at,
            float(rng.uniform(0.7, 1.35)),
            False,
        )
    else:
        add_boxes(assets, wall, int(number), y)


def _ceiling_lamp(assets: Assets) -> None:
    assets.plain("ceiling_lamp", (0.92, 0.90, 0.84), emission=0.7)
    at = (-0.5, 0.0, HEIGHT_M - 0.05)
    assets.ellipsoid(assets.spec.worldbody, "ceiling_lamp", at, (0.22, 0.22, 0.06), "ceiling_lamp")
