"""The page: self-contained, escaped, in its size, and worked by hand in a real browser."""

import base64
import gzip
import json
import re
from dataclasses import replace

import cv2
import numpy as np
import pytest
from waiting import until

from pjpdaf.errors import BenchError
from pjpdaf.frames import StereoFrame
from reports.page.page import build_page, write_page
from reports.page.templating import write_text
from reports.pictures.overlay import overlay_jpeg
from reports.pictures.stills import still
from reports.run.load import load
from reports.run.rows import rows_of
from reports.run.save import RunInfo, save
from reports.score.records import BUDGET_LEVELS, EpisodeFailure, OverlayPicture, Still

LEFT = "document.querySelector('[data-part=left]')"
HOSTILE = '<script>alert("x")</script>&{{ 7*7 }}'
DRAWN = "html[data-thumbs=yes]"


@pytest.fixture(scope="module")
def runs(episode_of, tools, tmp_path_factory):
    """A run of two scenarios, one with a swap, a film, a failed seed; and a part of it."""
    base = tmp_path_factory.mktemp("page")
    centres = tools.paths(24, 3.0)
    swapped = tools.noisy(centres, 1)
    swapped[8:] = swapped[8:][:, [0, 2, 1]]
    sample = episode_of(centres_m=centres).frames

    def draw(frame, o):
        return overlay_jpeg(frame, tools.cameras(), o.detections, o.estimates, o.truth)

    shown = [StereoFrame(f, f / 3, (tools.picture(f), tools.picture(f + 50))) for f in range(24)]
    pictures = tuple(OverlayPicture(f, draw(shown[f], sample[f])) for f in (0, 12))
    film = tuple(Still(f.index, still(f, tools.cameras())) for f in shown)
    bad = replace(
        episode_of(swapped, centres_m=centres, scenario=HOSTILE, seed=1, pictures=pictures),
        film=film,
        blame={("swap", 1, 8): "association", ("lost", 1, 8): "none"},
    )
    budget = {level: np.full((24, 3), 0.004 * (1 + n)) for n, level in enumerate(BUDGET_LEVELS)}
    episodes = [
        replace(
            episode_of(tools.noisy(centres, 0), centres_m=centres, scenario=HOSTILE, seed=0),
            film=film[::8],
            budget_m=budget,
        ),
        bad,
        episode_of(
            tools.noisy(centres, 2, 0.1),
            centres_m=centres,
            scenario="speed_ladder",
            group="fast",
            labels=lambda f: (f"speed:{0.1 * (1 + f // 8):.1f}",),
        ),
        EpisodeFailure("speed_ladder", 1, "</script><b>crash", group="fast"),
        episode_of(
            tools.noisy(centres, 3), centres_m=centres, scenario="calm_table", group="baseline"
        ),
    ]
    info = RunInfo(
        HOSTILE,
        preset="default",
        parameters={"gate": 15.0, "note": HOSTILE, "detector": {"p": 5}},
        overrides={"gate": 12.0},
        argv=("run", HOSTILE),
    )
    whole = load(save(base / "a", episodes, info))
    part = load(save(base / "b", episodes[:2], RunInfo("other", complete=False)))
    return whole, part


@pytest.fixture(scope="module")
def page(runs):
    return build_page([runs[0]])


def test_hostile_names_are_escaped(page):
    assert "<script>alert" not in page
    assert "<b>crash" not in page
    assert "&lt;script&gt;alert" in page
    assert "{{ 7*7 }}" in page  # never evaluated
    # Four episodes, two of them with pictures, and six scripts.
    assert page.count("</script>") == page.count("<script") == 12


def test_no_address_outside_the_page(page):
    outside = re.sub(r'id="(episode|film)-[^>]*>[^<]*<', "", page)
    for attribute in re.findall(r'(?:src|href)="([^"]*)"', outside):
        assert attribute.startswith(("#", "data:")), attribute[:60]
    for word in ("@import", "url(", "http://", "https://", "fetch(", "XMLHttpRequest"):
        assert word not in outside, word


def test_every_link_inside_the_page_has_its_target(page):
    ids = set(re.findall(r'\bid="([^"]*)"', page))
    for target in re.findall(r'href="#([^"]*)"', page):
        play = re.fullmatch(r"play=([\d-]+)(@\d+)?", target)
        assert (f"episode-{play[1]}" if play else target) in ids, target
    for key in re.findall(r'data-thumb="([\d-]+)@', page):
        assert f"episode-{key}" in ids


