"""The stress page: self-contained, escaped, worked by hand in a real browser."""

from __future__ import annotations

import html
import re
import shutil

import pytest
from every_reader import faults
from waiting import until

from pjpdaf.errors import BenchError
from reports.stress.load import load_stress
from reports.stress.page import write_stress_page
from scenarios.run.report import remake_report

HOSTILE = '<script>alert("x")</script>'


@pytest.fixture(scope="module")
def page(stress_folder, tmp_path_factory):
    return write_stress_page([stress_folder], tmp_path_factory.mktemp("out") / "stress.html")


def test_it_is_self_contained_and_escapes_names(page) -> None:
    text = page.read_text(encoding="utf-8")
    assert not re.search(r"(?:https?:)?//[a-z]+\.", text)
    assert HOSTILE not in text
    assert text.count("&lt;script&gt;alert(&#34;x&#34;)&lt;/script&gt;") == 2


def test_failures_are_confirmed_first_and_the_worst_first(page) -> None:
    text = page.read_text(encoding="utf-8")
    titles = re.findall(r'<article class="failure" .*?</article>', text, re.S)
    marks = [re.findall(r'class="mark (\w+)"', title) for title in titles]
    assert marks == [["yes"], ["yes"], ["no"], ["no"]]
    assert [re.findall("not (in pictures|rendered)</span>", t) for t in titles[2:]] == [
        ["rendered"],
        ["in pictures"],
    ]
    assert "40&nbsp;% of the frames wrong" in titles[0]
    assert titles[0].count("<img") == 6
    assert "left and right exchanged</em>" in titles[0]
    # An episode that the folder does not have: no strip, no link.
    assert "<img" not in titles[2]
    assert "#play" not in titles[2]
    # The budget ended before it was known what matters, and before fresh noise.
    assert "Needs some of speed" in titles[2]
    assert "noise seeds" not in titles[2]
    assert "Needs speed" in titles[0]
    assert "7 of 8 fresh noise seeds" in titles[0]
    assert "2 of 3 tried" not in text
    assert "2 of 3 confirmed in rendered pictures" in text


def test_a_curve_counts_the_trials_that_are_in_it(page, stress_folder) -> None:
    """Not those of cells that were split: their parts have trials of their own."""
    (folder,) = load_stress([stress_folder])
    assert folder.map is not None
    counted = {sum(cell.n for cell in record.cells) for record in folder.map.maps}
    assert not counted & {record.runs for record in folder.map.maps}
    text = html.unescape(page.read_text(encoding="utf-8"))
    shown = {int(n) for n in re.findall(r"(\d+) trials \(fast\)\. Bars", text)}
    assert shown == counted - {0}


def test_probabilities_and_comparison(page) -> None:
    text = html.unescape(page.read_text(encoding="utf-8")).replace("\N{NO-BREAK SPACE}", " ")
    assert "0.12 % (0.084 to 0.47)" in text
    assert "below 0.3 %" in text
    assert "inconclusive</b>" in text
    assert "-19.0 % (-25.0 to -13.0)" in text


def test_a_damaged_file_is_one_line(stress_folder, tmp_path) -> None:
    shutil.copy(stress_folder / "map.json", tmp_path)
    path = tmp_path / "map.json"
    path.write_text(path.read_text(encoding="utf-8").replace('"swap": 8', '"swap": -8', 1))
    with pytest.raises(BenchError) as fault:
        write_stress_page([tmp_path], tmp_path / "stress.html")
    assert str(fault.value) == (
        f"{path}: is damaged or of another version at maps.0.cells.17.failures.swap: Input should "
        "be greater than or equal to 0."
    )
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(BenchError, match="is no folder of a stress run"):
        write_stress_page([empty], tmp_path / "stress.html")


def test_a_click_on_a_cell_and_on_a_strip_plays_the_episode(page, opened) -> None:
    with opened(page, "html[data-thumbs=yes]", viewport={"width": 1200, "height": 800}) as view:
        view.click("#maps figure a rect.cell")
        view.wait_for_selector("#player[data-key='0-0-7'][data-frame='8']")
        view.click(".strip li:last-child a")
        view.wait_for_selector("#player[data-key='0-0-7']:not([data-frame='8'])")
        view.click("#curves figure a")
        view.wait_for_selector("#player[data-key='0-1-8']")
        # Red of the line from an estimate to its own truth.
        red = view.evaluate(
            """() => { const c = document.querySelector('[data-part=left]');
            const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0;
            for (let i = 0; i < d.length; i += 4) n += d[i] > 220 && d[i+1] < 60 && d[i+2] < 60;
            return n; }"""
        )
        assert red > 200


def test_no_word_hides_a_picture_of_a_strip(page, opened) -> None:
    with opened(page, "html[data-thumbs=yes]", viewport={"width": 390, "height": 800}) as view:
        overlaps = view.evaluate(
            """() => [...document.querySelectorAll('.strip a')].map((a) => {
            const end = a.querySelector('img').getBoundingClientRect().bottom;
            const words = [...a.querySelectorAll('span, em')];
            return Math.min(...words.map((w) => w.getBoundingClientRect().top)) - end; })"""
        )
    assert overlaps
    assert min(overlaps) >= 0


def test_the_names_of_the_lanes_are_whole(page, opened) -> None:
    """Also in a font that is far wider than those of this machine."""
    with opened(page, "html[data-thumbs=yes]", viewport={"width": 1200, "height": 800}) as view:
        view.evaluate(
            """() => {
            const write = CanvasRenderingContext2D.prototype.fillText;
            window.starts = [];
            CanvasRenderingContext2D.prototype.fillText = function (text, x, y, most = Infinity) {
                if (this.textAlign === 'right' && /[a-z]{4}/.test(text)) {
                    this.letterSpacing = '9px';
                    window.starts.push(x - Math.min(this.measureText(text).width, most));
                    this.letterSpacing = '0px';
                }
                write.call(this, text, x, y);
            }; }"""
        )
        view.click(".strip li:last-child a")
        until(view, "() => window.starts.length > 0")
        assert view.evaluate("Math.min(...window.starts)") >= 0


def test_several_folders_go_on_one_page(stress_folder, tmp_path) -> None:
    other = tmp_path / "other"
    other.mkdir()
    text = (stress_folder / "estimate.json").read_text(encoding="utf-8")
    (other / "estimate.json").write_text(text.replace('"system": "thesis"', '"system": "default"'))
    page = remake_report([stress_folder, other], tmp_path / "both.html")
    heads = re.findall(r"P\((?:swap|lost)\)<br>\w+", page.read_text(encoding="utf-8"))
    assert heads == [f"P({g})<br>{s}" for s in ("thesis", "default") for g in ("swap", "lost")]
    with pytest.raises(BenchError, match="no page shows beside runs of other verbs"):
        remake_report([stress_folder / "episodes", stress_folder], tmp_path / "mixed.html")


def test_a_stress_run_that_has_not_ended_is_told_so(tmp_path) -> None:
    (tmp_path / "journal.bin").write_bytes(b"")
    with pytest.raises(BenchError, match="is a stress run that has not ended, or of a verb with"):
        remake_report([tmp_path], None)


def test_it_is_for_every_reader(page, opened) -> None:
    with opened(page, "html[data-thumbs=yes]") as view:
        assert faults(view) == []
