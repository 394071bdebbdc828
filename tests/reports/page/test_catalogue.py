"""The catalogue: whole, escaped, and readable in a real browser."""

import re

import numpy as np
import pytest
from every_reader import faults
from waiting import until

from reports.page.catalogue import (
    Catalogue,
    ScenarioCard,
    SuiteCard,
    catalogue_markdown,
    catalogue_page,
)
from reports.page.templating import write_text

HOSTILE = '<script>alert("x")</script>&{{ 7*7 }}'


MARK = "pjpdaf-bench scenarios list"


def card(name, group="baseline", **changes):
    picture = np.full((160, 324, 3), 90, np.uint8)
    values = {
        "summary": "One hand reaches.",
        "frames": 48,
        "fps": 3.0,
        "rates": (),
        "thesis": "",
        "parameters": 29,
        "picture": picture,
        "caption": "frame 12 (4.0 s), reach",
    }
    return ScenarioCard(name=name, group=group, **values | changes)


@pytest.fixture(scope="module")
def catalogue():
    cards = [card(f"calm_{i}") for i in range(4)]
    cards.append(card("drink", "hand_and_head", thesis="Fig. 4.4, 4.5", summary=HOSTILE))
    cards.append(card("fps_ladder", "fast", rates=(1.0, 30.0)))
    suites = (
        SuiteCard(
            "smoke", "A first look | with a bar.", 1, (("calm_0", "calm_0"), ("d@2", "drink"))
        ),
        SuiteCard("own", "Of files.", 3, (("mine.yaml", "mine.yaml"),)),
    )
    return Catalogue(tuple(cards), suites)


@pytest.fixture(scope="module")
def page(catalogue):
    return catalogue_page(catalogue, MARK)


def test_the_page_says_everything_of_a_scenario(page):
    assert page.count('class="entry"') == 6
    assert page.count("data:image/jpeg;base64,") == 6
    for words in (
        "6 scenarios in 3 groups, 2 suites",
        "48 frames at 3 a second",
        "played at 1, 30 a second",
        "Fig. 4.4, 4.5",
        "Hand and head",
        '<a href="#scenario-drink">d@2</a>',
        "frame 12 (4.0 s), reach",
    ):
        assert words in page, words
    assert 'href="#scenario-mine.yaml"' not in page  # nothing to go to
    assert MARK in page[:2000]  # so that it may be replaced


def test_every_picture_has_words_in_its_stead(page):
    images = re.findall(r"<img [^>]*>", page)
    assert len(images) == 6
    assert all(re.search(r'alt="Left and right view of \w+, frame 12', image) for image in images)


def test_it_is_escaped_and_needs_no_network(page):
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert" in page
    assert "{{ 7*7 }}" in page  # never evaluated
    for attribute in re.findall(r'(?:src|href)="([^"]*)"', page):
        assert attribute.startswith(("#", "data:")), attribute[:60]
    assert "url(" not in page
    assert "@import" not in page


def test_links_lead_somewhere(page):
    places = set(re.findall(r' id="([^"]+)"', page))
    assert set(re.findall(r'href="#([^"]+)"', page)) <= places


def test_same_catalogue_same_page(catalogue, page):
    assert catalogue_page(catalogue, MARK) == page


def test_markdown_has_relative_pictures_and_escapes(catalogue):
    text = catalogue_markdown(catalogue, MARK, "docs/catalogue.md", "pictures/catalogue")
    assert text.startswith(f"<!-- {MARK} -->\n# Scenario catalogue\n")
    assert "`pjpdaf-bench scenarios list --markdown docs/catalogue.md`" in text
    assert re.findall(r"\]\((pictures/catalogue/[^)]+)\)", text) == [
        f"pictures/catalogue/{name}.jpg"
        for name in ("calm_0", "calm_1", "calm_2", "calm_3", "drink", "fps_ladder")
    ]
    assert "\\<script\\>" in text
    assert (
        "| `smoke` | A first look \\| with a bar. | 1 | [calm_0](#calm_0), [d@2](#drink) |" in text
    )
    assert "**Thesis: Fig. 4.4, 4.5.**" in text
    assert text.count("### ") == 6
    assert text.count("\n## ") == 4


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_browser_shows_it_without_network(page, opened, tmp_path, scheme):
    path = write_text(tmp_path / "catalogue.html", page)
    phone = scheme == "dark"
    settings = {"viewport": {"width": 390 if phone else 1300, "height": 900}}
    with opened(path, "#suites", ("file:", "data:"), **settings, color_scheme=scheme) as view:
        loaded = "[...document.images].every(i => i.complete && i.naturalWidth === 324)"
        assert view.evaluate(loaded)
        paper = view.evaluate("getComputedStyle(document.body).backgroundColor")
        light = sum(map(int, re.findall(r"\d+", paper)[:3])) > 380
        assert light == (scheme == "light")
        # One column on a phone, several on a desk; nothing wider than the screen on either.
        tops = view.locator(".entry").evaluate_all("c => c.map(x => Math.round(x.offsetTop))")
        assert (len(set(tops[:4])) == 4) == phone
        width = view.evaluate("document.documentElement.scrollWidth")
        assert width <= view.evaluate("innerWidth")
        # The bar stays on top of the page and must not hide it.
        assert view.locator(".topbar").bounding_box()["height"] < 110
        # By keyboard: skip link first, then the groups, then a suite's scenario.
        view.keyboard.press("Tab")
        assert view.evaluate("document.activeElement.textContent") == "Skip to the content"
        view.keyboard.press("Tab")
        assert view.evaluate("document.activeElement.textContent").startswith("Baseline")
        view.locator("#search").fill("hand head")
        view.keyboard.press("Enter")
        until(view, "() => location.hash === '#scenario-drink'")
        assert view.locator("#scenario-drink").is_visible()
        # On paper: no card is cut in two, all of them are there.
        view.emulate_media(media="print")
        assert view.locator(".entry").first.evaluate("c => getComputedStyle(c).breakInside") == (
            "avoid"
        )
        assert not view.locator("nav").is_visible()
        assert view.pdf(format="A4").startswith(b"%PDF")


def test_it_is_for_every_reader(page, opened, tmp_path):
    path = write_text(tmp_path / "catalogue.html", page)
    with opened(path, "#suites") as view:
        assert faults(view) == []
