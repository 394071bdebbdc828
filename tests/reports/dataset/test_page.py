"""The page of a data set: its own numbers, in its room, escaped, and worked in a real browser."""

import base64
import gzip
import json
import re
from dataclasses import replace

import cv2
import numpy as np
import pytest
from waiting import until

from pjpdaf.targets import TARGETS
from reports.dataset import label_colours
from reports.dataset.event_rows import event_rows
from reports.dataset.page import dataset_page
from reports.dataset.rerun import write_dataset_rerun
from reports.dataset.sequence_data import sequence_data
from reports.dataset.sequence_view import LAYERS, VIEW_PX, sequence_views
from reports.dataset.sheet import GAP_PX, TILE_PX, dataset_sheet
from reports.page.templating import write_text
from scenarios.play.recipe import sized
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.dataset.files.layout import sequence_name
from sim.dataset.files.manifest import SequenceEntry, manifest_record, write_manifest
from sim.dataset.labels.records import KEYPOINTS
from sim.dataset.reader import open_dataset
from sim.dataset.statistics import statistics_of
from sim.dataset.writer import write_sequence
from sim.scene.world import CAMERAS
from sim.sequence import Simulation

LEFT = "document.querySelector('[data-part=left]')"
HOSTILE = "</script><b>x{{ 7*7 }}"
SIZE_PX = (160, 120)
LABELS = ("clean", "depth", "seg", "amodal", "disparity")
READY = "html[data-ready=yes]"


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """Hands that cross within twelve frames; a lens and lost pictures, without seg and amodal."""
    folder = tmp_path_factory.mktemp("page") / "set"
    folder.mkdir()
    lens = {"frames": 5, "lens_k1": -0.2, "lens_k2": 0.05, "dropped": 10}
    made = (("cross", 101, {"frames": 20}, LABELS), ("calm_table", 102, lens, ("depth",)))
    entries = []
    for index, (name, seed, overrides, labels) in enumerate(made):
        scenario, target = load_scenario(name), folder / sequence_name(index)
        target.mkdir()
        changes = {"background_frames": 1, **overrides}
        with Simulation(sized(perform(scenario, seed, changes), SIZE_PX)) as simulation:
            write_sequence(simulation, target, labels, {"values": {"skin_ita": 30.0}})
        entries.append(
            SequenceEntry(
                target.name,
                HOSTILE if index else name,
                HOSTILE if index else name,
                scenario.group,
                seed,
                "",
                str(seed),
                overrides["frames"],
                3.0,
            )
        )
    settings = {"labels": list(LABELS), "size_px": list(SIZE_PX)}
    write_manifest(folder, manifest_record(entries, settings, {}, complete=True))
    return open_dataset(folder)


@pytest.fixture(scope="module")
def shown(dataset):
    return sequence_views(dataset.sequences)


@pytest.fixture(scope="module")
def page(dataset, shown):
    return dataset_page(dataset, statistics_of(dataset), shown, HOSTILE)


def picture(clip, layer, index):
    return cv2.imdecode(np.frombuffer(clip.layers[layer][index], np.uint8), cv2.IMREAD_COLOR)


def test_every_layer_that_was_written_is_there_frame_by_frame(shown):
    assert list(shown[0].layers) == list(LAYERS)
    assert list(shown[1].layers) == ["colour", "depth"]
    for clip in shown:
        assert clip.frames == clip.sequence.frame_count
        for webps in clip.layers.values():
            assert len(webps) == clip.frames
    assert picture(shown[0], "colour", 3).shape == (240, 2 * VIEW_PX, 3)


def test_ids_keep_their_colours(shown):
    sequence = shown[0].sequence
    known = {label_colours.instance_colour(one.id) for one in sequence.instances}
    colours = np.unique(picture(shown[0], "seg", 2).reshape(-1, 3), axis=0)
    assert {tuple(c) for c in colours.tolist()} <= known
    assert len(colours) >= 4


def test_numbers_are_those_of_the_records(shown):
    for clip in shown:
        data = sequence_data(clip)
        json.dumps(data, allow_nan=False)
        for index, truth in enumerate(clip.sequence.truths):
            places = np.array(data["positions"][index]) * 1e-4
            np.testing.assert_allclose(places, truth.centres_m, atol=0.51e-4)
            speeds = np.array(data["speeds"][index]) * 1e-3
            wanted = np.linalg.norm(truth.velocities_mps, axis=1)
            np.testing.assert_allclose(speeds, wanted, atol=0.51e-3)
            for v in range(len(CAMERAS)):
                for t in range(len(TARGETS)):
                    box = data["boxes"][index][v][t]
                    wanted = truth.views[v].boxes_px[t]
                    assert box == (None if np.isnan(wanted[0]) else wanted.astype(int).tolist())
                assert sum(map(len, data["keypoints"][index][v])) == len(KEYPOINTS)
        frames = [frame for frame, _ in clip.sequence.frames()]
        assert data["arrived"] == [[int(p is not None) for p in f.pictures] for f in frames]


