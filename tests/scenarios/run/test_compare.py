"""The verb `compare` on runs that were played for real, small ones."""

import json
import re
import shlex
import shutil
from dataclasses import replace
from xml.etree import ElementTree

import pytest
from commands import in_this_process
from made_dataset import request as request_of_set

from pjpdaf.errors import BenchError
from reports.gate.pairing import NotComparable
from reports.run.load import load
from reports.run.rows import rows_of
from reports.run.save import RunInfo, save, save_slim
from scenarios.dataset.make import make_dataset
from scenarios.play.job import Job, System
from scenarios.play.play import play_complete
from scenarios.play.recipe import SequenceSettings
from scenarios.play.targets import expand_target
from scenarios.run.compare import FILES, CompareRequest, compare_runs, sentence, verdict_table
from scenarios.run.margins import load_margins, read_margins

SIZE_PX = (320, 240)
SYSTEMS = {
    "base": System("thesis", "thesis"),
    # Blobs count as noise: nothing is ever corrected.
    "worse": System("thesis", "thesis", tracker_settings={"measurement_px2": "1e7"}),
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare")
    (part,) = expand_target("cross")
    jobs = [
        Job(part.scenario, seed, {"frames": 4, "fps": 1}, system, size_px=SIZE_PX)
        for system in SYSTEMS.values()
        for seed in range(100, 103)
    ]
    with pytest.MonkeyPatch.context() as patch:  # both systems are shown the same pictures
        patch.setenv("PJPDAF_BENCH_CACHE", str(folder / "cache"))
        rows = [rows_of(play_complete(job)) for job in jobs]
    for k, name in enumerate(SYSTEMS):
        save(folder / name, rows[3 * k : 3 * k + 3], RunInfo(name))
        save_slim(load(folder / name), folder / f"{name}-slim")
    return folder


def request(runs, base, new, **changes):
    asked = CompareRequest(
        base=runs / base,
        new=runs / new,
        margins_file=None,
        margins=(),
        out=None,
        escalate=False,
        jobs=None,
        argv=("compare",),
    )
    return replace(asked, **changes)


def test_a_run_against_its_own_slim_copy_is_identical(runs, tmp_path, capsys):
    assert compare_runs(request(runs, "base-slim", "base", out=tmp_path)) == 0
    said = capsys.readouterr().out
    assert "pass: the same results as the base, bit for bit (3 paired episodes)" in said
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(FILES)
    record = json.loads((tmp_path / "verdict.json").read_text())
    assert record["identical"]
    ElementTree.parse(tmp_path / "junit.xml")


def test_three_episodes_of_a_useless_tracker_are_inconclusive(runs, tmp_path, capsys):
    """Sign flips of three draws cannot be below 1/8, however bad they are."""
    assert compare_runs(request(runs, "base", "worse-slim", out=tmp_path)) == 3
    said = capsys.readouterr().out
    assert "inconclusive: " in said
    assert "to see where" not in said  # a slim run has no page
    assert json.loads((tmp_path / "badge.json").read_text())["color"] == "yellow"
    compare_runs(request(runs, "base", "worse", out=tmp_path))
    said = capsys.readouterr().out
    words = shlex.join(["report", str(runs / "worse"), "--baseline", str(runs / "base")])
    assert f"to see where: pjpdaf-bench {words}\n" in said


@pytest.mark.long  # eight runs in all
def test_every_play_it_again_command_works_as_it_is_pasted(tmp_path, monkeypatch):
    """Both forms: of scenarios that are rendered, and of a data set."""
    labels = SequenceSettings((), SIZE_PX)
    changes = {"targets": ("cross",), "seeds": 1, "settings": ("frames=4", "fps=1")}
    make_dataset(request_of_set(tmp_path / "my set", labels=labels, **changes))
    (tmp_path / "own.yaml").write_text(
        "name: own\nversion: 1\nsummary: A scenario.\nseeds: 1\nscenarios:\n"
        "  - {scenario: cross, frames: 4, overrides: {fps: 1}}\n"
    )
    monkeypatch.chdir(tmp_path)
    for played in (("--from", "my set"), ("own.yaml", "--first-seed", 100)):
        for folder, change in (("base", ()), ("new", ("--set", "tracker.measurement_px2=1e7"))):
            words = ("run", *played, "--preset", "thesis", *change, "--out", folder)
            done = in_this_process(*words, "--jobs", 1)
            assert done.returncode == 0, done.stderr
        assert in_this_process("compare", "base", "new").returncode == 3
        summary = (tmp_path / "new" / "summary.md").read_text()
        commands = re.findall(r"`(pjpdaf-bench run [^`]+)`", summary)
        assert commands
        for number, command in enumerate(commands):
            words = shlex.split(command)[1:]
            out = tmp_path / f"again-{number}"
            done = in_this_process(*words, "--jobs", 1, "--out", out)
            assert done.returncode == 0, done.stderr
            again, new = load(out), load(tmp_path / "new")
            (scenario,) = again.meta["scenarios"]
            (seed,) = scenario["seeds"]
            mine = (new.frames["scenario"] == scenario["name"]) & (new.frames["seed"] == seed)
            assert again.frames.equals(new.frames[mine].reset_index(drop=True))
            shutil.rmtree(out)
        for folder in ("base", "new"):
            shutil.rmtree(tmp_path / folder)


def test_margins_forgive_from_a_file_and_from_the_command_line(runs, tmp_path):
    file = tmp_path / "margins.yaml"
    file.write_text("margins: {error_mm: 500, missed: 1, err_acc_px: 500, gospa_mm: 500}\n")
    wide = request(runs, "base", "worse", out=tmp_path / "o", margins_file=file)
    assert compare_runs(replace(wide, margins=("lost=1", "swapped=1"))) == 0
    assert compare_runs(replace(wide, margins=("lost=1", "swapped=1", "error_mm=0"))) == 3


def test_faulty_margins_are_one_line_with_their_place(tmp_path):
    file = tmp_path / "margins.yaml"
    for text, line in (
        ("margins: {eror_mm: 2}\n", r"margins.yaml: No metric 'eror_mm'. Did you mean 'error_mm'"),
        ("margins: {error_mm: -2}\n", r"margins.yaml:1:\d+: margins.error_mm"),
        ("margin: {error_mm: 2}\n", r"margins.yaml:1:\d+: margin.*did you mean margins\?"),
        ("margins: {error_mm: .nan}\n", r"margins.yaml:1:\d+"),
        ("error_mm: 2\n", r"no such field \(it is written as `margins: {error_mm: 2.5}`\)"),
    ):
        file.write_text(text)
        with pytest.raises(BenchError, match=line):
            load_margins(file)
    for word in ("error_mm", "error_mm=wide", "=3", "error_mm=-1", "error_mm=nan"):
        with pytest.raises(BenchError, match=f"^--margin {word}: "):
            read_margins((word,))
    with pytest.raises(BenchError, match="each metric once"):
        read_margins(("error_mm=1", "error_mm=2"))


def test_a_file_as_folder_of_the_verdict_is_one_line(runs, tmp_path):
    (tmp_path / "o").write_text("")
    with pytest.raises(BenchError, match="o: is a file; give --out a folder"):
        compare_runs(request(runs, "base", "worse", out=tmp_path / "o"))


def test_a_run_against_itself_says_so(runs, tmp_path, capsys):
    assert compare_runs(request(runs, "base", "base", out=tmp_path)) == 0
    assert "base was compared with itself" in capsys.readouterr().out


def test_unlike_runs_are_exit_code_4_and_write_nothing(runs, tmp_path):
    (part,) = expand_target("cross")
    rows = [
        rows_of(
            play_complete(
                Job(part.scenario, 100, {"frames": 3, "fps": 1}, System(), size_px=SIZE_PX)
            )
        )
    ]
    save(tmp_path / "short", rows, RunInfo("short"))
    with pytest.raises(NotComparable, match="lacks 2 of 3 episodes") as caught:
        compare_runs(request(runs, "base", tmp_path / "short", out=tmp_path / "o"))
    assert caught.value.exit_code == 4
    assert not (tmp_path / "o").exists()


def test_the_table_and_the_sentence_say_the_same(runs):
    from reports.gate.gate import compare

    verdict = compare(load(runs / "base"), load(runs / "worse"))
    assert sentence(verdict).startswith("inconclusive: ")
    assert verdict_table(verdict).row_count == len(verdict.metrics)
    for judged in verdict.metrics:
        assert (judged.metric.name in sentence(verdict)) == (judged.verdict == "inconclusive")
