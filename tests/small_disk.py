"""A disk of a few kilobytes, for tests that fill it."""

import subprocess

import pytest


def in_a_small_disk(script, size="3m"):
    """The finished process of a shell script, to which /mnt is a new disk of this size."""
    words = ["unshare", "-Urm", "sh", "-c", f"mount -t tmpfs -o size={size} none /mnt && {script}"]
    return subprocess.run(words, capture_output=True, text=True, check=False)


needs_small_disk = pytest.mark.skipif(
    in_a_small_disk("true").returncode != 0, reason="cannot mount here"
)
