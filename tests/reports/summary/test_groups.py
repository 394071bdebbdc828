"""The main table and the error budget: pooled from counts, nothing averaged twice."""

from dataclasses import replace

import numpy as np
import pytest

from reports.run.load import load
from reports.run.save import RunInfo, save
from reports.score.mot import clear_mot, hota, identity, summed_clear, summed_hota, summed_identity
from reports.score.records import BUDGET_LEVELS, EpisodeFailure
from reports.summary.budget import CAUSES, budget_of
from reports.summary.groups import group_rows, scenario_rows, whole_row


@pytest.fixture(scope="module")
def played(episode_of, tools):
    """Two scenarios of one group and one of another, of unlike lengths; one swap."""
    episodes = []
    for n, (scenario, group, frames) in enumerate(
        (("cross", "hand_and_hand", 20), ("clap", "hand_and_hand", 45), ("calm", "baseline", 30))
    ):
        centres = tools.paths(frames, 3.0)
        estimates = tools.noisy(centres, n, 0.03)
        if scenario == "cross":
            estimates[8:] = estimates[8:][:, [0, 2, 1]]
        episode = episode_of(
            estimates,
            centres_m=centres,
            scenario=scenario,
            group=group,
            exchange=np.full(frames, 0.25 * n),
        )
        budget = {
            level: np.full((frames, 3), (k + 1) ** 2 / 1000)
            for k, level in enumerate(BUDGET_LEVELS)
        }
        episodes.append(replace(episode, redrawn=2 * (scenario == "clap"), budget_m=budget))
    return episodes


@pytest.fixture(scope="module")
def run(played, tmp_path_factory):
    everything = [*played, EpisodeFailure("clap", 1, "crash", group="hand_and_hand")]
    return load(save(tmp_path_factory.mktemp("groups") / "run", everything, RunInfo("run")))


def paths(episodes):
    return [
        (
            np.stack([o.truth.centres_m for o in episode.frames]),
            np.stack([o.estimates.positions_m for o in episode.frames]),
        )
        for episode in episodes
    ]


def test_a_group_is_all_of_its_frames_together(run, played):
    rows = {row.name: row for row in group_rows(run)}
    assert set(rows) == {"hand and hand", "baseline"}
    row = rows["hand and hand"]
    both = paths(played[:2])
    errors = np.concatenate(
        [1e3 * np.linalg.norm(said - truth, axis=2).ravel() for truth, said in both]
    )
    assert row.median_mm == pytest.approx(np.quantile(errors, 0.5))
    assert row.p90_mm == pytest.approx(np.quantile(errors, 0.9))
    assert row.within_100 == pytest.approx((errors <= 100).mean())
    assert (row.scenarios, row.episodes, row.failed, row.frames) == (2, 3, 1, 65)
    assert (row.swapped, row.redrawn, row.redraws) == (1, 1, 2)
    assert np.isnan(row.merged_median_mm)


def test_tracking_scores_are_those_of_all_episodes_together(run, played):
    row, every = whole_row(run), paths(played)
    assert row.mota == pytest.approx(summed_clear([clear_mot(*p) for p in every]).mota)
    assert row.idf1 == pytest.approx(summed_identity([identity(*p) for p in every]).idf1)
    assert row.hota == pytest.approx(summed_hota([hota(*p) for p in every]).hota)


def test_stated_and_seen_exchanges_are_of_the_frames_of_all_episodes(run):
    row = whole_row(run)
    assert row.exchange_frames == 95
    assert row.exchange_stated == pytest.approx((45 * 0.25 + 30 * 0.5) / 95)
    assert row.exchange_observed == pytest.approx(12 / 95)


def test_a_scenario_has_its_own_row(run):
    rows = {row.name: row for row in scenario_rows(run)}
    assert set(rows) == {"cross", "clap", "calm"}
    assert rows["clap"].group == "hand and hand"
    assert rows["cross"].swapped == 1
    assert rows["calm"].frames + rows["clap"].frames + rows["cross"].frames == 95


def test_nothing_to_measure_is_not_a_number(tmp_path):
    failed = [EpisodeFailure("clap", 0, "crash", group="hand_and_hand")]
    run = load(save(tmp_path / "run", failed, RunInfo("run")))
    (row,) = group_rows(run)
    assert (row.episodes, row.failed, row.frames) == (1, 1, 0)
    values = (row.median_mm, row.within_100, row.mota, row.idf1, row.hota, row.gospa_mm, row.nees)
    assert np.isnan(values).all()


def test_the_budget_adds_up_to_the_mean_error(run, episode_of, tmp_path):
    budget = budget_of(run)
    assert dict(budget.frames) == {"head": 95, "right_hand": 95, "left_hand": 95}
    assert list(budget.shares_mm) == list(CAUSES.values())
    steps = [values["head"] for values in budget.shares_mm.values()]
    np.testing.assert_allclose(steps, [1, 3, 5, 7, 9])
    assert sum(steps) == pytest.approx(budget.levels_mm["association"]["head"])
    plain = load(save(tmp_path / "plain", [episode_of()], RunInfo("plain")))
    assert budget_of(plain) is None
