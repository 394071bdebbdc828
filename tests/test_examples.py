"""The examples that try variants of `default`: their parameters exist, their tables add up."""

from pathlib import Path

import pytest

from pjpdaf.presets.override import override
from pjpdaf.presets.registry import find_preset
from scenarios.play.footage import open_footage
from scenarios.play.job import Job, System
from scenarios.spec.names import load_scenario

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.fixture
def examples(monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    import ablation
    import ceilings
    import replays

    return ablation, ceilings, replays


def test_each_part_is_removed_by_parameters_that_change_something(examples):
    ablation, _, _ = examples
    preset = find_preset("default")
    for part in (*ablation.DETECTOR, *ablation.TRACKER):
        changed = override(preset, part.off)
        assert (changed.detector, changed.tracker) != (preset.detector, preset.tracker), part.name
    names = [variant.name for variant in ablation.VARIANTS]
    assert len(set(names)) > len(ablation.DETECTOR) + len(ablation.TRACKER)


def test_variants_of_one_detector_share_its_detections_and_differ_in_their_tracks(examples):
    ablation, ceilings, replays = examples
    changes = {"frames": 5, "background_frames": 10}
    job = Job(load_scenario("cross"), 101, changes, System(), size_px=(160, 120))
    palm = ablation.of_tracker("no palm", {"palm": "0"})
    with open_footage(job) as footage:
        found = replays.results(job, footage, (ablation.WHOLE, palm, ceilings.VARIANTS[-1]), 4)
    assert [result.target_frames for result in found] == [12, 12, 12]
    assert [result.variant for result in found] == ["default", "no palm", "perfect prediction"]
    assert len({result.hands_mm for result in found}) == 3


def test_the_table_has_shares_and_paired_changes_of_each_group(examples, capsys, tmp_path):
    ablation, _, replays = examples
    found = []
    for seed in range(8):
        for name, within in (("default", 90 + seed % 2), ("worse", 60 + seed % 2)):
            found.append(
                replays.Result(
                    name, "cross", "hands", seed, 100, within, 9.0, 12.5, seed == 0, False
                )
            )
    replays.write(tmp_path / "results.jsonl", found)
    found = replays.read(tmp_path / "results.jsonl")
    worse = ablation.of_tracker("worse", {})
    ablation.table("Title", ablation.WHOLE, (worse,), found)
    text = capsys.readouterr().out
    assert "hands, n = 8" in text
    assert "| default | 90.5 (" in text
    assert "| worse | **-30.0 (-30.0 to -30.0)** |" in text
    assert "| worse | 9.0 / 12.5, 1, 0 |" in text
