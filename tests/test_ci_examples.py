"""The action and the examples for CI: well-formed, pinned; their steps do what they say."""

import json
import os
import re
import shutil
import subprocess
import sys
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import ClassVar
from urllib.parse import parse_qs, urlparse

import pytest
from ruamel.yaml import YAML
from shared import shared

from scenarios.run.request import parse_shard

ROOT = Path(__file__).parents[1]
ACTION = ROOT / ".github/actions/pjpdaf-bench/action.yml"
SHARDS = ROOT / "examples/ci/github-shards.yml"
GITHUB, GITLAB = ROOT / "examples/ci/github.yml", ROOT / "examples/ci/gitlab-ci.yml"
COMMENT = ROOT / "examples/ci/comment.py"
TINY = "--seeds 1 --set frames=2 --set background_frames=2 --jobs 1"
TINY += " --set detector.background_learn_min=2"


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
    env |= {"PJPDAF_BENCH_CACHE": str(folder / "cache")}  # which the action keeps between runs
    words = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", script]
    return subprocess.run(
        words, cwd=folder, env=env | variables, capture_output=True, text=True, check=False
    )


def step(name):
    return next(s for s in read(ACTION)["runs"]["steps"] if s.get("name") == name)


def test_every_shell_step_is_bash():
    scripts = [s["run"] for s in read(ACTION)["runs"]["steps"] if "run" in s]
    gitlab = read(GITLAB)["tracking"]
    scripts += gitlab["before_script"] + gitlab["script"]
    for script in scripts:
        done = subprocess.run(["bash", "-n"], input=script, capture_output=True, text=True)
        assert done.returncode == 0, (script, done.stderr)
        assert "${{" not in script  # a value put into a script is a script


def test_actions_are_pinned_to_those_of_our_own_ci():
    ours = re.findall(r"uses: (\S+@\S+)", (ROOT / ".github/workflows/ci.yml").read_text())
    used = re.findall(r"uses: (\S+@\S+)", GITHUB.read_text() + ACTION.read_text())
    (place,) = (one for one in used if one.startswith("OWNER/pjpdaf-bench/"))
    theirs = set(used) - {place}
    assert len(theirs) == 4
    assert theirs <= set(ours)
    assert all(re.fullmatch(r"\S+@[0-9a-f]{40}", one) for one in theirs)
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


def played(folder, tracker, out, baseline="base"):
    """Run the play step of the action."""
    return shell(
        step("Play")["run"],
        folder,
        TARGETS="cross",
        TRACKER=tracker,
        DETECTOR="default",
        OPTIONS=TINY,
        OUT=out,
        BASELINE=baseline,
    )


