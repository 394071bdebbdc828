"""The command that plays an episode again."""

from reports.gate.replay import replay_command


def test_an_episode_is_played_again_as_it_was():
    request = {"targets": ["core"], "settings": ["noise_sd=5"], "first_seed": 0, "seeds": None}
    meta = {"preset": "thesis", "detector": "thesis", "tracker": "mine:make", "request": request}
    meta["scenarios"] = [{"name": "fps_ladder@5", "seeds": [0, 1, 2, 3]}]
    assert replay_command(meta, "fps_ladder@5", 3) == (
        "pjpdaf-bench run core --only fps_ladder@5 --first-seed 3 --seeds 1 "
        "--preset thesis --tracker mine:make --set noise_sd=5"
    )
    of_default = {**meta, "preset": "default", "detector": "default", "tracker": "default"}
    assert replay_command(of_default, "fps_ladder@5", 3) == (
        "pjpdaf-bench run core --only fps_ladder@5 --first-seed 3 --seeds 1 --set noise_sd=5"
    )
    assert replay_command({**of_default, "lag_frames": 3}, "cross", 3).endswith(
        "--lag 3 --set noise_sd=5"
    )
    meta |= {"preset": "thesis-literal", "detector": "thesis-literal", "tracker": "thesis-literal"}
    meta["request"] = {**request, "targets": ["my suite.yaml"], "settings": []}
    assert replay_command(meta, "drink+dim", 0) == (
        "pjpdaf-bench run 'my suite.yaml' --only drink+dim --first-seed 0 --seeds 1 "
        "--preset thesis-literal"
    )
    assert replay_command({}, "drink", 0) == ""


def test_an_entry_whose_seeds_a_suite_starts_elsewhere_is_played_again_with_its_own_seed():
    request = {"targets": ["corpus"], "settings": [], "first_seed": 2, "seeds": 1}
    meta = {"preset": "default", "detector": "default", "tracker": "default", "request": request}
    meta["scenarios"] = [{"name": "case", "seeds": [77]}]
    assert replay_command(meta, "case", 77) == (
        "pjpdaf-bench run corpus --only case --first-seed 2 --seeds 1"
    )


def test_a_sequence_of_a_data_set_is_played_again_from_it_with_its_detections():
    request = {"targets": [], "settings": ["detector.min_score=0.5"], "first_seed": 0}
    request |= {"seeds": None, "dataset": "my set", "detections": "boxes.csv"}
    meta = {"preset": "default", "detector": "boxes.csv", "tracker": "thesis", "request": request}
    assert replay_command({**meta, "scenarios": []}, "cross", 3) == (
        "pjpdaf-bench run --from 'my set' --only cross --first-seed 3 --seeds 1 "
        "--detections boxes.csv --tracker thesis --set detector.min_score=0.5"
    )
