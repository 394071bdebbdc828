"""The page of a data set: its own numbers, in its room, escaped, and worked in a real browser."""

import base64
import gzip
import json
import re

import numpy as np
import pytest
from every_reader import faults
from waiting import until

from reports.dataset.page import dataset_page
from reports.dataset.sequence_data import sequence_data
from reports.dataset.sequence_view import LAYERS, sequence_views
from reports.page.templating import write_text
from sim.dataset.reader import open_dataset
from sim.dataset.statistics import statistics_of
from sim.scene.world import CAMERAS

LEFT = "document.querySelector('[data-part=left]')"
FRAMES = 20  # of the first sequence
HOSTILE = "</script><b>x{{ 7*7 }}"
READY = "html[data-ready=yes]"


@pytest.fixture(scope="module")
def dataset(labelled):
    return labelled


@pytest.fixture(scope="module")
def page(dataset, shown):
    return dataset_page(dataset, statistics_of(dataset), shown, HOSTILE)


def test_the_first_sequences_that_fit_are_taken(dataset, shown):
    # The second sequence is short and of few layers, so that it can be packed several times.
    sequence, clip = dataset.sequences[1], shown[1]
    size = sum(len(packed) for _, packed in clip.packed.values())
    # Base64 of a whole film is a little shorter than that of its frames one by one.
    room = size + 4 * clip.frames * len(clip.layers)

    def frames(most_bytes):
        return [view.frames for view in sequence_views([sequence] * 3, most_bytes)]

    whole = sequence.frame_count
    assert [c.frames for c in shown] == [FRAMES, whole]
    assert frames(2 * room) == [whole, whole]
    assert frames(room + size // 2) == [whole]
    assert frames(0) == [1]
    (part,) = sequence_views([sequence], size // 2)
    assert 1 < part.frames < whole
    assert sum(len(packed) for _, packed in part.packed.values()) <= size // 2
    statistics = statistics_of(dataset)
    notices = [
        re.findall(r'<p class="notice">(Only.*?)</p>', dataset_page(dataset, statistics, c, "set"))
        for c in (shown, shown[:1], [part])
    ]
    assert notices[0] == []
    assert notices[1][0].startswith("Only the first 1 of 2 sequences are")
    assert f"{part.frames} of {whole} frames" in notices[2][0]


def test_it_is_escaped_and_asks_for_nothing(page, shown):
    assert "<b>x" not in page
    assert "&lt;b&gt;x{{ 7*7 }}" in page
    scripts = 5 + sum(1 + len(clip.layers) for clip in shown)
    assert page.count("<script") == page.count("</script>") == scripts
    outside = re.sub(r"<script type=[^>]*>[^<]*<", "", page)
    for attribute in re.findall(r'(?:src|href)="([^"]*)"', outside):
        assert attribute.startswith(("#", "data:")), attribute[:60]
    for word in ("@import", "url(", "http://", "https://", "fetch(", "XMLHttpRequest"):
        assert word not in outside, word


def test_the_same_data_set_gives_the_same_page(dataset, shown):
    def page():
        opened = open_dataset(dataset.folder)
        first = sequence_views(opened.sequences, least)
        return dataset_page(opened, statistics_of(opened), first, HOSTILE)

    least = sum(len(packed) for _, packed in shown[0].packed.values()) // 5  # of all layers
    assert page() == page()


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
        at(view, frame=FRAMES - 1)
        assert all(old != new for old, new in zip(before, drawn(view), strict=True))
        pictures = []
        for number, layer in enumerate(LAYERS, 1):
            view.keyboard.press(str(number % 10))  # the tenth is 0
            at(view, frame=FRAMES - 1, layer=layer)
            pictures.append(drawn(view)[0])
            assert view.inner_text("[data-part=legend]").strip()
        assert len(set(pictures)) == len(LAYERS)
        # The values are those of the frame.
        row = view.locator("[data-part=values] tr").nth(1).locator("td")
        said = [float(v) for v in row.nth(0).inner_text().split("/")]
        np.testing.assert_allclose(said, np.array(data["positions"][-1][1]) * 1e-4, atol=1e-3)
        share = data["visible"][-1][0][1]
        assert row.nth(2).inner_text() == (
            "out of view" if share is None else f"{share / 10:.1f}\N{NO-BREAK SPACE}%"
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
        for name, on in (("boxes", False), ("joints", False), ("points", True)):
            full = drawn(view)
            view.locator(f"[data-part=show-{name}]").set_checked(on)
            until(
                view,
                "old => document.querySelector('[data-part=left]').toDataURL() !== old",
                full[0],
            )
        view.keyboard.press("Home")
        at(view, frame=0)
        view.select_option("[data-part=speed]", "4")
        view.locator("[data-part=play]").click()
        until(view, "() => Number(document.getElementById('player').dataset.frame) > 2")
        view.locator("[data-part=play]").click()
        assert view.inner_text("[data-part=play]") == "Play"


def test_it_fits_on_a_phone_and_follows_the_readers_theme(file, opened):
    settings = {"viewport": {"width": 390, "height": 800}, "has_touch": True}
    with opened(file, READY, **settings) as view:
        assert view.evaluate("document.documentElement.scrollWidth") == 390
        box = view.locator("[data-part=left]").bounding_box()
        assert box["width"] > 340
        for scheme in ("dark", "light"):
            view.emulate_media(color_scheme=scheme)
            ground = view.evaluate("getComputedStyle(document.body).backgroundColor")
            assert (ground == "rgb(255, 255, 255)") == (scheme == "light")
        view.locator(".layers label").nth(2).tap()
        at(view, layer="depth")


def test_the_packed_numbers_are_the_clips(page, shown):
    packed = re.findall(r'id="sequence-(\d+)">([^<]*)<', page)
    assert [number for number, _ in packed] == ["0", "1"]
    for clip, (_, text) in zip(shown, packed, strict=True):
        assert json.loads(gzip.decompress(base64.b64decode(text))) == sequence_data(clip)


def test_it_is_for_every_reader(file, opened):
    with opened(file, READY) as view:
        assert faults(view) == []
