"""The pictures of README.md and of some pages of docs/, made anew from what the commands write.

python examples/readme_pictures.py                # all of them, some minutes; needs chromium
python examples/readme_pictures.py labels map     # some of them, by the names of `MADE`
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from playwright.sync_api import Page, sync_playwright

import sim.dataset
from pjpdaf.arrays import Image
from reports.dataset import label_colours
from reports.pictures.encode import picture_of, webp_of
from reports.pictures.overlay import draw_text
from reports.pictures.resize import resized
from reports.pictures.truth_overlay import draw_outlines
from scenarios.catalogue.frame_choice import hardest_frame, truths_without_pictures
from scenarios.spec.draw import perform
from scenarios.spec.loader import load_scenario_file
from scenarios.spec.names import load_scenario
from sim.sequence import Simulation
from sim.silhouettes.film import film_of
from sim.silhouettes.painter import Painter
from sim.silhouettes.shapes import BARE, CLOTHED, PAINTS, TARGET_PAINT

PICTURES = Path(__file__).parents[1] / "docs/pictures"
HERO_FRAME, LABEL_FRAME = 18, 12
MOTION = Path(__file__).parent / "motion/tidy_up.yaml"
MOTION_TIMES_S = (1.0, 3.5, 4.75, 5.5, 6.5, 7.5, 9.75, 11.75)
PAINTED = ("drink", "merge_and_hold")
GATE_SCENARIOS = ("cross", "clap", "fast_finish", "hand_under_table")
TILE_PX, GAP_PX, STRIP_PX = 320, 6, 30
FINE = 4  # bits of a pixel's fraction, for OpenCV


def bench(*words: str) -> None:
    done = subprocess.run([sys.executable, "-m", "scenarios", *words], check=False)
    if done.returncode not in (0, 3):
        sys.exit(done.returncode)


def hero(work: Path) -> None:
    """A frame of `run drink`, as the run keeps it: detections, estimates, truth."""
    bench("run", "drink", "--jobs", "1", "--out", str(work))
    (picture,) = work.glob(f"pictures/*drink*/{HERO_FRAME:05d}.jpg")
    shutil.copy(picture, PICTURES / "drink.jpg")


def labels(work: Path) -> None:
    """Labels of a frame of `dataset make cross`, cut out about the person: four tiles in a row."""
    bench("dataset", "make", "cross", "--seeds", "1", "--export", "coco", "--out", str(work))
    (sequence,) = sim.dataset.open(work).sequences
    coco = json.loads((work / "annotations/instances_left.json").read_text(encoding="utf-8"))
    frame = sequence.frame(LABEL_FRAME).pictures[0]
    seg, amodal = sequence.seg(0, LABEL_FRAME), sequence.amodal(0, LABEL_FRAME)
    of_frame = {i["id"] for i in coco["images"] if i["file_name"].endswith(_name(LABEL_FRAME))}
    found = [a for a in coco["annotations"] if a["image_id"] in of_frame]
    person = next(a["bbox"] for a in found if _kind(coco, a)["name"] == "person")
    part = _square_about(person, frame.shape[:2])
    scale = 2 * TILE_PX / (part[1].stop - part[1].start)
    skin = np.where((seg >= 1) & (seg <= 3), seg, 0).astype(np.int8) - 1
    drawn = _enlarged(frame[part], 2)
    outlines = cv2.resize(skin[part], (2 * TILE_PX,) * 2, interpolation=cv2.INTER_NEAREST)
    draw_outlines(drawn, outlines, thickness_px=2)
    for one in found:
        _draw_annotation(drawn, one, _kind(coco, one), part, scale)
    tiles = {
        "visible masks, boxes, keypoints": drawn,
        "instance ids": _enlarged(label_colours.seg_picture(seg)[part], 2, exact=True),
        "amodal masks": _enlarged(label_colours.amodal_picture(frame, amodal, seg)[part], 2),
        "depth": _enlarged(label_colours.depth_picture(sequence.depth_m(0, LABEL_FRAME))[part], 2),
    }
    gap = np.full((2 * TILE_PX, GAP_PX, 3), 255, np.uint8)
    row = np.hstack([p for tile in tiles.values() for p in (_titled(tile, tiles), gap)][:-1])
    _write("labels.webp", row, 82)


def _titled(tile: Image, tiles: dict[str, Image]) -> Image:
    (name,) = (name for name, other in tiles.items() if other is tile)
    tile[-STRIP_PX - 6 :] = (tile[-STRIP_PX - 6 :] * 0.25).astype(np.uint8)
    draw_text(tile, name, (12, 2 * TILE_PX - 12), (255, 255, 255), 0.75)
    return tile


def _name(frame: int) -> str:
    return f"{frame + 1:06d}.png"


def _kind(coco: dict[str, Any], annotation: dict[str, Any]) -> dict[str, Any]:
    (kind,) = (c for c in coco["categories"] if c["id"] == annotation["category_id"])
    return dict(kind)


def _square_about(box: list[float], shape: tuple[int, ...]) -> tuple[slice, slice]:
    """Rows and columns of the smallest square about a box (x, y, w, h), and 12 pixels more."""
    x, y, w, h = box
    side = round(min(max(w, h) + 24, *shape))
    top = int(np.clip(y + h / 2 - side / 2, 0, shape[0] - side))
    left = int(np.clip(x + w / 2 - side / 2, 0, shape[1] - side))
    return slice(top, top + side), slice(left, left + side)


def _enlarged(picture: Image, times: int, exact: bool = False) -> Image:
    how = cv2.INTER_NEAREST if exact else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(picture, (times * TILE_PX,) * 2, interpolation=how), np.uint8)


def _draw_annotation(
    canvas: Image,
    annotation: dict[str, Any],
    kind: dict[str, Any],
    part: tuple[slice, slice],
    scale: float,
) -> None:
    """Box of head or hand, and every labelled keypoint with its bones, as COCO has them."""
    names = ("head", "right_hand", "left_hand")
    if kind["name"] not in (*names, "person"):
        return
    start = np.array([part[1].start, part[0].start]) - 0.5
    points = np.array(annotation["keypoints"]).reshape(-1, 3)
    at = ((points[:, :2] - start) * scale * 2**FINE).astype(int)
    if kind["name"] == "person":
        colour, bones = (255, 255, 255), kind["skeleton"]
    else:
        colour = label_colours.TARGET_COLOURS[names.index(kind["name"])]
        bones = kind["skeleton"] if kind["name"] != "head" else []
        x, y, w, h = annotation["bbox"]
        corners = ((np.array([[x, y], [x + w, y + h]]) - start) * scale).astype(int).tolist()
        cv2.rectangle(canvas, corners[0], corners[1], colour, 1, cv2.LINE_AA)
    for a, b in bones:
        if points[a - 1, 2] and points[b - 1, 2]:
            ends = (at[a - 1].tolist(), at[b - 1].tolist())
            cv2.line(canvas, *ends, (30, 24, 20), 3, cv2.LINE_AA, FINE)
            cv2.line(canvas, *ends, colour, 1, cv2.LINE_AA, FINE)
    for point, place in zip(points, at.tolist(), strict=True):
        if point[2]:
            filled = -1 if point[2] == 2 else 1
            cv2.circle(canvas, place, 4 << FINE, (30, 24, 20), -1, cv2.LINE_AA, FINE)
            cv2.circle(canvas, place, 3 << FINE, colour, filled, cv2.LINE_AA, FINE)


def gate(work: Path) -> None:
    """The first screen of a page that judges the thesis's tracker by today's default."""
    for preset in ("default", "thesis"):
        chosen = ("--seeds", "3", "--set", "frames=30", "--preset", preset)
        bench("run", *GATE_SCENARIOS, *chosen, "--jobs", "1", "--out", str(work / preset))
    page = work / "report.html"
    words = ("report", str(work / "thesis"), "--baseline", str(work / "default"))
    bench(*words, "--out", str(page))
    with opened(page, 1240, 640) as view:
        view.wait_for_selector("html[data-thumbs=yes]")
        view.add_style_tag(content=".topbar { display: none; }")
        view.wait_for_timeout(1500)  # the film's first picture
        foot = view.locator(".tiles").first.bounding_box()
        assert foot is not None
        clip = {"x": 0, "y": 0, "width": 1240, "height": foot["y"] + foot["height"] + 8}
        _write("gate.webp", _decoded(view.screenshot(clip=clip)), 84)


def map_(work: Path) -> None:
    """The failure map of `stress cross map` with the thesis's tracker."""
    words = "stress cross map --preset thesis --x speed --y depth_gap --cells 5 --seeds 6"
    bench(*words.split(), "--refine", "0", "--jobs", "1", "--out", str(work))
    with opened(work / "stress.html", 1240, 900) as view:
        view.add_style_tag(content="a rect { outline: none; }")
        shot = view.locator("#maps figure svg").first.screenshot()
        _write("stress_map.webp", _decoded(shot), 84)


