"""Tables for the terminal: eighty columns, whole names, names as they are."""

import io

import pytest
from rich.console import Console

from reports.run.load import load
from reports.run.save import RunInfo, save
from reports.score.records import EpisodeFailure
from reports.summary.tables import summarise
from reports.summary.terminal import scenario_table, target_table

TABLES = (scenario_table, target_table)


def printed(table, width=80):
    text = io.StringIO()
    Console(file=text, width=width).print(table)
    return text.getvalue()


@pytest.mark.parametrize("table_of", TABLES)
def test_fits_80_columns_and_prints_names_as_they_are(table_of, episode_of, tmp_path):
    run = save(tmp_path / "run", [episode_of(scenario="[red]cross[/red]")], RunInfo("n[b]"))
    text = printed(table_of(summarise(load(run))))
    assert max(len(line.rstrip()) for line in text.splitlines()) <= 80
    assert "[red]cross[/red]" in text.replace("\n", "")
    assert "100 %" in text
    assert "…" not in text


@pytest.mark.parametrize("table_of", TABLES)
def test_a_run_without_episodes_has_a_table(table_of, tmp_path):
    table_of(summarise(load(save(tmp_path / "run", [], RunInfo("none")))))


def test_a_scenario_is_a_line_with_its_whole_name(episode_of, tools, tmp_path):
    name = "n" * 30
    centres = tools.paths(20, 3.0)
    swapped = centres[:, [0, 2, 1]]
    episodes = [
        episode_of(centres, centres_m=centres, scenario=name, seed=0),
        episode_of(swapped, centres_m=centres, scenario=name, seed=1),
        episode_of(centres, centres_m=centres, scenario="calm", seed=0),
        EpisodeFailure("calm", 1, "timed out"),
    ]
    text = printed(scenario_table(summarise(load(save(tmp_path / "run", episodes, RunInfo("r"))))))
    (line,) = (line for line in text.splitlines() if name in line)
    assert line.split()[1:2] == ["2"]
    assert line.split()[-3:-1] == ["1", "1"]
    assert "1 episode gave no result" in text
    assert max(len(line.rstrip()) for line in text.splitlines()) <= 80


@pytest.mark.parametrize("table_of", TABLES)
def test_the_wide_form_says_all_that_the_other_says_and_more(table_of, episode_of, tools, tmp_path):
    centres = tools.paths(20, 3.0)
    swapped = centres[:, [0, 2, 1]]
    episodes = [episode_of(e, centres_m=centres, seed=n) for n, e in enumerate((centres, swapped))]
    summary = summarise(load(save(tmp_path / "run", episodes, RunInfo("r"))))

    def cells(table):
        headings = [" ".join(str(column.header).split()) for column in table.columns]
        columns = ([str(cell) for cell in column.cells] for column in table.columns)
        return dict(zip(headings, columns, strict=True))

    plain, wide = cells(table_of(summary)), cells(table_of(summary, wide=True))
    first = next(iter(plain))
    for heading in [h for h in plain if h != first]:
        assert wide[heading] == plain[heading]
    for heading in ("within 50 mm", "Err_acc px", "render ms", "detect ms", "track ms"):
        assert heading in wide
    assert "30.0" in wide["render ms"]
    assert "20.0" in wide["detect ms"]


def test_the_form_by_target_names_every_target(episode_of, tmp_path):
    text = printed(
        target_table(summarise(load(save(tmp_path / "r", [episode_of()], RunInfo("r")))))
    )
    for target in ("head", "right", "left", "all"):
        assert target in text