def test_the_first_sequences_that_fit_are_taken(dataset, shown):
    def size(clip):
        return sum(len(packed) for _, packed in clip.packed.values())

    first, second = map(size, shown)
    # Base64 of a whole film is a little shorter than that of its frames one by one.
    room = first + 4 * shown[0].frames * len(LAYERS)
    assert [clip.frames for clip in sequence_views(dataset.sequences, room + 2 * second)] == [20, 5]
    assert [clip.frames for clip in sequence_views(dataset.sequences, room)] == [20]
    (part,) = sequence_views(dataset.sequences, first // 2)
    assert 5 < part.frames < 15
    assert size(part) <= first // 2
    (least,) = sequence_views(dataset.sequences, 0)
    assert least.frames == 1
    statistics = statistics_of(dataset)
    notices = [
        re.findall(r'<p class="notice">(Only.*?)</p>', dataset_page(dataset, statistics, c, "set"))
        for c in (shown, shown[:1], [part])
    ]
    assert notices[0] == []
    assert notices[1][0].startswith("Only the first 1 of 2 sequences are")
    assert f"{part.frames} of 20 frames" in notices[2][0]


def test_events_of_a_stranger_are_left_out_or_cut():
    pair = {"targets": ["head", "left_hand"], "view": "left"}
    events = {
        "merges": [{**pair, "first_frame": 2, "last_frame": 99}],
        "occlusions": [{"target": "head", "by": 3, "first_frame": 9, "last_frame": 9}, 7],
        "ambiguous": "often",
        "script": [{"event": "e", "first_frame": -1, "last_frame": 2}, {"event": "e" * 500}],
    }
    assert event_rows(events, 5) == [
        {"kind": "merges", "text": "head + left hand merged, left", "spans": [[2, 4]]}
    ]
    many = [{"event": str(i), "first_frame": 0, "last_frame": 0} for i in range(1000)]
    assert len(event_rows({"script": many}, 5)) == 40


def test_it_is_escaped_and_asks_for_nothing(page, shown):
    assert "<b>x" not in page
    assert "&lt;b&gt;x{{ 7*7 }}" in page
    scripts = 1 + sum(1 + len(clip.layers) for clip in shown)
    assert page.count("<script") == page.count("</script>") == scripts
    outside = re.sub(r"<script type=[^>]*>[^<]*<", "", page)
    for attribute in re.findall(r'(?:src|href)="([^"]*)"', outside):
        assert attribute.startswith(("#", "data:")), attribute[:60]
    for word in ("@import", "url(", "http://", "https://", "fetch(", "XMLHttpRequest"):
        assert word not in outside, word


def test_the_same_data_set_gives_the_same_page(dataset, page):
    again = sequence_views(open_dataset(dataset.folder).sequences)
    assert dataset_page(dataset, statistics_of(dataset), again, HOSTILE) == page


def test_the_sheet_has_a_row_a_sequence(dataset):
    sheet = dataset_sheet([(one, [0, 3]) for one in dataset.sequences])
    assert sheet.shape[1] == GAP_PX + 2 * 4 * (TILE_PX + GAP_PX)
    lone = dataset_sheet([(dataset.sequences[1], [0])])
    assert lone.shape[1] == GAP_PX + 2 * (TILE_PX + GAP_PX)  # it has colour and depth
    assert sheet[60:200, GAP_PX : GAP_PX + TILE_PX].std() > 20


def test_depth_colours_go_with_nearness():
    depth = np.array([[0.5, 1.0, 4.0, np.nan]], np.float32)
    near, middle, far, nothing = label_colours.depth_picture(depth)[0].tolist()
    assert near[2] > near[0]  # BGR: red
    assert far[0] > far[2]
    assert near != middle != far
    assert tuple(nothing) == label_colours.EMPTY


@pytest.fixture(scope="module")
def file(page, tmp_path_factory):
    """The page as a file."""
    return write_text(tmp_path_factory.mktemp("page") / "page.html", page)


def at(view, **data):
    """Wait until the player shows this frame, layer, sequence."""
    wanted = "".join(f'[data-{name}="{value}"]' for name, value in data.items())
    view.wait_for_selector(f"#player{wanted}")


def drawn(view):
    return [
        view.evaluate(f"document.querySelector('[data-part={part}]').toDataURL()")
        for part in CAMERAS
    ]


def test_slider_keys_layers_and_sequences(file, opened, shown):
    data = sequence_data(shown[0])
    with opened(file, READY, viewport={"width": 1280, "height": 900}) as view:
        at(view, frame=0, layer="colour", key=0)
        before = drawn(view)
        view.keyboard.press("ArrowRight")
        at(view, frame=1)
        slider = view.locator("[data-part=slider]")
        slider.focus()
        view.keyboard.press("ArrowRight")  # once, not twice
        at(view, frame=2)
        view.keyboard.press("Shift+ArrowRight")
        at(view, frame=12)
        view.keyboard.press("End")
        at(view, frame=19)
        assert all(old != new for old, new in zip(before, drawn(view), strict=True))
        pictures = []
        for number, layer in enumerate(LAYERS, 1):
            view.keyboard.press(str(number))
            at(view, frame=19, layer=layer)
            pictures.append(drawn(view)[0])
            assert view.inner_text("[data-part=legend]").strip()
        assert len(set(pictures)) == len(LAYERS)
        # The values are those of the frame.
        row = view.locator("[data-part=values] tr").nth(1).locator("td")
        said = [float(v) for v in row.nth(0).inner_text().split("/")]
        np.testing.assert_allclose(said, np.array(data["positions"][19][1]) * 1e-4, atol=1e-3)
        share = data["visible"][19][0][1]
        assert row.nth(2).inner_text() == (
            "out of view" if share is None else f"{share / 10:.1f} %"
        )
        # The next sequence lacks most layers.
        view.keyboard.press("n")
        at(view, key=1, frame=0, layer="colour")
        assert view.locator("input[name=layer]:disabled").count() == len(LAYERS) - 2
        view.goto(view.url.partition("#")[0] + "#seq=0@7")
        at(view, key=0, frame=7)


def test_bars_jump_marks_toggle_and_playing_goes_on(file, opened, shown):
    rows = sequence_data(shown[0])["events"]
    assert any(row["kind"] == "merges" for row in rows)
    with opened(file, READY, viewport={"width": 1280, "height": 900}) as view:
        assert view.locator(".lane").count() == len(rows)
        last = rows[-1]["spans"][-1][0]
        view.locator(".lane").nth(len(rows) - 1).locator("button").last.click()
        at(view, frame=last)
        for name in ("boxes", "points"):
            full = drawn(view)
            view.locator(f"[data-part=show-{name}]").uncheck()
            until(
                view,
                "old => document.querySelector('[data-part=left]').toDataURL() !== old",
                full[0],
            )
        view.keyboard.press("Home")
        at(view, frame=0)
        view.select_option("[data-part=speed]", "4")
        view.locator("[data-part=play]").click()
        at(view, frame=3)
        view.locator("[data-part=play]").click()
        assert view.inner_text("[data-part=play]") == "Play"


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_fits_on_a_phone(file, opened, scheme):
    settings = {"viewport": {"width": 390, "height": 800}, "color_scheme": scheme}
    with opened(file, READY, **settings, has_touch=True) as view:
        assert view.evaluate("document.documentElement.scrollWidth") == 390
        box = view.locator("[data-part=left]").bounding_box()
        assert box["width"] > 340
        ground = view.evaluate("getComputedStyle(document.body).backgroundColor")
        assert (ground == "rgb(255, 255, 255)") == (scheme == "light")
        view.locator(".layers label").nth(2).tap()
        at(view, layer="depth")


def test_a_recording_has_the_labels_under_their_names(dataset, tmp_path):
    pytest.importorskip("rerun", reason="needs the extra viz")
    chunks = pytest.importorskip("rerun.chunk", reason="this Rerun cannot read its own files")
    file = write_dataset_rerun(dataset, dataset.sequences, tmp_path / "out.rrd")
    rows = {}
    for chunk in chunks.RrdReader(file).stream():
        rows[chunk.entity_path] = rows.get(chunk.entity_path, 0) + chunk.num_rows
    for view in CAMERAS:
        for what in ("picture", "seg", "depth", "boxes/head", "keypoints/left_hand"):
            assert rows[f"/seq_000000/cameras/{view}/{what}"] == 20, what
        # The viewer knows no lens.
        assert f"/seq_000001/cameras/{view}/depth" not in rows
    assert rows["/seq_000001/truth/right_hand"] == 5


def test_names_of_a_stranger_do_not_break_the_sheet(dataset):
    entry = {"label": "ü" * 400, "seed": None}
    assert dataset_sheet([(replace(dataset.sequences[0], entry=entry), [0])]).ndim == 3


def test_the_packed_numbers_are_the_clips(page, shown):
    packed = re.findall(r'id="sequence-(\d+)">([^<]*)<', page)
    assert [number for number, _ in packed] == ["0", "1"]
    for clip, (_, text) in zip(shown, packed, strict=True):
        assert json.loads(gzip.decompress(base64.b64decode(text))) == sequence_data(clip)
