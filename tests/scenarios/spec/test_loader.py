"""Scenario files: each fault one line, spelled out, at its place."""

# ruff: noqa: E501 - messages are spelled out on one line, as the user sees them

from __future__ import annotations

import json
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pjpdaf.errors import BenchError
from scenarios.spec.loader import (
    MAX_BYTES,
    load_either_file,
    load_scenario_file,
    load_suite_file,
    parse,
)
from scenarios.spec.motion.kinds import KINDS
from scenarios.spec.names import scenario_names
from scenarios.spec.scenario import Scenario
from scenarios.spec.schema import json_schema
from scenarios.spec.suite import Suite
from sim.families.registry import FAMILIES

GOOD = """\
name: mine
group: hand_and_head
family: drink
summary: Mine.
frames: 30
motion: {kind: drink}
parameters:
  hand: {choices: [right, left]}
  speed: {unit: m/s, range: [0.4, 0.8], nominal: {kind: uniform}}
  wait:
    unit: s
    range: [0, 5]
    nominal: {kind: normal, mean: 2, sd: 0.5}
  hold: {unit: s, range: [1, 4], nominal: {kind: uniform}}
  tilt: {unit: rad, range: [0.4, 1.1], nominal: {kind: fixed, value: 0.8}}
  can_x: {unit: m, range: ["32 cm", 0.46], nominal: {kind: uniform, low: "370 mm", high: 0.4 m}}
  can_y: {unit: m, range: [0, 0.2], nominal: {kind: uniform, low: 0.02, high: 0.07}}
  put_dx: {unit: m, range: [-0.05, 0.06], nominal: {kind: uniform}}
  put_dy: {unit: m, range: [-0.05, 0.08], nominal: {kind: uniform}}
"""


def load(text, tmp_path):
    file = tmp_path / "file.yaml"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    try:
        load_scenario_file(file)
    except BenchError as fault:
        return str(fault).replace(str(file), "file.yaml")
    return "ok"


def test_a_good_file_loads_and_text_with_units_becomes_numbers(tmp_path):
    file = tmp_path / "file.yaml"
    file.write_text(GOOD)
    scenario = load_scenario_file(file)
    assert scenario.parameters["can_x"].range == (0.32, 0.46)
    assert scenario.parameters["can_x"].bounds == pytest.approx((0.37, 0.4))
    assert scenario.fps == 3.0
    assert "stature" in scenario.parameters


