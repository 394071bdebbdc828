"""The catalogue as pages with pictures."""

import pytest
from commands import bench, in_this_process

from scenarios.catalogue import pages as gallery
from scenarios.spec.names import scenario_names


def test_only_pages_of_ours_are_replaced(tmp_path):
    readme = tmp_path / "README.md"
    readme.write_text("mine")
    done = in_this_process("scenarios", "list", "--markdown", readme)
    assert done.returncode == 2
    assert "is not a catalogue page" in done.stderr
    assert readme.read_text() == "mine"
    readme.write_text(f"<!-- {gallery.MARK} -->\n")
    gallery.check_replaceable(readme)
    gallery.check_replaceable(tmp_path / "new.html")


@pytest.mark.long
def test_the_whole_catalogue_is_drawn(tmp_path):
    page, text = tmp_path / "all.html", tmp_path / "docs/all.md"
    text.parent.mkdir()
    done = bench("scenarios", "list", "--html", page, "--markdown", text, "--jobs", 4)
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"catalogue: {page}\ncatalogue: {text}\n"
    pictures = sorted((tmp_path / "docs/pictures/all").iterdir())
    assert [file.stem for file in pictures] == list(scenario_names())
    assert max(file.stat().st_size for file in pictures) <= 12_000
    for name in scenario_names():
        assert f'id="scenario-{name}"' in page.read_text()
        assert f"](pictures/all/{name}.jpg)" in text.read_text()
    assert sorted(f.name for f in tmp_path.iterdir()) == ["all.html", "docs"]
