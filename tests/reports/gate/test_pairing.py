"""Pairing of two runs: unlike ones are refused, values are capped, seeds are joined."""

import hashlib
import json
from dataclasses import replace

import numpy as np
import pyarrow.parquet as pq
import pytest

from reports.gate.gate import compare
from reports.gate.pairing import (
    CAP_MM,
    WORST_GOSPA_MM,
    NotComparable,
    episode_values,
    joined,
    same_results,
)
from reports.run.load import load
from reports.run.save import RunInfo, save, save_slim
from reports.run.schema import columns_since


def test_unlike_runs_are_not_compared(runs, episodes, tmp_path):
    with pytest.raises(NotComparable, match=r"lacks 1 of 24 .*calm seed 0"):
        compare(runs["base"], runs["fewer"])
    with pytest.raises(NotComparable, match="lacks 1 of 24"):
        compare(runs["fewer"], runs["base"])
    assert NotComparable("x").exit_code == 4
    other = []
    for episode in episodes():
        object.__setattr__(episode, "digest", episode.digest + "x")
        other.append(episode)
    changed = load(save(tmp_path / "changed", other, RunInfo("changed")))
    with pytest.raises(NotComparable, match="24 of 24 episodes are not the same"):
        compare(runs["base"], changed)
    cut = load(save(tmp_path / "cut", episodes(), RunInfo("c", complete=False)))
    with pytest.raises(NotComparable, match="was interrupted"):
        compare(runs["base"], cut)


def with_meta(run, **changes):
    return replace(run, meta={**run.meta, **changes})


def with_scenarios(run, **changes):
    return with_meta(run, scenarios=[{**one, **changes} for one in run.meta["scenarios"]])


def test_suites_of_other_versions_or_content_are_not_compared(runs):
    def of_suite(run, version, digest):
        return with_meta(run, suites=[{"name": "core", "version": version, "digest": digest}])

    base = of_suite(runs["base"], 1, "aa")
    assert compare(base, of_suite(runs["again"], 1, "aa")).verdict == "pass"
    assert compare(base, runs["again"]).verdict == "pass"  # of scenarios that were named one by one
    with pytest.raises(NotComparable, match=r"is of core@1 and .* of core@2"):
        compare(base, of_suite(runs["again"], 2, "bb"))
    with pytest.raises(NotComparable, match=r"core@1 is not the same in both runs"):
        compare(base, of_suite(runs["again"], 1, "bb"))


def test_another_simulator_or_other_metrics_are_not_compared(runs):
    moved = with_scenarios(runs["again"], truths=["10 20 35"] * 8)
    base = with_scenarios(runs["base"], truths=["10 20 30"] * 8)
    with pytest.raises(NotComparable, match="24 of 24 episodes moved differently, the first: calm"):
        compare(base, moved)
    crashed = with_scenarios(runs["again"], truths=["10 19 31"] * 7 + [""])
    assert compare(base, crashed).identical
    with pytest.raises(NotComparable, match="metrics version 0 in"):
        compare(with_meta(runs["base"], metrics_version=0), runs["again"])


def test_values_that_are_not_finite_are_the_cap(runs):
    odd = runs["base"].episodes.copy()
    odd.loc[:1, "median_error_mm"] = [np.nan, np.inf]
    odd.loc[2, "median_error_mm"] = 30.0
    tracking = runs["base"].tracking.copy()
    tracking.loc[0, "sum_gospa_mm"] = np.inf
    values = episode_values(replace(runs["base"], episodes=odd, tracking=tracking)).iloc[0]
    assert values["error_mm"] == pytest.approx((2 * CAP_MM + 30.0) / 3)
    assert values["gospa_mm"] == WORST_GOSPA_MM


def test_what_else_differs_is_noted(runs):
    assert compare(runs["base"], runs["again"]).notes == ()
    here = runs["again"].meta["provenance"]
    other = {**here, "renderer": "another", "versions": {**here["versions"], "mujoco": "3.0"}}
    notes = compare(with_meta(runs["base"], provenance=other), runs["again"]).notes
    assert any("the base by another" in note for note in notes)
    assert any("mujoco 3.0 -> " in note for note in notes)


def test_runs_of_other_seeds_join_to_one(episodes, tmp_path):
    played = list(episodes(seeds=6))
    parts = [[e for e in played if (e.seed < 4) == early] for early in (True, False)]
    whole = load(save(tmp_path / "whole", played, RunInfo("whole")))
    one, two = (load(save(tmp_path / str(k), p, RunInfo("part"))) for k, p in enumerate(parts))
    together = joined([one, two])
    assert same_results(together, whole)
    assert [s["seeds"] for s in together.meta["scenarios"]] == [[0, 1, 2, 3, 4, 5]] * 3
    assert compare(whole, together).identical


def as_version_2(folder):
    """Rewrite a saved run as the version before exchange probabilities wrote it."""
    meta = json.loads((folder / "run.json").read_text())
    meta["schema_version"] = 2
    for name, entry in meta["files"].items():
        path = folder / name
        absent = columns_since(2, path.stem)
        if absent:
            pq.write_table(pq.read_table(path).drop_columns(list(absent)), path)
            entry["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
    (folder / "run.json").write_text(json.dumps(meta))


def test_a_run_of_the_version_before_loads_and_compares(episodes, tmp_path):
    played = list(episodes())[:3]
    new = load(save(tmp_path / "new", played, RunInfo("a")))
    as_version_2(save(tmp_path / "old", played, RunInfo("a")))
    old = load(tmp_path / "old")
    assert list(old.frames.columns) == list(new.frames.columns)
    assert old.frames["exchange_probability"].isna().all()
    assert (old.episodes["exchange_frames"] == 0).all()
    slim = load(save_slim(old, tmp_path / "slim"))
    assert slim.version == 2
    for one, other in ((old, new), (new, old), (slim, new)):
        assert same_results(one, other)
    moved = new.frames.assign(estimate_x_m=new.frames["estimate_x_m"] + 1e-9)
    assert not same_results(old, replace(new, frames=moved))
