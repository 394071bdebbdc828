"""The software that decides results: our code, plug-ins, versions of libraries."""

from __future__ import annotations

import functools
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from pjpdaf.plugins.registry import DETECTORS, TRACKERS
from pjpdaf.presets.registry import PRESETS
from reports.run.provenance import PACKAGES, versions
from scenarios.execute.code_digest import code_digest, plug_in_digest
from scenarios.spec.motion.plugged import trust
from sim.families.plugged import MOTIONS

OUR_CODE = "the code of pjpdaf-bench"
SHOWN = 8  # characters of a digest in a message


@dataclass(frozen=True)
class PlugIns:
    """Detectors, trackers and motions that tasks need.

    folder: where their modules may lie, beside the usual path; "" for none.
    """

    detectors: tuple[str, ...] = ()
    trackers: tuple[str, ...] = ()
    folder: str = ""
    motions: tuple[str, ...] = ()

    @staticmethod
    def named(detector: str | None, *trackers: str) -> PlugIns:
        """Plug-ins of these names, which may lie in the current folder.

        Presets are none. detector: None where detections come from files.
        """
        own = [name for name in (detector,) if name is not None and name not in PRESETS]
        others = [name for name in trackers if name not in PRESETS]
        here = any(":" in name for name in (*own, *others))
        return PlugIns(tuple(own), tuple(others), str(Path.cwd()) if here else "")

    def with_motions(self, names: Iterable[str]) -> PlugIns:
        """The same, and motions of these names, which may lie in the current folder."""
        motions = tuple(sorted({*names}))
        here = any(":" in name for name in motions)
        folder = self.folder or (str(Path.cwd()) if here else "")
        return replace(self, folder=folder, motions=motions)


@functools.cache
def software(plug_ins: PlugIns) -> Mapping[str, str]:
    """The software of this process: version or digest by name, "" for a plug-in that is missing.

    The folder of the plug-ins is put last on the path for imports, and motions are trusted, as the
    user who sends the tasks does.
    """
    if plug_ins.folder and plug_ins.folder not in sys.path:
        sys.path.append(plug_ins.folder)
    named = [(name, DETECTORS, "detector") for name in plug_ins.detectors]
    named += [(name, TRACKERS, "tracker") for name in plug_ins.trackers]
    named += [(name, MOTIONS, "motion") for name in plug_ins.motions]
    trust(*plug_ins.motions)
    digests = {f"{kind} {name!r}": plug_in_digest(name, group) for name, group, kind in named}
    return {OUR_CODE: code_digest(), **versions(), **digests}


def differences(theirs: Mapping[str, str], ours: Mapping[str, str]) -> str:
    """Where the software of another process differs from that of ours; "" where it is the same."""
    texts = []
    for name, version in ours.items():
        there = theirs.get(name, "")
        if there == version:
            continue
        shorten = name not in ("python", *PACKAGES)
        had, has = (v[:SHOWN] if shorten else v for v in (there, version))
        texts.append(f"{name} {had or 'missing'}, here {has}")
    return "; ".join(texts)
