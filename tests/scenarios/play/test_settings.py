"""`--set` arguments and what they change."""

import pytest

from pjpdaf.errors import BenchError
from scenarios.play.settings import Settings, read_settings


def test_pairs_go_to_the_scenario_the_detector_and_the_tracker():
    pairs = ("noise_sd=5", "detector.blob=3", "tracker.gate=4", "clip=a.b=c", "arm.reach=2")
    assert read_settings(pairs) == Settings(
        {"noise_sd": "5", "clip": "a.b=c", "arm.reach": "2"}, {"blob": "3"}, {"gate": "4"}
    )
    assert read_settings(()) == Settings({}, {}, {})


@pytest.mark.parametrize("pair", ["noise_sd", "=5", ""])
def test_a_pair_without_key_or_value_is_refused(pair):
    with pytest.raises(BenchError, match="must be KEY=VALUE"):
        read_settings([pair])


def test_a_key_is_given_once():
    with pytest.raises(BenchError, match=r"--set tracker.gate: given twice"):
        read_settings(["tracker.gate=4", "gate=4", "tracker.gate=5"])
