"""The page: self-contained, escaped, and drawn by a real browser."""

import base64
import gzip
import json
import re
import shutil

import numpy as np
import pytest

from pjpdaf.errors import BenchError
from pjpdaf.frames import StereoFrame
from reports.overlay import overlay_jpeg
from reports.page import build_page, write_page
from reports.records import EpisodeFailure, Picture
from reports.results import RunInfo, load, save

HOSTILE = '<script>alert("x")</script>&{{ 7*7 }}'


@pytest.fixture(scope="module")
def runs(episode_of, tools, tmp_path_factory):
    base = tmp_path_factory.mktemp("page")
    centres = tools.paths(24, 3.0)
    swapped = tools.noisy(centres, 1)
    swapped[8:] = swapped[8:][:, [0, 2, 1]]
    sample = episode_of(centres_m=centres).frames

    def draw(frame, o):
        return overlay_jpeg(frame, tools.cameras(), o.detections, o.estimates, o.truth)

    pictures = tuple(
        Picture(f, draw(StereoFrame(f, f / 3, (tools.picture(f),) * 2), sample[f])) for f in (0, 12)
    )
    episodes = [
        episode_of(tools.noisy(centres, 0), centres_m=centres, scenario=HOSTILE, seed=0),
        episode_of(swapped, centres_m=centres, scenario=HOSTILE, seed=1, pictures=pictures),
        episode_of(
            tools.noisy(centres, 2, 0.1),
            centres_m=centres,
            scenario="speed_ladder",
            labels=lambda f: (f"speed:{0.1 * (1 + f // 8):.1f}",),
        ),
        EpisodeFailure("speed_ladder", 1, "</script><b>crash"),
    ]
    info = RunInfo(
        HOSTILE,
        preset="default",
        parameters={"gate": 15.0, "note": HOSTILE},
        overrides={"gate": 12.0},
        argv=("run", HOSTILE),
    )
    whole = load(save(base / "a", episodes, info))
    part = load(save(base / "b", episodes[:2], RunInfo("other", complete=False)))
    return whole, part


@pytest.fixture(scope="module")
def page(runs):
    return build_page([runs[0]])


def packed(page, name):
    text = re.search(rf'id="{name}-packed">([^<]*)</script>', page)[1]
    return gzip.decompress(base64.b64decode(text))


def test_hostile_names_are_escaped(page):
    assert "<script>alert" not in page
    assert "<b>crash" not in page
    assert "&lt;script&gt;alert" in page
    assert "{{ 7*7 }}" in page  # never evaluated
    assert page.count("</script>") == page.count("<script") == 3


def test_no_address_outside_the_page(page):
    outside = re.sub(r'id="\w+-packed">[^<]*<', "", page)
    for attribute in re.findall(r'(?:src|href)="([^"]*)"', outside):
        assert attribute.startswith(("#", "data:")), attribute[:60]
    assert "@import" not in outside
    assert "url(" not in outside


def test_plotly_is_in_it_once_and_packed(page):
    assert packed(page, "plotly").startswith(b"/**\n* plotly.js")
    assert len(page) < 4e6


def test_figures_of_every_episode(page):
    figures = json.loads(packed(page, "figures"))
    assert sorted(figures) == [
        "errors-0-0-0",
        "errors-0-0-1",
        "errors-0-1-0",
        "paths-0-0-0",
        "paths-0-0-1",
        "paths-0-1-0",
        "speed-0-1",
    ]


def test_the_episode_with_pictures_comes_first(page):
    options = re.findall(r'<option value="([^"]*)">([^<]*)</option>', page)
    assert options[0] == ("0-0-1", "seed 1 (swapped, lost)")
    assert page.count("<img decoding=") == 2


def test_two_runs_side_by_side(runs):
    page = build_page(runs)
    assert "other is incomplete" in page
    assert "other, seed 1 (swapped, lost)" in page
    twice = build_page([runs[1], runs[1]])
    assert "other (1)" in twice
    assert "other (2)" in twice


def test_same_run_same_page(runs, page):
    assert build_page([runs[0]]) == page