def test_data_of_every_episode(page):
    keys = re.findall(r'id="episode-([\d-]+)">([^<]*)<', page)
    assert [key for key, _ in keys] == ["0-0-0", "0-0-1", "0-1-0", "0-2-0"]
    data = json.loads(gzip.decompress(base64.b64decode(keys[1][1])))
    assert (data["scenario"], data["seed"]) == (HOSTILE, 1)
    films = dict(re.findall(r'id="film-([\d-]+)" data-sizes="([^"]*)"', page))
    assert films.keys() == {"0-0-0", "0-0-1"}
    assert len(films["0-0-0"].split()) == 3
    assert len(films["0-0-1"].split()) == 24


def test_what_it_says_of_groups_blame_and_budget(page):
    assert re.findall(r'<th scope="row">(baseline|fast)</th>', page) == ["baseline", "fast"]
    assert "swaps: 1 association; losses: 1 no single stage" in page
    assert page.count("+4.0") == 5 * 3  # each level of the budget adds as much
    assert re.search(r'data-label="To blame">association</td>', page)


def test_the_gallery_has_what_went_wrong_worst_first(page):
    gallery = page.partition('id="failures"')[2].partition('id="player"')[0]
    assert re.findall(r"#play=([\d-]+)@", gallery) == ["0-2-0", "0-0-1"]


def test_the_thesis_is_beside_it(page):
    thesis = page.partition('id="thesis"')[2]
    assert re.findall(r"Fig\. (4\.\d):", thesis) == [f"4.{n}" for n in range(1, 8)]
    assert "it is made from drink" in thesis
    assert "not stated" in thesis


@pytest.fixture(scope="module")
def pair(runs):
    return build_page(runs)


def test_two_runs_side_by_side(pair, runs):
    assert "other is incomplete" in pair
    assert "other, seed 1" in pair
    assert 'id="episode-1-0-1"' in pair
    twice = build_page([runs[1], runs[1]])
    assert "other (1)" in twice
    assert "other (2)" in twice


def test_same_run_same_page(runs, page):
    assert build_page([runs[0]]) == page


def test_a_run_without_episodes_has_a_page(tmp_path):
    run = load(save(tmp_path / "run", [], RunInfo("none", complete=False)))
    page = build_page([run])
    assert "Nothing was played." in page
    assert 'id="player"' not in page


def test_no_run_and_no_place(runs, tmp_path):
    with pytest.raises(BenchError, match="at least one saved run"):
        build_page([])
    with pytest.raises(BenchError, match="cannot write the report"):
        write_page([runs[0]], tmp_path / "nowhere" / "report.html")


def test_pictures_that_are_none(episode_of, tmp_path):
    pictures = (OverlayPicture(0, b"\xff\xd8"),)
    run = load(save(tmp_path / "run", [episode_of(pictures=pictures)], RunInfo("run")))
    with pytest.raises(BenchError, match=r"00000\.jpg: is no picture"):
        build_page([run])


def test_many_pictures_are_thinned(episode_of, tools, tmp_path):
    jpeg = bytes(cv2.imencode(".jpg", tools.picture())[1])
    pictures = tuple(OverlayPicture(f, jpeg) for f in range(30))
    run = load(save(tmp_path / "run", [episode_of(pictures=pictures)], RunInfo("run")))
    captions = re.findall(r"<img [^>]*><span>(frame \d+)</span>", build_page([run]))
    assert len(captions) == 8
    assert (captions[0], captions[-1]) == ("frame 0", "frame 29")


def test_numbers_that_are_not_finite_do_not_reach_the_page(episode_of, tools, tmp_path):
    centres = tools.paths(6, 3.0)
    estimates = centres + np.array([5.0, 0, 0])  # behind the cameras
    run = load(save(tmp_path / "run", [episode_of(estimates, centres_m=centres)], RunInfo("run")))
    packed = re.search(r'id="episode-0-0-0">([^<]*)<', build_page([run]))[1]
    text = gzip.decompress(base64.b64decode(packed)).decode()
    assert "NaN" not in text
    assert "Infinity" not in text
    assert json.loads(text)["px"] == [[None] * 6] * 3


@pytest.fixture(scope="module")
def sixty(episode_of, tools):
    """Sixty episodes of fifty frames in thirty scenarios, a quarter of them swapped."""
    centres = tools.paths(50, 3.0)
    played = []
    for n in range(60):
        estimates = tools.noisy(centres, n, 0.05)
        if n % 4 == 0:
            estimates[20:] = estimates[20:][:, [0, 2, 1]]
        name = f"scenario_{n // 2:02d}"
        played.append(rows_of(episode_of(estimates, centres_m=centres, scenario=name, seed=n % 2)))
    return played


