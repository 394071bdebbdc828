"""The player in a real browser: opens on the worst, keys, links, two runs, no black tile."""

from dataclasses import replace

import numpy as np
import pytest
from waiting import until

from pjpdaf.frames import StereoFrame
from reports.page.page import build_page
from reports.page.templating import write_text
from reports.pictures.stills import still
from reports.run.load import load
from reports.run.save import RunInfo, save
from reports.score.records import Still

READY = "html[data-thumbs=yes]"
WORST = "#player[data-key='0-1-0']"
FRAME = "document.getElementById('player').dataset.frame"
# Pixels of the line from a wrong estimate to its own truth.
RED = """name => { const c = document.querySelector(`[data-part=${name}]`);
  const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0;
  for (let i = 0; i < d.length; i += 4) n += d[i] > 235 && d[i+1] < 90 && d[i+2] < 80;
  return n; }"""
# Different colours of a canvas.
COLOURS = """name => { const c = document.querySelector(`[data-part=${name}]`), all = new Set();
  const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
  for (let i = 0; i < d.length; i += 4) all.add(d[i] << 16 | d[i+1] << 8 | d[i+2]);
  return all.size; }"""


@pytest.fixture(scope="module")
def report(episode_of, tools, tmp_path_factory):
    """Two runs of two episodes; the second of the first run swaps the hands at frame 8 of 16."""
    base = tmp_path_factory.mktemp("player")
    centres = tools.paths(16, 3.0)
    swapped = tools.noisy(centres, 1)
    swapped[8:] = swapped[8:][:, [0, 2, 1]]
    frames = [StereoFrame(f, f / 3, (tools.picture(f), tools.picture(f + 50))) for f in range(16)]
    film = tuple(Still(f.index, still(f, tools.cameras())) for f in frames)

    def played(estimates, scenario, **more):
        episode = episode_of(estimates, centres_m=centres, scenario=scenario, **more)
        return replace(episode, film=film if scenario == "cross" else ())

    stated = np.linspace(0, 0.6, 16)
    good = tools.noisy(centres, 2)
    first = [played(good, "bounce"), played(swapped, "cross", exchange=stated)]
    second = [played(good, "bounce"), played(good, "cross")]
    runs = [
        load(save(base / name, episodes, RunInfo(name)))
        for name, episodes in (("thesis", first), ("default", second))
    ]
    return write_text(base / "report.html", build_page(runs))


def settled(view, frame):
    view.wait_for_selector(f'#player[data-frame="{frame}"]')


def test_it_opens_on_the_worst_moment_and_keys_work_anywhere(report, opened):
    with opened(report, READY, viewport={"width": 1300, "height": 900}) as view:
        view.wait_for_selector(WORST)
        worst = int(view.evaluate(FRAME))
        assert worst >= 8
        assert all(view.evaluate(RED, name) > 60 for name in ("left", "right", "space"))
        assert "#" not in view.url
        press = view.keyboard.press
        for key, frame in (
            ("ArrowLeft", worst - 1),
            ("ArrowRight", worst),
            ("[", 8 if worst > 8 else 0),
            ("Home", 0),
            ("End", 15),
            ("Shift+ArrowLeft", 5),
            ("]", 8),
            ("w", worst),
        ):
            press(key)
            settled(view, frame)
        box = view.locator("[data-part=show-detections]")
        press("2")
        assert not box.is_checked()
        press("2")
        press(" ")
        assert view.inner_text("[data-part=play]") == "Pause"
        press(" ")
        press("n")
        view.wait_for_selector("#player[data-key='1-1-0']")
        press("p")
        view.wait_for_selector(WORST)
        settled(view, worst)
        # Not while somebody types, nor when they are switched off.
        view.evaluate("document.body.prepend(document.createElement('input'))")
        view.locator("body > input").type("wn]")
        view.keyboard.press("Home")
        assert view.input_value("body > input") == "wn]"
        view.evaluate("document.activeElement.remove()")
        view.locator("[data-part=keys]").uncheck()
        view.evaluate("document.activeElement.blur()")
        press("n")
        assert view.evaluate("document.getElementById('player').dataset.key") == "0-1-0"
        settled(view, worst)


