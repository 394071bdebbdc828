"""A small data set of four sequences, two of twins and two with a clip, made once a session."""

import hashlib
from pathlib import Path

from shared import shared

from scenarios.dataset.make import make_dataset
from scenarios.dataset.sequence_plan import MakeRequest
from scenarios.play.recipe import SequenceSettings

SMALL = SequenceSettings(("depth", "seg"), (96, 72))


def request(out, **changes):
    """The request of `dataset make` for this data set, with changes."""
    options = {
        "targets": ("cross", "recorded"),
        "seeds": 2,
        "first_seed": 100,
        "settings": ("frames=4", "background_frames=2"),
        "labels": SMALL,
        "jobs": 1,
    }
    return MakeRequest(out=out, **(options | changes))


def made_dataset(tmp_path_factory):
    """Its folder; read only."""
    return shared(tmp_path_factory, "made", lambda f: make_dataset(request(f / "set"))) / "set"


def contents(folder):
    """The SHA-256 of each file by its path below the folder."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(Path(folder).rglob("*"))
        if path.is_file()
    }