def test_a_run_without_episodes_has_a_page(tmp_path):
    run = load(save(tmp_path / "run", [], RunInfo("none", complete=False)))
    assert "0 episodes, none with a result." in build_page([run])


def test_no_run_and_no_place(runs, tmp_path):
    with pytest.raises(BenchError, match="at least one saved run"):
        build_page([])
    with pytest.raises(BenchError, match="cannot write the report"):
        write_page([runs[0]], tmp_path / "nowhere" / "report.html")


def test_many_pictures_are_thinned(episode_of, tmp_path):
    pictures = tuple(Picture(f, b"\xff\xd8") for f in range(30))
    run = load(save(tmp_path / "run", [episode_of(pictures=pictures)], RunInfo("run")))
    captions = re.findall(r"<span>(frame \d+)</span>", build_page([run]))
    assert len(captions) == 8
    assert (captions[0], captions[-1]) == ("frame 0", "frame 29")


@pytest.mark.skipif(shutil.which("chromium") is None, reason="no chromium on PATH")
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_browser_draws_it_without_network(runs, tmp_path, scheme):
    sync_api = pytest.importorskip("playwright.sync_api")
    path = write_page([runs[0]], tmp_path / "report.html")
    complaints, requests = [], []
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"),
            args=[
                "--no-sandbox",
                "--disable-quic",
                "--disable-background-networking",
                "--disable-component-update",
                "--use-angle=swiftshader",
                "--enable-unsafe-swiftshader",
            ],
        )
        view = browser.new_page(
            viewport={"width": 420 if scheme == "dark" else 1300, "height": 3000},
            color_scheme=scheme,
        )
        view.on(
            "console",
            lambda m: complaints.append(m.text) if m.type == "error" else None,
        )
        view.on("pageerror", lambda e: complaints.append(str(e)))
        view.on("request", lambda r: requests.append(r.url))
        view.goto(path.as_uri())
        view.wait_for_selector("html[data-ready=yes]")
        view.wait_for_selector('[data-kind="errors"] .main-svg')
        view.wait_for_selector('[data-kind="paths"] canvas')
        first = view.locator('[data-kind="errors"]').first
        assert first.locator(".scatterlayer .trace").count() >= 6
        view.locator('[data-kind="speed"]').scroll_into_view_if_needed()
        view.wait_for_selector('[data-kind="speed"] .scatterlayer .trace')
        assert view.locator('[data-kind="speed"] .scatterlayer .trace').count() == 2
        view.evaluate("scrollTo(0, 0)")
        # Another seed: other figures, no pictures.
        view.select_option("select >> nth=0", "0-0-0")
        assert first.get_attribute("data-drawn") == "errors-0-0-0"
        assert view.locator(".no-shots").first.is_visible()
        view.select_option("select >> nth=0", "0-0-1")
        # Pictures open by keyboard, step, and close.
        view.locator(".shot").first.focus()
        view.keyboard.press("Enter")
        assert view.locator("#lightbox span").inner_text() == "frame 0"
        view.keyboard.press("ArrowRight")
        assert view.locator("#lightbox span").inner_text() == "frame 12"
        view.keyboard.press("Escape")
        assert not view.locator("#lightbox").is_visible()
        # Nothing but the tables' own scroll areas is wider than the screen.
        width = view.evaluate("document.documentElement.scrollWidth")
        assert width <= view.evaluate("innerWidth")
        browser.close()
    assert complaints == []
    assert all(url.startswith(("file:", "data:", "blob:")) for url in requests)


def test_numbers_that_are_not_finite_do_not_reach_the_page(episode_of, tools, tmp_path):
    centres = tools.paths(6, 3.0)
    estimates = centres + np.array([5.0, 0, 0])  # behind the cameras
    run = load(save(tmp_path / "run", [episode_of(estimates, centres_m=centres)], RunInfo("run")))
    figures = json.loads(packed(build_page([run]), "figures"))
    assert figures["errors-0-0-0"]["data"][0]["y"] == [None] * 6