def test_a_frame_has_a_link_that_opens_there(report, opened):
    with opened(report, READY, viewport={"width": 1300, "height": 900}) as view:
        view.locator("[data-part=slider]").focus()
        view.keyboard.press("Home")
        settled(view, 0)
        view.keyboard.press("o")
        until(view, "() => location.hash === '#play=0-1-0@0+1-1-0,over'")
        view.get_by_role("button", name="Copy link").click()
        until(view, "() => document.querySelector('[data-part=copied]').textContent !== ''")
        view.goto("about:blank")
        view.goto(report.as_uri() + "#play=0-1-0@9+1-1-0,beside")
        view.wait_for_selector(READY)
        settled(view, 9)
        assert view.locator("[data-part=stage-b]").is_visible()


def test_two_runs_in_one_player(report, opened):
    with opened(report, READY, viewport={"width": 1300, "height": 900}) as view:
        alone = view.evaluate("document.querySelector('[data-part=curves]').toDataURL()")
        view.get_by_text("B laid over A", exact=True).first.click()
        view.wait_for_selector("#player[data-compare=over]")
        until(
            view, "old => document.querySelector('[data-part=curves]').toDataURL() !== old", alone
        )
        assert view.inner_text("[data-part=who]") == "A (solid) is thesis, B (dashed) is default."
        error = view.locator("[data-part=readout] tr:nth-child(2) td:nth-child(3)")
        assert " | " in error.inner_text()
        # The error of the run that is wrong is marked, not that of the other.
        assert error.locator(".bad").all_inner_texts() == [error.inner_text().split(" | ")[0]]
        view.get_by_text("side by side", exact=True).first.click()
        view.wait_for_selector("#player[data-compare=beside]")
        # The pictures of both are there once; B is right where A is wrong.
        assert view.evaluate("document.getElementById('film-1-1-0').dataset.owner") == "0-1-0"
        until(view, f"() => ({COLOURS})('left-b') > 500")
        assert view.evaluate(RED, "left-b") < 60 < view.evaluate(RED, "left")
        view.keyboard.press("x")
        view.wait_for_selector("#player[data-key='1-1-0']")
        until(view, f"() => ({RED})('left') < 60 && ({RED})('left-b') > 60")


def test_a_frame_without_a_picture_is_drawn_as_a_scheme(report, opened):
    with opened(report, READY, viewport={"width": 1300, "height": 900}) as view:
        view.select_option("[data-part=episode]", "0-0-0")
        view.wait_for_selector("#player[data-key='0-0-0']")
        for name in ("detections", "estimates", "truth"):
            view.locator(f"[data-part=show-{name}]").uncheck()
        until(view, f"() => ({COLOURS})('left') < 5000")
        assert view.evaluate(COLOURS, "left") > 20  # discs, ways, words


def test_the_film_loops_pauses_and_rests_where_motion_is_unwanted(report, opened):
    settings = {"viewport": {"width": 1300, "height": 900}, "reduced_motion": "no-preference"}
    with opened(report, READY, **settings) as view:
        film = view.locator("[data-film]")
        first = film.get_attribute("data-frame")
        until(view, "old => document.querySelector('[data-film]').dataset.frame !== old", first)
        film.get_by_role("button").click()
        assert film.get_attribute("data-playing") == "no"
        assert film.get_by_role("button").inner_text() == "Play"
    with opened(report, READY) as view:
        film = view.locator("[data-film]")
        assert film.get_attribute("data-playing") == "no"
        assert film.get_attribute("data-film") == f"0-1-0@{film.get_attribute('data-frame')}"


def test_controls_can_be_hit_on_a_phone(report, opened):
    settings = {"viewport": {"width": 390, "height": 844}, "has_touch": True}
    with opened(report, READY, **settings) as view:
        small = view.evaluate(
            """() => [...document.querySelectorAll('#player button, #player select, #player label')]
            .filter(e => e.offsetParent).map(e => [e.textContent.trim().slice(0, 20),
              e.getBoundingClientRect().width, e.getBoundingClientRect().height])
            .filter(([, w, h]) => w < 24 || h < 24)"""
        )
        assert small == []
        assert view.evaluate("document.documentElement.scrollWidth") <= 390
