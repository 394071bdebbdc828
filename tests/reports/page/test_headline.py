"""The verdict of the first screen, in words."""

from dataclasses import replace

from reports.page.episode_tables import episode_tables
from reports.page.headline import headline
from reports.page.run_entries import run_entries
from reports.page.run_report import run_report
from reports.run.load import load
from reports.run.save import RunInfo, save
from reports.score.records import EpisodeFailure


def said(tmp_path, episodes, name="run"):
    """The headline of a run of these episodes."""
    run = load(save(tmp_path / name, episodes, RunInfo(name, detector="thesis", tracker="thesis")))
    report = run_report(run)
    played = [{(e.scenario, e.seed): e for e in episode_tables(run)}]
    return headline(report, run_entries([run], played, list(report.summary.scenarios)))


def test_what_was_played_how_good_what_failed_and_the_worst(episode_of, tools, tmp_path):
    centres = tools.paths(24, 3.0)
    swapped = tools.noisy(centres, 1)
    swapped[8:] = swapped[8:][:, [0, 2, 1]]
    line = said(
        tmp_path,
        [
            episode_of(tools.noisy(centres, 0), centres_m=centres, scenario="calm"),
            replace(episode_of(swapped, centres_m=centres, scenario="cross"), seed=7),
            EpisodeFailure("cross", 8, "killed"),
        ],
    )
    assert line.outcome == "bad"
    assert line.summary == "1 of 2 episodes went wrong, 1 without a result"
    assert line.played == "Played: 3 episodes of calm and cross, 48 stereo frames, tracker thesis."
    assert line.quality.startswith("77.8 % of the estimates are within 100 mm of the truth")
    assert line.failed == "Hands swapped in 1 of 3; a target lost in 1 of 3."
    assert (line.worst.scenario, line.worst.seed) == ("cross", 7)


def test_nothing_bad_is_said_too(episode_of, tools, tmp_path):
    centres = tools.paths(24, 3.0)
    line = said(tmp_path, [episode_of(tools.noisy(centres, 0), centres_m=centres)])
    assert (line.outcome, line.worst) == ("good", None)
    assert line.summary == "Nothing went wrong in 1 episode"
    assert line.failed == "No hands swapped, no target lost."


def test_what_went_wrong_is_named_where_nothing_was_swapped_or_lost(episode_of, tools, tmp_path):
    centres = tools.paths(24, 3.0)
    far = centres.copy()
    far[::6, 0, 2] += 0.12  # now and then, so that the head is not lost
    episodes = [
        episode_of(far, centres_m=centres),
        episode_of(tools.noisy(centres, 0), centres_m=centres, seed=1),
    ]
    line = said(tmp_path, episodes)
    assert line.summary == "1 of 2 episodes went wrong"
    assert line.failed == (
        "No hands swapped, no target lost; under 95 % of the estimates within 100 mm in 1 of 2."
    )
    episodes.append(episode_of(centres[:, [0, 2, 1]], centres_m=centres, seed=2))
    assert said(tmp_path, episodes, "more").failed == (
        "Hands swapped in 1 of 3; a target lost in 1 of 3; "
        "under 95 % of the estimates within 100 mm in 1 more."
    )


def test_without_a_result(tmp_path):
    assert said(tmp_path, []).summary == "No episode"
    line = said(tmp_path, [EpisodeFailure("cross", 1, "killed")], "none")
    assert (line.outcome, line.summary) == ("none", "1 episode, none with a result")