def test_a_file_read_again_is_the_same_and_another_once_it_has_changed(tmp_path):
    # Its YAML is read once: stress asks for it with each of thousands of trials.
    path = tmp_path / "mine.yaml"
    path.write_text(GOOD)
    first = load_scenario_file(path)
    assert load_scenario_file(path) == first
    path.write_text(GOOD.replace("frames: 30", "frames: 31"))
    assert load_scenario_file(path).frames == first.frames + 1


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("  wait:\n    unit: s", "  wait:\n    unti: s", "11:5: parameters.wait.unti: no such field; did you mean unit?"),
        ("group:", "gruop:", "2:1: gruop: no such field; did you mean group?"),
        ("mean: 2", "men: 2", "13:29: parameters.wait.nominal.men: no such field; did you mean mean?"),
        ("frames: 30", "frames: 30\nframes: 31", "6:1: frames: is given twice"),
        ("frames: 30", "frames: many", "5:1: frames: must be a whole number, got 'many'"),
        ("frames: 30", "frames: true", "5:1: frames: must be a whole number, got true"),
        ("frames: 30", "frames: 0", "5:1: frames: must be at least 1, got 0"),
        ("frames: 30", "frames: 30\nfps: 31", "6:1: fps: must be at most 30, got 31"),
        ("frames: 30", "frames: 30\nfps: .nan", "6:1: fps: must be finite, got nan"),
        ("frames: 30\n", "", "1:1: frames: is missing"),
        ("frames: 30", "frames: 30\nsurroundings: varid", "6:1: surroundings: must be one of nominal, varied, got 'varid'; did you mean varied?"),
        ("frames: 30", "frames: 30\nsurroundings: varied\nrooms: here", "ok"),
        ("frames: 30", "frames: 30\nrooms: here", "6:1: rooms: goes with `surroundings: varied`"),
        ("  hand:", "  wall: {choices: [brick]}\n  hand:", "8:3: parameters.wall: goes with `surroundings: varied`"),
        ("frames: 30\nmotion: {kind: drink}\nparameters:\n", "frames: 30\nsurroundings: varied\nmotion: {kind: drink}\nparameters:\n  wall: {choices: [bricks]}\n", "9:10: parameters.wall.choices: must be among paint, wallpaper, brick, panel, got 'bricks'; did you mean brick?"),
        ("frames: 30\nmotion: {kind: drink}\nparameters:\n", "frames: 30\nsurroundings: varied\nmotion: {kind: drink}\nparameters:\n  table_depth: {unit: m, range: [0.1, 0.9], nominal: {kind: uniform}}\n", "9:26: parameters.table_depth.range: must lie within 0.6 to 0.95"),
        ("frames: 30", "frames: [1]", "5:1: frames: must be a whole number, got a list"),
        ("summary: Mine.", "summary:", "4:1: summary: must be text, got nothing"),
        ("summary: Mine.", "summary: 2026-01-01", "ok"),
        ("name: mine", "name: My Name", "1:1: name: must be lower-case letters, digits and _, beginning with a letter, got 'My Name'"),
        ("{kind: drink}", "{kind: drnik}", f"6:10: motion.kind: must be one of {', '.join(KINDS)}, got 'drnik'; did you mean drink?"),
        ("{kind: drink}", "drink", "6:1: motion: must be a mapping, got 'drink'"),
        ("unit: m/s,", "unit: mph,", "9:11: parameters.speed.unit: must be one of m, cm, mm, m/s, cm/s, mm/s, km/h, s, ms, rad, deg, px, grey, Hz, K, EV, 1, %, got 'mph'"),
        ("[0.4, 0.8]", "[0.8, 0.4]", "9:22: parameters.speed.range: range is reversed: 0.8 is greater than 0.4"),
        ("[0.4, 0.8]", "[0.4, .inf]", "9:35: parameters.speed.range.1: must be finite, got inf"),
        ("[0.4, 0.8]", "[0.4]", "9:22: parameters.speed.range.1: is missing"),
        ("[0.4, 0.8]", "[0.4, 0.8, 0.9]", "9:22: parameters.speed.range: takes at most 2 of them, got 3"),
        ("[0.4, 0.8]", "0.4", "9:22: parameters.speed.range: must be a list, got 0.4"),
        ("[0.4, 0.8]", "[0.4 s, 0.8]", "9:30: parameters.speed.range.0: must be in m/s, cm/s, mm/s, km/h, got unit 's'"),
        ("[0.4, 0.8]", "[fast, 0.8]", "9:30: parameters.speed.range.0: must be a number in m/s, got 'fast'"),
        ("sd: 0.5", "sd: 0", "13:38: parameters.wait.nominal.sd: must be greater than 0, got 0"),
        ("mean: 2", "mean: 7", "13:29: parameters.wait.nominal.mean: 7 is outside the range 0 to 5 s"),
        ("value: 0.8", "value: 8", "15:63: parameters.tilt.nominal.value: 8 is outside the range 0.4 to 1.1 rad"),
        ("low: 0.02, high: 0.07", "low: 0.07, high: 0.02", "17:62: parameters.can_y.nominal.low: low 0.07 is greater than high 0.02"),
        ("{kind: normal,", "{kind: nromal,", "13:5: parameters.wait.nominal: must be one of uniform, log-uniform, normal, fixed, got 'nromal'; did you mean normal?"),
        ("{kind: normal, ", "{", "13:5: parameters.wait.nominal: needs a field kind: uniform, log-uniform, normal or fixed"),
        ("[right, left]", "[]", "8:10: parameters.hand.choices: needs at least 1 of them, got 0"),
        ("[right, left]", "[right, left], weights: [1]", "8:34: parameters.hand.weights: 1 weights for 2 choices"),
        ("  tilt:", "  titl:", "15:3: parameters.titl: drink has no such parameter; did you mean tilt?"),
        ("  hand: {choices: [right, left]}\n", "", "7:1: parameters: drink needs the parameter hand"),
        ("  hand:", "  stature: {unit: s, range: [1, 2], nominal: {kind: uniform}}\n  hand:", "8:13: parameters.stature.unit: unit must be m"),
        ("name: mine", "name: &a mine", "1:7: anchors and aliases (& and *) are not allowed"),
        ("name: mine", "name: *a", "1:7: anchors and aliases (& and *) are not allowed"),
        ("name: mine", "name: !!python/object:os.system mine", "1:7: name: tags are not allowed, got !!python/object:os.system"),
        ("frames: 30", "frames: !odd 30", "5:9: frames: tags are not allowed, got !odd"),
        ("name: mine", "? [a]\n: mine", "1:3: a field's name must be a word"),
        ("name: mine", "name: [mine", "2:6: is not YAML: "),
        ("name: mine", "name: mine\n\tgroup: x", "2:1: is not YAML: "),
        ("name: mine", "%YAML 9.9 x\n---\nname: mine", "1:"),
    ],
)  # fmt: skip
def test_each_fault_is_one_line_at_its_place(old, new, message, tmp_path):
    assert old in GOOD
    said = load(GOOD.replace(old, new, 1), tmp_path)
    if message == "ok":
        assert said == "ok"
    elif message.endswith((": ", ":")):
        assert said.startswith(f"file.yaml:{message}")
    else:
        assert said == f"file.yaml:{message}"
    assert "\n" not in said


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "file.yaml:1:1: must be a mapping of fields, got nothing"),
        ("# only a comment\n", "file.yaml:1:1: must be a mapping of fields, got nothing"),
        ("- a\n- b\n", "file.yaml:1:1: must be a mapping of fields, got a list"),
        ("42", "file.yaml:1:1: must be a mapping of fields, got 42"),
        (b"name: \xff\xfe", "file.yaml:1:7: is not UTF-8 text"),
        (b"a: 1\nb: \xe9\n", "file.yaml:2:4: is not UTF-8 text"),
        ("[" * 5000, "file.yaml:1:31: is nested deeper than 30 levels"),
        ("{a: " * 5000, "file.yaml:1:121: is nested deeper than 30 levels"),
        ("#" * (MAX_BYTES + 1), "file.yaml: is larger than 1 MiB"),
        ("a: 1\n---\nb: 2\n", "file.yaml:2:1: is not YAML: but found another document"),
        ("a: 1\nb: x\x00y\n", "file.yaml:2:5: is not YAML: special characters are not allowed"),
        ("frames: " + "9" * 5000, "file.yaml:1:9: frames: cannot be read as a number"),
    ],
)
def test_files_that_are_no_scenario_at_all(text, message, tmp_path):
    assert load(text, tmp_path) == message


