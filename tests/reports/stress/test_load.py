"""Folders of stress: a search and a map in the same folder each have episodes of their own."""

import shutil

from reports.stress.load import MAP_EPISODES, load_stress
from reports.stress.page import build_stress_page


def test_a_map_has_its_own_episodes_beside_those_of_a_search(stress_folder, tmp_path):
    both = tmp_path / "both"
    shutil.copytree(stress_folder, both)
    (together,) = load_stress([both])
    assert together.search
    assert together.map
    shutil.copytree(both / "episodes", both / MAP_EPISODES)
    searched, mapped = load_stress([both])
    assert (searched.map, mapped.search, mapped.estimate) == (None, None, None)
    assert mapped.map == together.map
    assert mapped.episodes is not None
    assert mapped.episodes.folder == both / MAP_EPISODES
    page = build_stress_page([searched, mapped])
    assert "#play=0-0-7" in page  # a strip
    assert "#play=1-0-7" in page  # a cell
    for name in ("failures", "estimate", "compare"):
        (both / f"{name}.json").unlink()
    (alone,) = load_stress([both])
    assert alone.map == together.map