def play_and_accept(folder):
    """Run the play step of the action with our own example as the tracker; its run is the base."""
    (folder / "own_tracker.py").write_text((ROOT / "examples/own_tracker.py").read_text())
    done = played(folder, "own_tracker:NearestBlob", "runs/mine")
    assert done.returncode == 0, done.stderr
    done = shell("pjpdaf-bench baseline accept runs/mine base", folder)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where the play step has been run."""
    once = shared(tmp_path_factory, "ci", play_and_accept)
    return Path(shutil.copytree(once, tmp_path_factory.mktemp("ci") / "folder"))


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


@pytest.mark.long
def test_the_action_plays_a_tracker_of_ones_own_and_passes_it(folder):
    done, output, summary = compared(folder, "base", "runs/mine")
    assert done.returncode == 0, done.stderr
    assert output == "verdict=pass\n"
    assert "✅ identical" in summary
    assert "Gate passed" in (folder / "runs/mine/report.html").read_text(encoding="utf-8")


@pytest.mark.long
def test_the_action_fails_on_a_faulty_margin_and_keeps_the_exit_code(folder):
    (folder / "margins.yaml").write_text("margins: {eror_mm: 1}\n")
    done, output, _ = compared(folder, "base", "runs/mine", "margins.yaml")
    assert done.returncode == 2
    assert "No metric 'eror_mm'. Did you mean 'error_mm'?" in done.stderr
    assert output == ""


@pytest.mark.long
@pytest.mark.parametrize(("allow", "code"), [("true", 0), ("false", 3)])
def test_inconclusive_is_a_warning_of_the_action_unless_it_shall_fail(folder, allow, code):
    if not (folder / "runs/other").exists():
        assert played(folder, "default", "runs/other").returncode == 0
    done, output, summary = compared(folder, "base", "runs/other", allow=allow)
    assert (done.returncode, output) == (code, "verdict=inconclusive\n"), done.stderr
    assert "inconclusive" in summary
    assert read(ACTION)["inputs"]["allow-inconclusive"]["default"] == "true"
    assert read(GITLAB)["tracking"]["allow_failure"]["exit_codes"] == 3


@pytest.mark.long
def test_episodes_without_a_result_end_the_action_unless_they_are_compared(folder):
    (folder / "broken.py").write_text(
        "from own_tracker import NearestBlob\n\n\nclass Broken(NearestBlob):\n"
        "    def step(self, state, seen, dt_s):\n        raise RuntimeError\n"
    )
    assert played(folder, "broken:Broken", "runs/alone", baseline="").returncode == 5
    done = played(folder, "broken:Broken", "runs/broken")
    assert done.returncode == 0
    assert "::warning::pjpdaf-bench: some episodes gave no result" in done.stdout
    done, output, _ = compared(folder, "base", "runs/broken")
    assert (done.returncode, output) == (1, "verdict=fail\n"), done.stderr


def test_the_cache_of_the_action_has_a_key_of_what_is_played(folder):
    (folder / "mine.yaml").write_text("a: 1\n")

    def key(targets, options=""):
        (folder / "output").write_text("")
        done = shell(
            step("Name the cache")["run"],
            folder,
            TARGETS=targets,
            OPTIONS=options,
            GITHUB_OUTPUT=str(folder / "output"),
            GITHUB_ACTION_PATH=str(ACTION.parent),
        )
        assert done.returncode == 0, done.stderr
        return (folder / "output").read_text()

    first = key("core mine.yaml")
    assert re.fullmatch(r"key=pjpdaf-bench-[0-9a-f]{16}\n", first)
    assert key("core mine.yaml") == first
    assert key("core mine.yaml", "--seeds 2") != first
    (folder / "mine.yaml").write_text("a: 2\n")
    assert key("core mine.yaml") != first


class Forge(BaseHTTPRequestHandler):
    """The comments of one pull request, as GitHub and GitLab serve them."""

    comments: ClassVar[dict[int, str]] = {}
    refuse = False

    def _answer(self, value, code=200):
        self.send_response(code)
        self.end_headers()
        self.wfile.write(json.dumps(value).encode())

    def _body(self):
        return json.loads(self.rfile.read(int(self.headers["Content-Length"])))["body"]

    def do_GET(self):
        at = int(parse_qs(urlparse(self.path).query)["page"][0])
        rows = [{"id": k, "body": v} for k, v in self.comments.items()]
        self._answer(rows[100 * (at - 1) : 100 * at])

    def do_POST(self):
        text = self._body()
        if self.refuse:
            return self._answer({}, 403)
        self.comments[len(self.comments) + 1] = text
        return self._answer({}, 201)

    def replace(self):
        self.comments[int(self.path.rsplit("/", 1)[1])] = self._body()
        self._answer({})

    do_PATCH = do_PUT = replace  # noqa: N815 - names of the base class

    def log_message(self, *_):
        pass


@pytest.fixture
def forge():
    Forge.comments, Forge.refuse = dict.fromkeys(range(1, 121), "of somebody"), False
    server = ThreadingHTTPServer(("127.0.0.1", 0), Forge)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.mark.parametrize("kind", ["github", "gitlab"])
def test_the_verdict_becomes_one_comment_which_the_next_run_replaces(tmp_path, forge, kind):
    event, summary = tmp_path / "event.json", tmp_path / "runs/tracking/summary.md"
    event.write_text('{"pull_request": {"number": 7}}')
    summary.parent.mkdir(parents=True)
    github = {"GITHUB_API_URL": forge, "GITHUB_EVENT_PATH": str(event), "GITHUB_TOKEN": "t"}
    gitlab = {"CI_API_V4_URL": forge, "CI_PROJECT_ID": "9", "CI_MERGE_REQUEST_IID": "7"}
    env = {
        "github": github | {"GITHUB_REPOSITORY": "me/mine"},
        "gitlab": gitlab | {"GITLAB_TOKEN": "t"},
    }[kind]

    def comment(**changed):
        words = [sys.executable, str(COMMENT), "runs/tracking/summary.md"]
        done = subprocess.run(
            words, cwd=tmp_path, env=env | changed, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        return done.stderr

    for text, line in (("first ✅", "comment written\n"), ("second ❌", "comment replaced\n")):
        summary.write_text(text, encoding="utf-8")
        assert comment() == line
        assert len(Forge.comments) == 121
        assert Forge.comments[121].endswith(f"\n{text}")
        assert Forge.comments[1] == "of somebody"
    token = f"{kind.upper()}_TOKEN"
    assert f"no {token}" in comment(**{token: ""})
    Forge.comments.popitem()
    Forge.refuse = True
    assert "403" in comment()
    api = "GITHUB_API_URL" if kind == "github" else "CI_API_V4_URL"
    assert "no comment: " in comment(**{api: "http://127.0.0.1:1"})


@pytest.mark.long
def test_gitlabs_script_does_the_same(folder):
    job = read(GITLAB)["tracking"]
    lines = "\n".join(job["script"]).replace("run $TARGETS", f"run $TARGETS {TINY}")
    variables = {**job["variables"], "TARGETS": "cross", "BASELINE": "base"}
    variables["TRACKER"] = "own_tracker:NearestBlob"
    tools = folder / "tools"
    tools.mkdir(exist_ok=True)
    if not (tools / "pjpdaf-bench").exists():
        (tools / "pjpdaf-bench").symlink_to(ROOT)  # as a submodule stands there
    done = shell(lines, folder, **variables)
    assert done.returncode == 0, done.stderr
    assert (folder / job["artifacts"]["reports"]["junit"]).is_file()
    assert "pass: the same results as the base, bit for bit (1 paired episode)" in done.stdout
    assert "Gate passed" in (folder / variables["OUT"] / "report.html").read_text(encoding="utf-8")
