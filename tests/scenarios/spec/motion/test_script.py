"""Scripts in files: each fault one line at its place; the schema knows the steps; digests."""

# ruff: noqa: E501 - messages are spelled out on one line, as the user sees them

from __future__ import annotations

import json
import pickle
from pathlib import Path

import pytest
from scripts import FIRST_STEP, script, script_text

from pjpdaf.errors import BenchError
from scenarios.spec.loader import load_scenario_file, parse
from scenarios.spec.motion.steps import RECORDS
from scenarios.spec.scenario import Scenario, canonical, digest
from scenarios.spec.schema import json_schema
from sim.families.gestures.gesture import Quantity
from sim.families.gestures.registry import GESTURES

EXAMPLES = sorted((Path(__file__).parents[4] / "examples" / "motion").glob("*.yaml"))
SPEED = "{speed: {unit: m/s, range: [0.4, 0.8], nominal: {kind: uniform}}}"
ALL = ", ".join(GESTURES)


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        (["{who: right, do: graps, object: can}"], f"0:20: motion.steps.0.do: must be one of {ALL}, got 'graps'; did you mean grasp?"),
        (["{who: right, object: can}"], f"0:7: motion.steps.0: needs a field do: {ALL}"),
        (["rest"], "0:7: motion.steps.0: must be a mapping, got 'rest'"),
        (["{who: right, do: grasp, object: cna}"], "0:31: motion.steps.0.object: no object 'cna'; did you mean can?"),
        (["{who: right, do: grasp}"], "0:7: motion.steps.0.object: is missing"),
        (["{who: right, do: grasp, object: can, sped: 1}"], "0:44: motion.steps.0.sped: no such field; did you mean speed?"),
        (["{who: right, do: rest, speed: 9}"], "0:30: motion.steps.0.speed: must be from 0.02 to 4 m/s, got 9"),
        (["{who: right, do: rest, speed: sped}"], "0:30: motion.steps.0.speed: no such parameter 'sped'; did you mean speed?"),
        (["{who: right, do: rest, speed: 8*speed}"], "0:30: motion.steps.0.speed: must be from 0.02 to 4 m/s, got 3.2 to 6.4 over the ranges of its parameters"),
        (["{who: right, do: rest, wait: speed}"], "0:30: motion.steps.0.wait: must be in s, the parameter speed is in m/s"),
        (["{who: right, do: rest, speed: stature}"], "0:30: motion.steps.0.speed: must be in m/s, the parameter stature is in m"),
        (["{who: right, do: rest, speed: sleeves}"], "0:30: motion.steps.0.speed: the parameter sleeves is not a number"),
        (["{who: right, do: rest, speed: 3 s}"], "0:30: motion.steps.0.speed: must be in m/s, cm/s, mm/s, km/h, got unit 's'"),
        (["{who: right, do: rest, speed: [1]}"], "0:30: motion.steps.0.speed: must be a number in m/s or a parameter, got a list"),
        (["{who: right, do: rest, speed: speed, duration: 2}"], "0:44: motion.steps.0.duration: give speed or duration, not both"),
        (["{who: rihgt, do: rest}"], "0:8: motion.steps.0.who: must be right, left, both, head, a parameter that is right or left, or other and such a parameter, got 'rihgt'; did you mean right?"),
        (["{who: both, do: grasp, object: can}"], "0:8: motion.steps.0.who: grasp is made by one hand: right or left, got both"),
        (["{who: right, do: cross}"], "0:8: motion.steps.0.who: cross is made by both hands: both, got right"),
        (["{who: right, do: reach, to: {tabel: [0.3, 0.2]}}"], "0:36: motion.steps.0.to.tabel: no such field; did you mean table?"),
        (["{who: right, do: reach, to: {table: [0.3]}}"], "0:36: motion.steps.0.to.table: needs at least 2 of them, got 1"),
        (["{who: right, do: reach, to: {table: [0.3, 0.2], body: chest}}"], "0:31: motion.steps.0.to: needs one of table, object, body, got two"),
        (["{who: right, do: reach, to: {}}"], "0:31: motion.steps.0.to: needs one of table, object, body"),
        (["{who: right, do: reach, to: {table: [0.3, 0.2], by: [0, 0, 0]}}"], "0:55: motion.steps.0.to.by: goes with object or body; a place on the table has it all"),
        (["{who: right, do: reach, to: {body: chset}}"], "0:36: motion.steps.0.to.body: must be one of mouth, chin, nose, forehead, ear, crown, chest, shoulder, got 'chset'; did you mean chest?"),
        (["{who: right, do: reach, to: {object: cna}}"], "0:36: motion.steps.0.to.object: no object 'cna'; did you mean can?"),
        (["{who: right, do: lift}"], "0:20: motion.steps.0.do: the right hand holds nothing; grasp an object first"),
        (["{who: right, do: grasp, object: can}", "{who: right, do: rest}"], "1:20: motion.steps.1.do: the right hand already holds can (motion.steps.0); put it down first"),
        (["{who: right, do: grasp, object: can}", "{who: left, do: grasp, object: can}"], "1:30: motion.steps.1.object: the right hand holds can (motion.steps.0); put it down first"),
        (["{who: right, do: grasp, object: can}", "{who: right, do: put, to: {body: chest}}"], "1:34: motion.steps.1.to.body: put goes to the table or to an object"),
        (["{who: right, do: rest, after: there}"], "0:30: motion.steps.0.after: no earlier step is named 'there'; no step before has a name"),
        (["{who: right, do: rest, name: here}", "{who: left, do: rest, with: hree}"], "1:29: motion.steps.1.with: no earlier step is named 'hree'; did you mean here?"),
        (["{who: right, do: rest, name: a}", "{who: left, do: rest, with: a, after: a}"], "1:29: motion.steps.1.with: give one of at, after, with"),
        (["{who: right, do: rest, name: a}", "{who: left, do: rest, name: a}"], "1:29: motion.steps.1.name: a is already the name of motion.steps.0"),
        (["{who: right, do: rest, at: 0.5}"], "0:30: motion.steps.0.at: must be from 1.1 to 20000 s, got 0.5"),
        (["{who: right, do: rest, at: 2, wait: 1}"], "0:37: motion.steps.0.wait: goes with after or with, or alone; `at` is a time itself"),
        (["{who: right, do: touch, what: nose}"], "0:31: motion.steps.0.what: must be one of cheek, chin, mouth, forehead, crown, temple, other_hand, got 'nose'"),
    ],
)  # fmt: skip
def test_each_fault_is_one_line_at_its_place(steps, message):
    with pytest.raises(BenchError) as fault:
        script(*steps, parameters=SPEED)
    step, rest = message.split(":", 1)
    assert str(fault.value) == f"mine.yaml:{FIRST_STEP + int(step)}:{rest}"


