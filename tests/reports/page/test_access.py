"""The page for every reader: WCAG 2.2 AA by axe-core, a phone, a desk, paper, the search box."""

import re

import pytest
from every_reader import unprinted, violations, widest

from reports.gate.gate import compare
from reports.page.page import build_page, write_page
from reports.run.load import load
from reports.run.save import RunInfo, save

DRAWN = "html[data-thumbs=yes]"
LONG_NAME = "a_scenario_whose_name_is_as_long_as_any"


@pytest.fixture(scope="module")
def runs(episode_of, tools, tmp_path_factory):
    """A run in which nothing went wrong, and one of the same seeds with a swap."""
    base = tmp_path_factory.mktemp("access")
    centres = tools.paths(24, 3.0)
    swapped = tools.noisy(centres, 1)
    swapped[8:] = swapped[8:][:, [0, 2, 1]]

    def played(hands):
        return [
            episode_of(tools.noisy(centres, 0), centres_m=centres, scenario="calm", group="easy"),
            episode_of(hands, centres_m=centres, scenario=LONG_NAME, group="hand_and_hand", seed=3),
        ]

    good = load(save(base / "good", played(tools.noisy(centres, 1)), RunInfo("good")))
    bad = load(save(base / "bad", played(swapped), RunInfo("bad", preset="thesis")))
    return good, bad


@pytest.fixture(scope="module")
def report(runs, tmp_path_factory):
    """The page of the bad run, judged against the good one, as a file."""
    good, bad = runs
    path = tmp_path_factory.mktemp("report") / "report.html"
    return write_page([bad], path, verdict=compare(good, bad))


def test_on_a_desk(report, opened):
    desk = {"width": 1440, "height": 900}
    with opened(report, DRAWN, viewport=desk) as view:
        # Five columns, the others on demand; all of them fit.
        row = view.locator("#by-scenario tbody tr").first
        assert row.locator("td:visible").count() == 4
        view.locator("[aria-controls=by-scenario]").click()
        assert row.locator("td:visible").count() == 17
        assert widest(view, "html, .scroll") <= 0
        # The search finds scenarios, episodes and events, and leads there by keyboard.
        box = view.get_by_role("combobox", name="Search")
        box.fill("as long")
        kinds = view.locator("#search-results small").all_inner_texts()
        assert [kinds[0], kinds[1], kinds[-1]] == ["scenario", "episode", "event"]
        box.fill("swapped seed 3")
        view.keyboard.press("ArrowDown")  # from the episode to its event
        view.keyboard.press("Enter")
        view.wait_for_selector('#player[data-key="0-0-3"][data-frame="8"]')
        assert view.evaluate("location.hash") == "#play=0-0-3@8"
        box.fill("nobody")
        assert view.get_by_role("status").filter(has_text="Nothing of that name").is_visible()
        view.keyboard.press("Escape")
        assert box.input_value() == ""
        # Paper has all that is folded, the screen does not afterwards.
        closed = "document.querySelectorAll('details:not([open]), .more[aria-expanded=false]')"
        before = view.evaluate(f"{closed}.length")
        assert before > 3
        view.evaluate(f"addEventListener('beforeprint', () => {{ window.shut = {closed}.length }})")
        assert view.pdf(format="A4").startswith(b"%PDF")
        assert view.evaluate("window.shut") == 0
        assert view.evaluate(f"{closed}.length") == before
        assert unprinted(view) == []
        view.set_viewport_size(desk)
        view.emulate_media(media="screen", reduced_motion="reduce")
        assert violations(view) == []
        assert widest(view, "html, .scroll") <= 0


def test_on_a_phone_in_the_dark(report, opened):
    settings = {"viewport": {"width": 390, "height": 844}, "color_scheme": "dark"}
    with opened(report, DRAWN, **settings) as view:
        # A card for each row; the roles of a table stay, whatever the style makes of it.
        cells = view.locator("#by-scenario tbody tr").first.locator("td:visible")
        label = "c => getComputedStyle(c, '::before').content"
        assert cells.first.evaluate(label) == '"Within 100 mm"'
        assert len(set(cells.evaluate_all("c => c.map(x => x.offsetTop)"))) > 1
        assert view.get_by_role("rowheader", name=LONG_NAME).count() > 0
        assert violations(view) == []
        assert widest(view, "html, .scroll:has(.as-cards)") <= 0


def test_the_gate_is_on_the_first_screen(runs, report):
    text = report.read_text(encoding="utf-8")
    first = text.partition("</header>")[0]
    assert 'class="gate none"><a href="#gate">Gate undecided: ' in first
    gate = text.partition('id="gate"')[2].partition("</section>")[0]
    assert re.search(rf"{LONG_NAME}, seed 3: (at least )?\+", gate)
    assert "why: 2 episodes of " in gate
    same = build_page([runs[0]], verdict=compare(runs[0], runs[0]))
    assert "Gate passed: the same results as the base, bit for bit" in same


def test_nothing_bad_is_not_listed_as_worst(runs):
    text = build_page([runs[0]])
    assert "Nothing went wrong in 2 episodes" in text.partition("</header>")[0]
    failures = text.partition('id="failures"')[2].partition("</section>")[0]
    assert "Nothing went wrong" in failures
    assert "canvas" not in failures