def strip(work: Path) -> None:
    """The first failure that `stress cross search` finds of the thesis's tracker, rendered."""
    words = "stress cross search --preset thesis --budget 40 --confirm 1 --distinct 2"
    bench(*words.split(), "--jobs", "1", "--out", str(work))
    with opened(work / "stress.html", 1140, 900) as view:
        shot = view.locator(".strip").first.screenshot()
        _write("stress_strip.webp", _decoded(shot), 84)


def motion(_: Path) -> None:
    """The left view at some moments of examples/motion/tidy_up.yaml, with the time."""
    performance = perform(load_scenario_file(MOTION), 1)
    tiles = []
    with Simulation(performance) as simulation:
        for time_s in MOTION_TIMES_S:
            tile = resized(simulation.render(round(time_s * performance.fps)).light[0], TILE_PX)
            draw_text(tile, f"{time_s:.1f} s", (8, 22), (255, 255, 255), 0.6)
            tiles.append(tile)
    rows = [np.hstack(tiles[at : at + 4]) for at in range(0, len(tiles), 4)]
    _write("own_motion.webp", np.vstack(rows), 84)


def painted(_: Path) -> None:
    """The left view of two frames, rendered, and as fast paints their silhouettes."""
    colours = np.full((PAINTS, 3), 40, np.uint8)
    colours[[CLOTHED, BARE]] = (150, 95, 55), (120, 150, 190)
    colours[TARGET_PAINT:] = label_colours.TARGET_COLOURS
    tiles = []
    for name in PAINTED:
        performance = perform(load_scenario(name), 0)
        truths = list(truths_without_pictures(performance, range(performance.frames)))
        frame = hardest_frame(truths).index
        with Simulation(performance) as simulation:
            rendered = simulation.render(frame).light[0]
        classes = Painter(film_of(performance, 2, everything=True)).paint(frame)[0].classes
        silhouettes = cv2.resize(
            colours[classes], rendered.shape[1::-1], interpolation=cv2.INTER_NEAREST
        )
        tiles += [resized(picture[:, 100:540], 280) for picture in (rendered, silhouettes)]
    _write("fast_painted.webp", np.hstack(tiles), 84)


@contextmanager
def opened(page: Path, width: int, height: int) -> Iterator[Page]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        view = browser.new_page(
            viewport={"width": width, "height": height},
            device_scale_factor=1.5,
            reduced_motion="reduce",
            color_scheme="light",
        )
        view.goto(page.as_uri())
        yield view
        browser.close()


def _decoded(png: bytes) -> Image:
    picture = picture_of(png)
    assert picture is not None
    return picture


def _write(name: str, picture: Image, quality: int) -> None:
    data = webp_of(picture, quality)
    (PICTURES / name).write_bytes(data)
    height, width = picture.shape[:2]
    print(f"{PICTURES / name}: {width} x {height} pixels, {len(data) // 1000} kB")


MADE: dict[str, Callable[[Path], None]] = {
    "hero": hero,
    "labels": labels,
    "gate": gate,
    "map": map_,
    "strip": strip,
    "motion": motion,
    "painted": painted,
}


def main() -> None:
    for name in sys.argv[1:] or MADE:
        with tempfile.TemporaryDirectory() as folder:
            MADE[name](Path(folder).resolve() / name)


if __name__ == "__main__":
    main()