def test_a_parameter_that_nothing_refers_to_is_a_fault():
    with pytest.raises(BenchError) as fault:
        script("{who: right, do: rest}", parameters=SPEED)
    assert str(fault.value) == (
        "mine.yaml:13:14: parameters.speed: no step or object refers to it, and it is no standard one"
    )


def test_a_script_without_steps_and_an_object_on_no_side():
    text = script_text(["{who: right, do: rest}"])
    with pytest.raises(BenchError, match=r"11:3: motion\.steps: needs at least one step"):
        parse(
            text.replace("    - {who: right, do: rest}\n", "").replace("steps:", "steps: []"),
            "mine.yaml",
            Scenario,
        )
    with pytest.raises(BenchError) as fault:
        parse(text.replace("at: [0.4, 0.0]", "at: [0.4, 0.0], side: rihgt"), "mine.yaml", Scenario)
    assert str(fault.value) == (
        "mine.yaml:9:38: motion.objects.can.side: must be right, left, or a parameter that is either, got 'rihgt'; did you mean right?"
    )


def test_what_a_hand_holds_is_followed_for_each_choice_of_the_hand():
    hand = "{hand: {choices: [right, left]}}"
    script("{who: hand, do: grasp, object: can}", "{who: other hand, do: rest}", parameters=hand)
    with pytest.raises(BenchError, match="the left hand already holds can"):
        script("{who: hand, do: grasp, object: can}", "{who: left, do: rest}", parameters=hand)


def test_the_schema_has_every_gesture_with_its_fields_and_what_they_mean():
    definitions = json_schema()["$defs"]
    items = definitions["ScriptMotion"]["properties"]["steps"]["items"]
    assert items["discriminator"]["propertyName"] == "do"
    assert {*items["discriminator"]["mapping"]} == {*GESTURES}
    for name, gesture in GESTURES.items():
        record = definitions[RECORDS[name].__name__]
        assert {"$ref": f"#/$defs/{RECORDS[name].__name__}"} in items["oneOf"]
        assert record["properties"]["do"]["const"] == name
        assert {"who", "at", "after", "with", "wait", "name"} < {*record["properties"]}
        assert record["additionalProperties"] is False
        assert gesture.meaning in record["description"]
        for field in gesture.fields:
            assert field.meaning in json.dumps(record["properties"][field.name]), (name, field.name)


def test_no_field_has_the_name_of_its_gesture_and_defaults_are_in_range():
    """Places of faults carry the gesture's name beside those of fields."""
    for name, gesture in GESTURES.items():
        assert name not in {field.name for field in gesture.fields}
        for field in gesture.fields:
            if isinstance(field, Quantity) and field.default is not None:
                assert field.least <= field.default <= field.most


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_a_script_comes_back_from_its_json_and_from_another_process_the_same(path):
    scenario = load_scenario_file(path)
    again = Scenario.model_validate(json.loads(canonical(scenario)))
    assert digest(again) == digest(scenario)
    assert digest(pickle.loads(pickle.dumps(scenario))) == digest(scenario)


def test_the_digest_follows_the_steps_but_not_the_place_of_the_file():
    base = script("{who: right, do: rest}")
    assert digest(script("{who: left, do: rest}")) != digest(base)
    assert digest(script("{who: right, do: rest, speed: 0.41}")) != digest(base)
    text = script_text(["{who: right, do: rest}"])
    assert digest(parse(f"# moved\n{text}", "other.yaml", Scenario)) == digest(base)
