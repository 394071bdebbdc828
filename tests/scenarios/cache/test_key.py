"""Everything that decides a picture is in the key: each is changed here, and the key with it."""

import importlib.metadata
import itertools
from dataclasses import replace

import pytest

from scenarios.cache import key as keys
from scenarios.play.footage import key_of
from scenarios.play.job import Job, System
from scenarios.spec.names import load_scenario

CROSS, RECORDED = load_scenario("cross"), load_scenario("recorded")
JOB = Job(CROSS, 3, {"frames": 4}, System(), size_px=(96, 72))


def changed_parameter():
    speed = CROSS.parameters["speed"]
    wider = speed.model_copy(update={"range": (speed.range[0] / 2, speed.range[1])})
    return CROSS.model_copy(update={"parameters": {**CROSS.parameters, "speed": wider}})


OTHERS = {
    "version": replace(JOB, scenario=CROSS.model_copy(update={"version": 99})),
    "distribution": replace(JOB, scenario=changed_parameter()),
    "scenario": replace(JOB, scenario=load_scenario("bounce")),
    "seed": replace(JOB, seed=4),
    "frames": replace(JOB, overrides={"frames": 5}),
    "nuisance": replace(JOB, overrides={"frames": 4, "jpeg_quality": 70}),
    "size": replace(JOB, size_px=(96, 80)),
    "own size": replace(JOB, size_px=None),
}


@pytest.mark.parametrize("other", OTHERS.values(), ids=OTHERS)
def test_another_episode_has_another_key(other):
    assert key_of(other).digest != key_of(JOB).digest


def test_another_system_or_name_has_the_same():
    system = System("thesis", "thesis", {"min_area_px": "1"})
    other = replace(JOB, system=system, label="mine", keep_pictures=True, keep_film=True)
    assert key_of(other).digest == key_of(JOB).digest


def test_the_content_of_a_file_counts_and_not_its_name(tmp_path):
    def job(text, name="a.csv"):
        (tmp_path / name).write_text(text)
        return Job(RECORDED, 0, {"clip": str(tmp_path / name)}, System())

    one = key_of(job("one")).digest
    assert key_of(job("two")).digest != one
    assert key_of(job("one", "b.csv")).digest == one


def test_a_changed_twin_counts(tmp_path, monkeypatch):
    before = key_of(JOB)
    assert CROSS.twins == ("bounce",)
    changed = load_scenario("bounce").model_copy(update={"version": 99})
    monkeypatch.setattr(keys, "load_scenario", lambda name: changed)
    assert key_of(JOB).digest != before.digest


def test_another_simulator_counts(monkeypatch):
    before = key_of(JOB)
    monkeypatch.setattr(keys, "simulator_digest", lambda: "another")
    assert key_of(JOB).digest != before.digest


@pytest.mark.parametrize("library", keys.LIBRARIES)
def test_another_library_counts(monkeypatch, library):
    before = key_of(JOB)
    version = importlib.metadata.version
    assert before.record["libraries"][library] == version(library)
    keys.library_versions.cache_clear()
    try:
        with monkeypatch.context() as patch:
            patch.setattr(
                importlib.metadata, "version", lambda n: "0" if n == library else version(n)
            )
            assert key_of(JOB).digest != before.digest
    finally:
        keys.library_versions.cache_clear()
    assert key_of(JOB).digest == before.digest


DERIVED = {
    "detections": lambda footage, renderer="egl": keys.detections_key(footage, renderer, "recipe"),
    "films": lambda footage, renderer="egl": keys.film_key(footage, renderer),
    "scenes": lambda footage, renderer="egl": keys.scene_key(footage, renderer, True, True),
}


@pytest.mark.parametrize("kind", DERIVED)
def test_what_is_derived_has_a_key_of_footage_renderer_and_code(kind, monkeypatch):
    made, footage = DERIVED[kind], key_of(JOB)
    before = made(footage)
    assert made(key_of(JOB)) == before
    assert made(key_of(OTHERS["seed"])) != before
    assert made(footage, "another") != before
    monkeypatch.setattr(keys, "detector_digest", lambda: "another")
    monkeypatch.setattr(keys, "film_digest", lambda: "another")
    monkeypatch.setattr(keys, "scene_digest", lambda: "another")
    assert made(footage) != before


def test_another_recipe_counts():
    one, two = (keys.detections_key(key_of(JOB), "egl", recipe) for recipe in "ab")
    assert one != two


def test_a_still_scene_is_that_of_the_parts_that_looked_and_of_no_other_code(monkeypatch):
    def made():
        choices = itertools.product((True, False), repeat=2)
        return [keys.scene_key(key_of(JOB), "egl", *parts) for parts in choices]

    before = made()
    assert len({str(key) for key in before}) == 4
    monkeypatch.setattr(keys, "detector_digest", lambda: "another")
    assert made() == before


def test_another_machine_counts(monkeypatch, tmp_path):
    before = key_of(JOB)
    info = tmp_path / "cpuinfo"
    info.write_text("processor : 0\nflags : fpu avx2 fma sse\n")
    monkeypatch.setattr(keys, "CPU_INFO", info)
    named = [keys.machine.__wrapped__()]
    info.write_text("processor : 0\nflags : fpu sse\n")
    named.append(keys.machine.__wrapped__())
    monkeypatch.setattr(keys.platform, "machine", lambda: "another")
    named.append(keys.machine.__wrapped__())
    assert named[0] == f"{named[1]} avx2 fma"
    assert len({*named}) == 3
    for name in named:
        monkeypatch.setattr(keys, "machine", lambda name=name: name)
        assert (key_of(JOB).digest == before.digest) == (name == before.record["machine"])