@pytest.mark.long
@pytest.mark.parametrize(
    ("filmed", "limit"), [(False, 9e6), pytest.param(True, 16e6, marks=pytest.mark.long)]
)
def test_sixty_episodes_stay_in_their_size(sixty, episode_of, tools, tmp_path, filmed, limit):
    # Frames of a noisy picture are about 8 kB, and no room is won by packing them again.
    webp = np.random.default_rng(0).bytes(8000)
    said = episode_of(frames=1).frames[0].estimates
    both = StereoFrame(0, 0.0, (tools.picture(), tools.picture(1)))
    jpeg = overlay_jpeg(both, tools.cameras(), (), said)
    played = [
        replace(
            row,
            pictures=tuple(OverlayPicture(f, jpeg) for f in range(0, 50, 5))
            if row.seed == 0
            else (),
            film=tuple(Still(f, webp) for f in range(0, 50, 1 if filmed else 5)),
        )
        for row in sixty
    ]
    run = load(save(tmp_path / "run", played, RunInfo("run")))
    assert len(run.frames) == 3 * 3000
    assert write_page([run], tmp_path / "report.html").stat().st_size <= limit


def at_frame(view, frame):
    """Wait until the player shows this frame."""
    view.wait_for_selector(f'#player[data-frame="{frame}"]')


@pytest.fixture(scope="module")
def report(page, tmp_path_factory):
    """The page of one run as a file."""
    return write_text(tmp_path_factory.mktemp("report") / "report.html", page)


PARTS = ("left", "right", "space", "curves")


# A drawing follows in the browser's next frame, which a busy machine takes its time for.
SPACE_IS_NOT = "old => document.querySelector('[data-part=space]').toDataURL() !== old"


def drawings(view):
    """What the four canvases show."""
    return [
        view.evaluate(f"document.querySelector('[data-part={part}]').toDataURL()") for part in PARTS
    ]


def test_the_slider_moves_everything(report, opened):
    with opened(report, DRAWN, viewport={"width": 1300, "height": 900}) as view:
        # Verdict, tiles and the table by group are on the first screen.
        for selector in (".verdict", ".tiles", "#summary tbody tr"):
            box = view.locator(selector).first.bounding_box()
            assert box["y"] + box["height"] < 900, selector
        view.select_option("[data-part=episode]", "0-0-1")
        view.wait_for_selector('#player[data-key="0-0-1"]')
        slider = view.locator("[data-part=slider]")
        # On a busy machine the episode still opens, on its worst frame, when a first key arrives.
        for _ in range(50):
            slider.focus()
            view.keyboard.press("Home")
            view.wait_for_timeout(200)
            if view.get_attribute("#player", "data-frame") == "0":
                break
        at_frame(view, 0)
        before = drawings(view)
        view.keyboard.press("ArrowRight")
        at_frame(view, 1)
        assert all(old != new for old, new in zip(before, drawings(view), strict=True))
        for part in PARTS:
            assert view.get_attribute(f"[data-part={part}]", "data-frame") == "1"
        view.keyboard.press("End")
        at_frame(view, 23)
        words = "frame 23, 7.67 s, left and right exchanged, right hand lost, left hand lost"
        assert slider.get_attribute("aria-valuetext") == words
        assert view.inner_text("[data-part=readout] tr:nth-child(2) td:nth-child(3)") != "–"
        # A jump to the swap; a click into the curves; buttons.
        view.get_by_role("button", name="hands swapped, 8–23").click()
        at_frame(view, 8)
        curves = view.locator("[data-part=curves]")
        curves.click(position={"x": curves.bounding_box()["width"] - 13, "y": 40})
        at_frame(view, 23)
        view.locator("[data-by='-1']").click()
        at_frame(view, 22)
        # Playing goes on by itself and stops.
        view.select_option("[data-part=speed]", "4")
        view.locator("[data-part=play]").click()
        until(view, "() => /^[0-6]$/.test(document.getElementById('player').dataset.frame)")
        view.locator("[data-part=play]").click()
        assert view.inner_text("[data-part=play]") == "Play"


def test_pictures_toggles_and_turning(report, opened):
    with opened(report, DRAWN, viewport={"width": 1300, "height": 900}) as view:
        view.goto(report.as_uri() + "#play=0-0-1@5")
        at_frame(view, 5)
        full = drawings(view)
        for name in ("picture", "detections", "estimates", "truth"):
            view.locator(f"[data-part=show-{name}]").uncheck()
            until(
                view,
                "old => document.querySelector('[data-part=left]').toDataURL() !== old",
                full[0],
            )
            assert drawings(view)[0] != full[0], name
            view.locator(f"[data-part=show-{name}]").check()
            until(
                view,
                "old => document.querySelector('[data-part=left]').toDataURL() === old",
                full[0],
            )
        # The 3-D view turns by mouse and by keyboard; the other parts stay.
        space = view.locator("[data-part=space]")
        space.hover(position={"x": 200, "y": 100})
        view.mouse.down()
        space.hover(position={"x": 120, "y": 130})
        view.mouse.up()
        until(view, SPACE_IS_NOT, full[2])
        turned = drawings(view)
        assert turned[:2] == full[:2]
        space.focus()
        view.keyboard.press("ArrowLeft")
        until(view, SPACE_IS_NOT, turned[2])
        view.keyboard.press("0")
        until(view, f"old => !({SPACE_IS_NOT})(old)", full[2])
        view.get_by_role("button", name="top").click()
        assert view.get_attribute("[data-part=space]", "data-turn") == "0.00 1.57 1.00"


