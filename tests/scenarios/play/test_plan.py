"""The plan of a run: which episodes, in which order, and every fault before any is played."""

import pytest

from pjpdaf.errors import BenchError
from scenarios.play.job import digest_of
from scenarios.play.plan import MAX_FIRST_SEED, MAX_SEEDS, PlanRequest, plan
from scenarios.play.targets import SCENARIO_SEEDS, expand_target
from scenarios.spec.names import suite_names


def test_scenarios_come_in_order_and_each_with_its_seeds():
    jobs = plan(PlanRequest(("cross", "calm_table"), seeds=2, first_seed=7))
    assert [(job.name, job.seed) for job in jobs] == [
        ("cross", 7),
        ("cross", 8),
        ("calm_table", 7),
        ("calm_table", 8),
    ]
    assert len(plan(PlanRequest(("cross",)))) == SCENARIO_SEEDS


def test_a_suite_says_how_many_seeds():
    planned = expand_target("smoke")
    jobs = plan(PlanRequest(("smoke",)))
    assert [job.name for job in jobs] == [p.label for p in planned for _ in range(p.seeds)]
    only = planned[1].label
    assert {job.name for job in plan(PlanRequest(("smoke",), only=(only,)))} == {only}


def test_settings_change_the_scenarios_that_know_them_and_the_system():
    settings = ("frames=5", "noise_sd=9", "tracker.gate=4", "detector.centre_sd_px=2")
    for job in plan(
        PlanRequest(
            ("cross", "calm_table"), seeds=1, settings=settings, detector="thesis", tracker="thesis"
        )
    ):
        assert job.overrides == {"frames": "5", "noise_sd": "9"}
        assert job.system.tracker_settings == {"gate": "4"}
        assert job.system.detector_settings == {"centre_sd_px": "2"}


def test_pictures_are_of_the_first_seed_and_films_of_all():
    request = PlanRequest(("cross",), seeds=3, first_seed=4, keep_pictures=True, keep_films=True)
    jobs = plan(request)
    assert [job.keep_pictures for job in jobs] == [True, False, False]
    assert all(job.keep_film for job in jobs)
    slim = plan(PlanRequest(("cross",), seeds=3))
    assert not any(job.keep_pictures or job.keep_film for job in slim)
    # What is kept of an episode is not part of it.
    (first, *_), (other, *_) = jobs, plan(PlanRequest(("cross",), seeds=1, first_seed=4))
    assert digest_of(first) == digest_of(other)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"targets": ("crss",)}, "no scenario or suite 'crss'; did you mean cross?"),
        ({"targets": ("cross", "cross")}, "cross: asked for twice"),
        ({"seeds": 0}, f"--seeds must be between 1 and {MAX_SEEDS}, got 0"),
        ({"first_seed": -1}, f"--first-seed must be between 0 and {MAX_FIRST_SEED}, got -1"),
        ({"only": ("cros",)}, "--only cros: not played; did you mean cross?"),
        ({"settings": ("nois_sd=5",)}, "--set nois_sd: no such parameter in these scenarios"),
        ({"settings": ("noise_sd=-5",)}, "noise_sd"),
        ({"settings": ("frames=0",)}, "frames"),
        ({"settings": ("tracker.gat=4",)}, "gat"),
        ({"tracker": "nobody"}, "nobody"),
        ({"detector": "nobody"}, "nobody"),
        ({"lag": 61}, "--lag must be from 0 to 60 frames, got 61"),
        ({"lag": 2, "tracker": "thesis"}, "--lag 2: the tracker 'thesis' does not look back"),
    ],
)
def test_a_fault_of_the_request_is_one_line(changes, message):
    with pytest.raises(BenchError) as caught:
        plan(PlanRequest(**{"targets": ("cross",), "seeds": 1, **changes}))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_all_jobs_use_the_cache_or_none():
    for use_cache in (True, False):
        jobs = plan(PlanRequest(targets=("cross", "drink"), seeds=2, use_cache=use_cache))
        assert [job.use_cache for job in jobs] == [use_cache] * 4


@pytest.mark.parametrize("suite", suite_names())
def test_every_suite_can_be_expanded(suite):
    labels = [planned.label for planned in expand_target(suite)]
    assert len({*labels}) == len(labels) > 0
