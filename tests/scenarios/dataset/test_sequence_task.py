"""One sequence in a worker: what cannot be made becomes one line, and leaves nothing behind."""

from scenarios.dataset.sequence_task import SequenceTask, _make_sequence
from scenarios.play.play import Job, System
from scenarios.play.recipe import Recipe, SequenceSettings
from scenarios.spec.names import load_scenario


def test_a_seed_that_cannot_be_posed_is_named_with_its_remedy(tmp_path, monkeypatch):
    monkeypatch.setattr("scenarios.spec.draw.fault_of", lambda *_: "the hands overlap")
    job = Job(load_scenario("calm_table"), 7, {"frames": 3}, System())
    task = SequenceTask(
        Recipe(job, SequenceSettings(())), tmp_path / ".part", tmp_path / "seq_000000"
    )
    outcome = _make_sequence(task)
    assert str(outcome) == (
        "seq_000000: cannot be posed: calm_table seed 7: none of 20 draws can be posed; the first: "
        "the hands overlap; leave out this seed"
    )
    assert outcome.exit_code == 2
    assert list(tmp_path.iterdir()) == []
