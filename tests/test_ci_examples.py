"""The action and the examples for CI: well-formed, pinned; their steps do what they say."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from scenarios.run.request import parse_shard

ROOT = Path(__file__).parents[1]
ACTION = ROOT / ".github/actions/pjpdaf-bench/action.yml"
SHARDS = ROOT / "examples/ci/github-shards.yml"
GITHUB, GITLAB = ROOT / "examples/ci/github.yml", ROOT / "examples/ci/gitlab-ci.yml"
TINY = "--seeds 1 --set frames=2 --jobs 1"


def read(path):
    return YAML(typ="safe").load(path.read_text())


def shell(script, folder, **variables):
    """Run a step as a forge does: bash, ending at the first fault."""
    bin_ = folder / "bin"
    bin_.mkdir(exist_ok=True)
    command = bin_ / "pjpdaf-bench"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m scenarios "$@"\n')
    command.chmod(0o755)
    env = {**os.environ, "PYTHONPATH": str(ROOT), "PATH": f"{bin_}:{os.environ['PATH']}"}
    words = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", script]
    return subprocess.run(
        words, cwd=folder, env=env | variables, capture_output=True, text=True, check=False
    )


def step(name):
    return next(s for s in read(ACTION)["runs"]["steps"] if s["name"] == name)


def test_every_shell_step_is_bash():
    scripts = [s["run"] for s in read(ACTION)["runs"]["steps"]]
    gitlab = read(GITLAB)["tracking"]
    scripts += gitlab["before_script"] + gitlab["script"]
    for script in scripts:
        done = subprocess.run(["bash", "-n"], input=script, capture_output=True, text=True)
        assert done.returncode == 0, (script, done.stderr)
        assert "${{" not in script  # a value put into a script is a script


def test_actions_are_pinned_to_those_of_our_own_ci():
    ours = re.findall(r"uses: (\S+@\S+)", (ROOT / ".github/workflows/ci.yml").read_text())
    used = re.findall(r"uses: (\S+@\S+)", GITHUB.read_text())
    assert all(re.fullmatch(r"\S+@[0-9a-f]{40}", one) for one in used)
    theirs = [one for one in used if not one.startswith("OWNER/pjpdaf-bench/")]
    assert theirs
    assert set(theirs) <= set(ours)
    place = next(one for one in used if one.startswith("OWNER/"))
    assert (ROOT / place.split("@")[0].removeprefix("OWNER/pjpdaf-bench/") / "action.yml").is_file()


def test_the_shards_example_divides_a_run_and_merges_it():
    jobs = read(SHARDS)["jobs"]
    scripts = [s["run"] for job in jobs.values() for s in job["steps"] if "run" in s]
    for script in scripts:
        done = subprocess.run(["bash", "-n"], input=script, capture_output=True, text=True)
        assert done.returncode == 0, (script, done.stderr)
        assert "${{" not in script
    used = re.findall(r"uses: (\S+@\S+)", SHARDS.read_text())
    assert all(re.fullmatch(r"\S+@[0-9a-f]{40}", one) for one in used)
    count = len(jobs["play"]["strategy"]["matrix"]["shard"])
    play = next(script for script in scripts if "--shard" in script)
    assert f'--shard "$SHARD/{count}" --out "shards/$SHARD"' in play
    assert str(parse_shard(f"1/{count}")) == f"shard 1 of {count}"
    assert jobs["merge"]["needs"] == "play"
    assert scripts[-1] == "pjpdaf-bench merge shards/* --out runs/whole"


def test_the_example_uses_only_inputs_that_there_are():
    inputs = read(ACTION)["inputs"]
    steps = read(GITHUB)["jobs"]["gate"]["steps"]
    given = next(s for s in steps if "OWNER/" in s.get("uses", ""))["with"]
    assert set(given) <= set(inputs)
    assert all("default" in one and one["description"] for one in inputs.values())
    used = set(re.findall(r"inputs\.([\w-]+)", ACTION.read_text()))
    assert used == set(inputs)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where the play step of the action has been run, with our own example as the tracker."""
    folder = tmp_path_factory.mktemp("ci")
    (folder / "own_tracker.py").write_text((ROOT / "examples/own_tracker.py").read_text())
    done = shell(
        step("Play")["run"],
        folder,
        TARGETS="cross",
        TRACKER="own_tracker:NearestBlob",
        DETECTOR="default",
        OPTIONS=TINY,
        OUT="runs/mine",
    )
    assert done.returncode == 0, done.stderr
    done = shell("pjpdaf-bench baseline runs/mine base", folder)
    assert done.returncode == 0, done.stderr
    return folder


def compared(folder, baseline, out, margins="", allow="false"):
    for name in ("output", "summary"):
        (folder / name).write_text("")
    done = shell(
        step("Compare")["run"],
        folder,
        BASELINE=baseline,
        OUT=out,
        MARGINS=margins,
        ALLOW_INCONCLUSIVE=allow,
        GITHUB_OUTPUT=str(folder / "output"),
        GITHUB_STEP_SUMMARY=str(folder / "summary"),
    )
    return done, (folder / "output").read_text(), (folder / "summary").read_text()


def test_the_action_plays_a_tracker_of_ones_own_and_passes_it(folder):
    done, output, summary = compared(folder, "base", "runs/mine")
    assert done.returncode == 0, done.stderr
    assert output == "verdict=pass\n"
    assert "✅ identical" in summary


def test_the_action_fails_on_a_faulty_margin_and_keeps_the_exit_code(folder):
    (folder / "margins.yaml").write_text("margins: {eror_mm: 1}\n")
    done, output, _ = compared(folder, "base", "runs/mine", "margins.yaml")
    assert done.returncode == 2
    assert "no metric 'eror_mm'" in done.stderr
    assert output == ""


def test_gitlabs_script_does_the_same(folder):
    job = read(GITLAB)["tracking"]
    lines = "\n".join(job["script"]).replace("run $TARGETS", f"run $TARGETS {TINY}")
    variables = {**job["variables"], "TARGETS": "cross", "BASELINE": "base"}
    variables["TRACKER"] = "own_tracker:NearestBlob"
    done = shell(lines, folder, **variables)
    assert done.returncode == 0, done.stderr
    assert (folder / job["artifacts"]["reports"]["junit"]).is_file()
    assert "pass: all 1 episodes" in done.stdout
