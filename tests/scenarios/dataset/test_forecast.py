"""The expected size of a data set, against the size that it then has."""

from pathlib import Path

import pytest
from made_dataset import request

from pjpdaf.errors import InfrastructureError
from scenarios.dataset.forecast import Forecast, Trial, forecast, refuse_without_room, try_sequences
from scenarios.dataset.make import make_dataset
from scenarios.dataset.sequence_plan import plan_recipes
from scenarios.play.recipe import SequenceSettings, parse_labels
from sim.processes import WorkerPool

KINDS = {
    "all labels": (("clean", "depth", "seg", "amodal", "disparity"), ("coco", "mot")),
    "few": (("depth",), ("parquet",)),
    "training": (parse_labels("training"), ("coco",)),
    "flow": (("flow", "normals"), ()),
    "exports": (("seg",), ("coco", "webdataset", "parquet")),
}


def size_of(folder):
    return sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_the_size_is_as_expected(kind, tmp_path, capsys):
    labels, exports = KINDS[kind]
    wanted = request(
        tmp_path / "set",
        targets=("cross", "drink"),
        settings=("frames=30",),
        labels=SequenceSettings(labels, (320, 240)),
        exports=exports,
    )
    recipes = plan_recipes(wanted)
    with WorkerPool(1) as pool:
        missing = dict(enumerate(recipes))
        expected = forecast(try_sequences(pool, missing), missing, recipes, exports, 1)
    make_dataset(wanted)
    assert size_of(tmp_path / "set") == pytest.approx(expected.size, rel=0.15)
    said = capsys.readouterr().out
    assert "expected: about " in said
    assert "a stereo frame: about " in said


def recipes_of(frames):
    wanted = request(Path("nowhere"), settings=(f"frames={frames}", "background_frames=2"))
    return plan_recipes(wanted)


@pytest.mark.long
def test_frames_of_a_few_sequences_are_made_on_trial(executor):
    recipes = recipes_of(100)[:2]
    trials = try_sequences(executor, dict(enumerate(recipes)))
    assert sorted(trials) == [0, 1]
    pixels = 96 * 72
    for trial in trials.values():
        assert 2 * pixels < trial.pictures < 2 * 3 * pixels * 1.1
        assert 0 < trial.labels < 2 * 3 * pixels
        assert trial.frame_cpu_s > 0
        assert 0 < trial.frame_s < trial.start_s + trial.frame_s


def test_each_sequence_counts_as_the_nearest_that_was_tried():
    recipes = recipes_of(50)
    trials = {0: Trial(1e6, 2e6, 1.0, 2.0, 1.5), 3: Trial(2e6, 4e6, 1.0, 4.0, 3.5)}
    whole = forecast(trials, dict(enumerate(recipes)), recipes, ("webdataset",), 2)
    frames = 2 * 50 * (3e6 + 6e6)
    assert whole.exports == pytest.approx(frames, rel=0.01)
    assert whole.size == pytest.approx(2 * frames + 2 * 2 * (1e6 + 2e6), rel=0.01)
    assert whole.seconds == pytest.approx((4 + 100 * (2 + 4)) / 2 + 0.02 * frames / 1e6, rel=0.01)
    assert (whole.pictures, whole.labels, whole.cpu_s) == (1.5e6, 3e6, 2.5)
    rest = forecast(trials, {3: recipes[3]}, recipes, (), 2)
    assert rest.seconds == pytest.approx(1 + 50 * 4, rel=0.01)  # a single one left: one worker


def test_a_small_data_set_is_made_at_once():
    assert try_sequences(None, dict(enumerate(recipes_of(20)))) == {}
    assert forecast({}, {}, (), (), 1) is None


def test_a_disk_without_room_is_refused_before_anything_is_made(tmp_path):
    assert refuse_without_room(Forecast(1, 0, 1.0, 1, 1, 1), tmp_path) > 1
    with pytest.raises(InfrastructureError, match=r"takes about 9\.0 EB \(2\.0 EB of it exports\)"):
        refuse_without_room(Forecast(9 * 10**18, 2 * 10**18, 1.0, 1, 1, 1), tmp_path)
