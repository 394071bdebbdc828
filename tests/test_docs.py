"""The documentation names files that exist."""

import re
from pathlib import Path

import pytest

from sim.families.gestures.gesture import Quantity
from sim.families.gestures.registry import GESTURES

ROOT = Path(__file__).parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")])
OF_TODAY = [page for page in PAGES if page.name != "CHANGELOG.md"]  # that names files of its time
PACKAGES = "pjpdaf|sim|reports|scenarios|tests|docs|examples"


@pytest.mark.parametrize("page", OF_TODAY, ids=lambda page: page.name)
def test_every_path_in_the_documentation_exists(page):
    text = page.read_text(encoding="utf-8")
    paths = re.findall(rf"`((?:{PACKAGES})/[\w./-]*)`", text)
    missing = [path for path in paths if not (ROOT / path).exists()]
    assert not missing


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_relative_link_leads_to_a_file(page):
    links = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
    own = [link for link in links if "://" not in link and not link.startswith("mailto:")]
    missing = [link for link in own if not (page.parent / link).exists()]
    assert not missing


def test_the_gallery_shows_every_case_of_the_corpus():
    text = (ROOT / "docs" / "stress_failures.md").read_text(encoding="utf-8")
    shown = re.findall(r"^!\[(\w+)\]\(pictures/stress/\1\.jpg\)$", text, flags=re.MULTILINE)
    cases = sorted(path.stem for path in (ROOT / "scenarios" / "corpus").glob("*.yaml"))
    assert sorted(shown) == cases
    pictures = sorted(path.stem for path in (ROOT / "docs" / "pictures" / "stress").glob("*.jpg"))
    assert pictures == cases


def test_the_table_of_gestures_has_every_gesture_with_all_its_fields():
    text = (ROOT / "docs" / "own_motion.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \| [a-z, ]+ \| (.*) \|$", text, flags=re.MULTILINE))
    for name, gesture in GESTURES.items():
        assert rows[name].startswith(gesture.meaning)
        for field in gesture.fields:
            default = getattr(field, "default", None)
            shown = f"`{field.name}`"
            if isinstance(field, Quantity) and default is not None:
                shown += f" {default:g}"
            assert shown in rows[name], (name, field.name)
