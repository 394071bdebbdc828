"""The digest covers all code that draws, and no code of detectors and trackers."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import sim
from scenarios.cache.sources import (
    DETECTOR,
    FILM,
    SCENE,
    files_of,
    simulator_digest,
    simulator_files,
    sources_digest,
)

ROOT = Path(sim.__file__).parent.parent
IMPORTED = """
import json, sys
import scenarios.spec.draw, sim.sequence, sim.recording.recorder
packages = ("sim", "scenarios", "reports", "pjpdaf")
files = [m.__file__ for n, m in sys.modules.items() if n.partition(".")[0] in packages]
print(json.dumps([file for file in files if not file.endswith("__init__.py")]))
"""


# What `scenarios/spec/corpus_case.py` loads to know the names of events.
NO_PICTURE = {
    "pjpdaf/interfaces.py",
    "pjpdaf/looks.py",
    *(f"reports/score/{name}.py" for name in ("events", "records", "robustness", "score")),
}


def test_all_that_draws_is_covered():
    done = subprocess.run(
        [sys.executable, "-c", IMPORTED], capture_output=True, text=True, cwd=ROOT
    )
    imported = {Path(file).relative_to(ROOT).as_posix() for file in json.loads(done.stdout)}
    assert len(imported) > 80
    assert imported - {*simulator_files(ROOT)} <= NO_PICTURE


# What these import for types and for words that they do not draw.
NO_FILM = {
    *(f"pjpdaf/{name}.py" for name in ("interfaces", "looks", "targets")),
    *("sim/truth.py", "sim/event_names.py"),
}
DERIVED = {
    "detections": (DETECTOR, "pjpdaf.detector.blob_detector, pjpdaf.detector.external", set()),
    "scenes": (SCENE, "pjpdaf.detector.still_scene", set()),
    "films": (FILM, "reports.pictures.stills", NO_FILM),
}


@pytest.mark.parametrize("kind", DERIVED)
def test_all_that_is_kept_beside_footage_is_covered(kind):
    names, modules, others = DERIVED[kind]
    code = IMPORTED.replace("scenarios.spec.draw, sim.sequence, sim.recording.recorder", modules)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    imported = {Path(file).relative_to(ROOT).as_posix() for file in json.loads(done.stdout)}
    assert len(imported) > 5
    assert imported - {*files_of(names)} <= others
    assert all((ROOT / name).exists() for name in names)


def test_detectors_and_trackers_are_not():
    files = {*simulator_files(ROOT)}
    assert not any(f.startswith(("pjpdaf/detector", "pjpdaf/tracker", "reports")) for f in files)
    assert not any("__pycache__" in file for file in files)


@pytest.fixture
def copied(tmp_path):
    for package in ("sim", "pjpdaf", "scenarios"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / package, tmp_path / package, ignore=ignored)
    assert sources_digest(tmp_path) == simulator_digest()
    return tmp_path


CHANGED = (
    *(f"sim/camera/{name}.py" for name in ("render", "shader", "shadow_map", "still", "sensor")),
    *("sim/motion/curves.py", "scenarios/spec/cameras.py"),
)
KEPT = ("sim/dataset/writer.py", "pjpdaf/tracker/jpda.py", "scenarios/run/run.py")


def test_a_changed_simulator_has_another_digest(copied):
    for file in CHANGED:
        path = copied / file
        text = path.read_bytes()
        path.write_bytes(text + b"\n")
        assert sources_digest(copied) != simulator_digest()
        path.write_bytes(text)
    (copied / "sim" / "new.py").write_text("")
    assert sources_digest(copied) != simulator_digest()
    (copied / "sim" / "new.py").unlink()
    for file in KEPT:
        (copied / file).write_text("changed")
    assert sources_digest(copied) == simulator_digest()
