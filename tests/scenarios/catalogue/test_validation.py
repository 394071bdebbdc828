"""The line of `scenarios validate`, and what only the plan of a script can tell."""

from __future__ import annotations

from pathlib import Path

import pytest
from scripts import script_text

from pjpdaf.errors import BenchError
from scenarios.catalogue.validation import validated

ROOT = Path(__file__).parents[3]


def test_a_sound_script_says_how_long_it_is(tmp_path):
    file = tmp_path / "mine.yaml"
    rest = "{who: right, do: reach, to: {table: [0.4, 0.15, 0.1]}, duration: 1 s, hold: 2 s}"
    file.write_text(script_text([rest], frames=30))
    assert validated(file).endswith("parameters; 1 step, over at 4.1 s of 10.0 s)")
    file.write_text(script_text([rest], frames=9))
    assert validated(file).endswith("1 step, over at 4.1 s of 3.0 s: the end is cut off)")


def test_what_the_plan_finds_begins_with_its_place(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(script_text(["{who: right, do: reach, to: {table: [0.4, 0.9, 0.2]}}"]))
    with pytest.raises(BenchError) as fault:
        validated(file)
    assert str(fault.value).startswith(f"{file}:12:7: motion.steps.0: at ")


@pytest.mark.parametrize("path", sorted((ROOT / "examples" / "motion").glob("*.yaml")), ids=str)
def test_the_examples_are_sound_and_whole(path):
    told = validated(path)
    assert "over at" in told
    assert "cut off" not in told
