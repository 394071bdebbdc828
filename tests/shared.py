"""Folders that are costly to make, made once for all test processes of a session."""

import fcntl
import os
import shutil

import pytest


def shared(tmp_path_factory, name, make):
    """The folder that `make(folder)` fills, whichever process comes first; read only."""
    base = tmp_path_factory.getbasetemp()
    root = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    folder, part = root / f"shared-{name}", root / f"part-{name}"
    with (root / f"{name}.lock").open("w") as stream:
        fcntl.flock(stream, fcntl.LOCK_EX)
        if not folder.exists():
            shutil.rmtree(part, ignore_errors=True)
            part.mkdir()
            make(part)
            part.rename(folder)
    return folder


def copied(made):
    """A fixture: a copy of the folder that the fixture named `made` gives, for a test to damage."""

    @pytest.fixture
    def copy(request, tmp_path):
        shutil.copytree(request.getfixturevalue(made), tmp_path / "copy")
        return tmp_path / "copy"

    return copy
