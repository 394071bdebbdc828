"""The option `--skin-sample`: a picture that is cropped to skin."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from pjpdaf.detector.skin import learn_skin_range
from pjpdaf.errors import BenchError
from pjpdaf.picture_files import read_picture

HEAD = "head"  # instead of a picture: learn from the head in the first frames


def skin_of_sample(sample: Path | None) -> dict[str, Any]:
    """Learn the skin range from a picture; returns detector parameters. Raises BenchError.

    No parameters for None, and for `HEAD`, where the footage has to teach them.
    """
    if sample is None or sample == Path(HEAD):
        return {}
    if not sample.is_file():
        raise BenchError(f"{sample}: no such skin sample; give a picture cropped to skin.")
    picture = read_picture(sample)
    if picture is None:
        raise BenchError(f"{sample}: cannot be read as a picture.")
    try:
        skin = learn_skin_range(picture)
    except BenchError as fault:
        raise fault.reworded(f"{sample}: {fault}") from None
    return asdict(skin)