def test_links_lead_to_the_player_and_back(report, opened):
    with opened(report, DRAWN, viewport={"width": 1000, "height": 800}) as view:
        card = view.locator("#failures a").nth(1)
        card.focus()
        view.keyboard.press("Enter")
        view.wait_for_selector('#player[data-key="0-0-1"]')
        worst = card.get_attribute("href").partition("@")[2]
        at_frame(view, worst)
        assert 0 <= view.locator("#player").bounding_box()["y"] < 70
        event = view.locator(".events a").first
        event.scroll_into_view_if_needed()
        event.click()
        at_frame(view, 8)
        view.go_back()
        at_frame(view, worst)
        # A closed scenario opens when a link leads to it.
        view.evaluate("document.querySelectorAll('.scenario details').forEach(d => d.open = false)")
        view.locator('#summary a[href="#scenario-1"]').click()
        view.wait_for_selector("#scenario-1 > details[open]", state="attached")


def test_tables_sort_by_click_and_keyboard(report, opened):
    with opened(report, DRAWN, viewport={"width": 1300, "height": 900}) as view:
        table = view.locator("#summary table").first

        def names():
            return [n.lower() for n in table.locator("tbody tr th").all_inner_texts()]

        first = names()
        head = table.get_by_role("button", name="Median mm", exact=True)
        head.click()
        medians = table.locator("tbody tr td:nth-child(3)").all_inner_texts()
        assert medians == sorted(medians, key=float, reverse=True)
        head.focus()
        view.keyboard.press("Enter")
        again = table.locator("tbody tr td:nth-child(3)").all_inner_texts()
        assert again == medians[::-1]
        sorted_head = table.locator("th[aria-sort]")
        assert sorted_head.count() == 1
        assert sorted_head.get_attribute("aria-sort") == "ascending"
        table.get_by_role("button", name="Group", exact=True).click()
        assert names() == sorted(first)
        # What is missing stays last either way: no frame is merged here.
        assert table.locator("tfoot tr").count() == 1


@pytest.fixture(scope="module")
def both(pair, tmp_path_factory):
    """The page of two runs as a file."""
    return write_text(tmp_path_factory.mktemp("both") / "report.html", pair)


def test_on_a_phone_and_in_print(both, opened):
    scheme = "dark"
    settings = {"viewport": {"width": 390, "height": 844}, "color_scheme": scheme}
    with opened(both, DRAWN, **settings, has_touch=True) as view:
        # Nothing but the tables' own scroll areas is wider than the screen.
        assert view.evaluate("document.documentElement.scrollWidth") <= 390
        view.locator("[data-part=slider]").focus()
        assert view.evaluate(
            "getComputedStyle(document.activeElement).outlineStyle !== 'none'"
            " && document.activeElement.matches(':focus-visible')"
        )
        # Pictures open by keyboard, step, and close.
        view.locator(".shot").first.focus()
        view.keyboard.press("Enter")
        assert view.locator("#lightbox span").inner_text().endswith("seed 1, frame 0")
        view.keyboard.press("ArrowRight")
        assert view.locator("#lightbox span").inner_text().endswith("seed 1, frame 12")
        view.keyboard.press("Escape")
        assert not view.locator("#lightbox").is_visible()
        # On paper the theme is the light one, in the canvases too.
        view.emulate_media(media="print", color_scheme=scheme)
        view.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert view.evaluate("getComputedStyle(document.body).backgroundColor") == (
            "rgb(255, 255, 255)"
        )
        assert view.locator("[data-part=play]").is_hidden()


def test_every_episode_has_the_command_that_plays_it_again(episode_of, tmp_path):
    words = {"targets": ["smoke"], "seeds": None, "first_seed": 0, "only": [], "settings": []}
    request = {**words, "dataset": None, "detections": None}
    info = RunInfo("r", "thesis", detector="thesis", tracker="thesis", request=request)
    text = build_page([load(save(tmp_path / "r", [episode_of(scenario="cross")], info))])
    command = "pjpdaf-bench run smoke --only cross --first-seed 0 --seeds 1 --preset thesis"
    assert f'data-command="{command}"' in text
    assert "<dt>play the worst episode again</dt>" in text
