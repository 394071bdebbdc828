"""`dataset show`: sheet, page and recording in their places, or one line that says why not."""

import re
import sys

import cv2
import pytest

from pjpdaf.errors import BenchError, InfrastructureError
from scenarios.dataset.sequence_plan import sequence_entry
from scenarios.dataset.sequence_task import write_recipe
from scenarios.dataset.show import ShowDatasetRequest, show_dataset
from scenarios.play.job import Job, System
from scenarios.play.recipe import Recipe, SequenceSettings
from scenarios.spec.names import load_scenario
from sim.dataset.files.manifest import manifest_record, write_manifest

SETTINGS = SequenceSettings(("depth", "seg"), (96, 72))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Three sequences, of which the second is not finished."""
    folder = tmp_path_factory.mktemp("show") / "set"
    folder.mkdir()
    entries = []
    for index, frames in enumerate((4, 4, 14)):
        changes = {"frames": frames, "background_frames": 1}
        job = Job(load_scenario("cross"), 100 + index, changes, System(), label="cross")
        recipe = Recipe(job, SETTINGS)
        entries.append(sequence_entry(index, recipe))
        if index != 1:
            (folder / entries[-1].folder).mkdir()
            write_recipe(recipe, folder / entries[-1].folder)
    write_manifest(folder, manifest_record(entries, SETTINGS.record(), {}, complete=False))
    return folder


def files(folder):
    return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())


def test_sheet_and_page_lie_in_a_new_folder_beside_the_data_set(made, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    beside = made.with_name("set-show")
    before = files(made)
    said = show_dataset(ShowDatasetRequest(made))
    assert re.fullmatch(
        rf"sheet: {beside}/sheet\.png \(2 sequences\)\n"
        rf"page: {beside}/page\.html \(2 sequences, \d\.\d MB\)",
        said,
    )
    assert files(tmp_path) == []
    assert files(beside) == ["page.html", "sheet.png"]
    assert "<title>set</title>" in (beside / "page.html").read_text()
    assert files(made) == before
    with pytest.raises(BenchError, match=r"set-show/sheet\.png: exists; give another name"):
        show_dataset(ShowDatasetRequest(made))


def test_a_file_name_chooses_one_of_them(made, tmp_path):
    assert show_dataset(ShowDatasetRequest(made, tmp_path / "a.png")).startswith("sheet: ")
    assert show_dataset(ShowDatasetRequest(made, tmp_path / "b.HTML")).startswith("page: ")
    assert files(tmp_path) == ["a.png", "b.HTML"]
    picture = cv2.imread(str(tmp_path / "a.png"))
    assert picture.std() > 20


def test_one_sequence_alone_has_more_frames_on_the_sheet(made, tmp_path):
    for number, name in ((None, "all"), (2, "one")):
        show_dataset(ShowDatasetRequest(made, tmp_path / name, number))
    sheets = [cv2.imread(str(tmp_path / name / "sheet.png")) for name in ("all", "one")]
    heights = [sheet.shape[0] for sheet in sheets]
    assert heights[1] > 2.5 * heights[0]  # twelve frames, two a row; before two rows
    page = (tmp_path / "one" / "page.html").read_text()
    assert "<title>set, seq_000002</title>" in page
    assert page.count('id="sequence-') == 1
    assert "<dd>14</dd>" in page


def test_what_cannot_be_shown_is_said_and_leaves_nothing(made, tmp_path):
    out = tmp_path / "x.png"
    with pytest.raises(BenchError, match=r"--sequence 1: the data set has 0 to 2, some of them"):
        show_dataset(ShowDatasetRequest(made, out, sequence=1))
    with pytest.raises(BenchError, match="lies inside the data set"):
        show_dataset(ShowDatasetRequest(made, made / "sheet.png"))
    with pytest.raises(BenchError, match="lies inside the data set"):
        show_dataset(ShowDatasetRequest(made, made / "new"))
    assert not (made / "new").exists()
    with pytest.raises(BenchError, match="Make its folder first"):
        show_dataset(ShowDatasetRequest(made, tmp_path / "no" / "sheet.png"))
    with pytest.raises(BenchError, match="is not a data set"):
        show_dataset(ShowDatasetRequest(tmp_path, out))
    with pytest.raises(BenchError, match=r"must end in \.rrd"):
        show_dataset(ShowDatasetRequest(made, rerun=tmp_path / "x.mp4"))
    write_manifest(tmp_path, manifest_record([], SETTINGS.record(), {}, complete=False))
    with pytest.raises(BenchError, match="no finished sequence"):
        show_dataset(ShowDatasetRequest(tmp_path, out))
    assert files(tmp_path) == ["manifest.json"]


def test_a_damaged_picture_is_named_and_nothing_is_left(made, tmp_path):
    path = made / "seq_000000" / "depth_left" / "000001.png"
    before = path.read_bytes()
    path.write_bytes(before[:200])
    try:
        with pytest.raises(BenchError, match=r"seq_000000/depth_left/000001\.png: is a damaged"):
            show_dataset(ShowDatasetRequest(made, tmp_path / "a.html"))
    finally:
        path.write_bytes(before)
    assert files(tmp_path) == []


def test_without_rerun_it_says_how_to_get_it(made, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rerun", None)  # as where it is not installed
    with pytest.raises(InfrastructureError, match=r"pip install 'pjpdaf-bench\[viz\]'"):
        show_dataset(ShowDatasetRequest(made, rerun=tmp_path / "x.rrd"))
    assert files(tmp_path) == []