def test_missing_files_folders_and_odd_names(tmp_path):
    with pytest.raises(BenchError, match=re.escape(f"{tmp_path}: is a folder, not a file")):
        load_scenario_file(tmp_path)
    with pytest.raises(BenchError, match=r"absent\.yaml: no such file"):
        load_scenario_file(tmp_path / "absent.yaml")
    with pytest.raises(BenchError, match="cannot be read: "):
        load_scenario_file("a\0b.yaml")


def test_an_alias_bomb_is_refused_at_its_first_anchor(tmp_path):
    bomb = "a: &a [x, x]\n" + "".join(
        f"{chr(98 + i)}: &{chr(98 + i)} [*{chr(97 + i)}, *{chr(97 + i)}]\n" for i in range(20)
    )
    assert load(bomb, tmp_path) == "file.yaml:1:4: anchors and aliases (& and *) are not allowed"


@settings(max_examples=150, deadline=None)
@given(text=st.text(alphabet="ab:- {}[],\n\"'#&*!|>%@`?0.1\t~", max_size=60))
def test_no_text_gets_past_as_anything_but_a_bench_error(text):
    with pytest.raises(BenchError) as fault:
        parse(text, "file.yaml", Scenario)
    assert "\n" not in str(fault.value)


def test_a_suite_and_its_faults(tmp_path):
    file = tmp_path / "suite.yaml"
    file.write_text(
        "name: mine\nsummary: Two.\nscenarios:\n  - {scenario: drink, overrides: {speed: 0.5 m/s}}\n"
    )
    suite = load_suite_file(file)
    assert suite.scenarios[0].overrides == {"speed": "0.5 m/s"}
    assert isinstance(load_either_file(file), Suite)
    file.write_text("name: mine\nsummary: Two.\nscenarios:\n  - {scenario: drink, sedes: 3}\n")
    with pytest.raises(BenchError) as fault:
        load_suite_file(file)
    place = f"{file}:4:23: scenarios.0.sedes"
    assert str(fault.value) == f"{place}: no such field; did you mean seeds?"


def test_the_json_schema_names_every_field_and_is_json():
    schema = json.loads(json.dumps(json_schema()))
    assert set(schema["required"]) == {
        "name", "group", "summary", "family", "frames", "motion", "parameters",
    }  # fmt: skip
    assert schema["additionalProperties"] is False
    assert schema["$defs"]["Motion"]["properties"]["kind"]["enum"] == list(FAMILIES)
    assert set(scenario_names()) >= set(schema["$defs"]["Motion"]["properties"]["kind"]["enum"])
