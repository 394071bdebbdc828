"""A stress folder of synthetic episodes: a search, maps, probabilities, a comparison."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from pjpdaf.frames import StereoFrame
from reports.pictures.stills import still
from reports.run.save import RunInfo, save
from reports.score.records import Still
from reports.stress import records as r

HOSTILE = '<script>alert("x")</script>'


def case(speed: float, seed: int, family: str = "cross") -> r.CaseRecord:
    return r.CaseRecord(family=family, values={"speed": speed, "front": "left"}, seed=seed)


def failure(confirmed: bool | None, key: r.EpisodeKey | None, **changes: object) -> r.FailureRecord:
    record = r.FailureRecord(
        measure="swap",
        cell="speed high",
        case=case(0.31, 7),
        changed=(r.ChangedValue(name="speed", unit="m/s", value=0.31, nominal=0.23),),
        fidelity="fast",
        rho=-0.9,
        severity=0.4,
        confirmed=confirmed,
        survived=(7, 8),
        blame="association",
        command="pjpdaf-bench stress cross replay --seed 7 --set speed=0.31",
        episode=key,
    )
    return record.model_copy(update=changes)


def failure_map(key: r.EpisodeKey, *, steps: int = 5, worse: int = 0) -> r.MapRecord:
    """Failures above a diagonal; the cell in the middle is split, a corner has no trial."""
    cells = []
    for i in range(steps):
        for j in range(steps):
            n = 0 if i == j == 0 else 8
            hits = min(n, max(0, 2 * (i + j) - 4 + worse))
            quarters = 2 if i == j == steps // 2 else 1
            for a in range(quarters):
                for b in range(quarters):
                    size = steps * quarters
                    x, y = i * quarters + a, j * quarters + b
                    cells.append(
                        r.CellRecord(
                            x=(x / size, (x + 1) / size),
                            y=(y / size, (y + 1) / size),
                            n=n,
                            failures={"swap": hits, "head": 0, "lost": hits // 2},
                            case=case(0.2, i),
                            episode=key if i == steps - 1 else None,
                            command="pjpdaf-bench stress cross replay --seed 4",
                        )
                    )
    return r.MapRecord(
        family="cross",
        fidelity="fast",
        goal="swap",
        level=0.5,
        x=r.AxisRecord(name="speed", unit="m/s", low=0.1, high=0.6, log=True),
        y=r.AxisRecord(name="depth_gap", unit="m", low=0.04, high=0.15),
        seeds=8,
        others="drawn",
        runs=232,
        cells=tuple(cells),
        occluded=tuple(r.OccludedRecord(frames=f, n=40, lost=3 * f) for f in range(8)),
        command="pjpdaf-bench stress cross map --x speed --y depth_gap",
    )


def curve(key: r.EpisodeKey) -> r.MapRecord:
    cells = tuple(
        r.CellRecord(
            x=(i / 7, (i + 1) / 7),
            n=20,
            failures={"swap": 20 - 3 * i, "head": 0, "lost": max(0, 12 - 2 * i)},
            case=case(0.2, i),
            episode=key if i == 0 else None,
        )
        for i in range(7)
    )
    axis = r.AxisRecord(name="fps", unit="Hz", low=1, high=30, log=True)
    return failure_map(key).model_copy(update={"x": axis, "y": None, "cells": cells})


def probability(family: str, goal: r.Goal, p: float, **changes: object) -> r.EstimateRecord:
    record = r.EstimateRecord(
        family=family,
        goal=goal,
        fidelity="full",
        p=p,
        low=0.7 * p,
        high=min(1.0, 1.4 * p + 0.003),
        method="plain",
        verdict="estimated" if p else "bound",
        runs=1000,
        failures=round(1000 * p),
        ess=1000 * p,
        largest_weight=0.01,
        fast=(p, 0.8 * p, min(1.0, 1.2 * p + 0.002)),
        full_failing=(3, 4),
        full_passing=(0, 16),
        command="pjpdaf-bench stress all estimate",
    )
    return record.model_copy(update=changes)


@pytest.fixture(scope="module")
def stress_folder(episode_of, tools, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("stress") / "thesis"
    centres = tools.paths(24, 3.0)
    swapped = tools.noisy(centres, 1)
    swapped[8:20] = swapped[8:20][:, [0, 2, 1]]
    frames = [StereoFrame(f, f / 3, (tools.picture(f), tools.picture(f + 50))) for f in range(24)]
    film = tuple(Still(f.index, still(f, tools.cameras())) for f in frames)
    filmed, plain = r.EpisodeKey(label="cross: a", seed=7), r.EpisodeKey(label="cross: b", seed=8)
    episodes = [
        replace(episode_of(swapped, centres_m=centres, scenario=key.label, seed=key.seed), film=f)
        for key, f in ((filmed, film), (plain, ()))
    ]
    save(folder / "episodes", episodes, RunInfo("episodes", tracker="thesis"))
    gone = r.EpisodeKey(label="cross: gone", seed=1)
    r.write_record(
        folder / "failures.json",
        r.SearchFile(
            system="thesis",
            command="pjpdaf-bench stress cross search --tracker thesis",
            searches=(
                r.SearchRecord(
                    family="cross",
                    fidelity="fast",
                    parameters=13,
                    runs=500,
                    failing=61,
                    first=3,
                    ended="budget",
                    failures=(
                        failure(False, None, measure="lost_left", changed=()),
                        failure(
                            None,
                            gone,
                            blame=HOSTILE,
                            command=HOSTILE,
                            narrowed=False,
                            survived=(0, 0),
                        ),
                        failure(True, filmed),
                        failure(True, plain, severity=0.2),
                    ),
                ),
            ),
        ),
    )
    first = failure_map(filmed)
    maps = (first, curve(plain), first.model_copy(update={"cells": first.cells[:1]}))
    r.write_record(folder / "map.json", r.MapFile(system="thesis", maps=maps))
    r.write_record(
        folder / "estimate.json",
        r.EstimateFile(
            system="thesis",
            estimates=(
                probability("cross", "swap", 0.45),
                probability("cross", "lost", 0.0),
                probability("drink", "swap", 0.0012, method="importance", ess=212.0),
                probability("drink", "lost", 0.03, verdict="inconclusive"),
            ),
        ),
    )
    comparison = r.CompareRecord(
        family="cross",
        goal="swap",
        fidelity="fast",
        a="thesis",
        b="default",
        both=3,
        only_a=40,
        only_b=2,
        neither=155,
        difference=-0.19,
        low=-0.25,
        high=-0.13,
        p_value=1e-9,
        map_a=failure_map(filmed, worse=2),
        map_b=failure_map(filmed),
        command="pjpdaf-bench stress cross compare thesis default",
    )
    r.write_record(
        folder / "compare.json",
        r.CompareFile(system="thesis and default", comparisons=(comparison,)),
    )
    return folder
