"""The files of a data set: present, missing, superfluous or damaged."""

from __future__ import annotations

import os
import stat
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from sim.dataset.check.fault import MISSING, Fault, FaultLog
from sim.dataset.files.checksums import read_sums, sha256_of
from sim.dataset.files.layout import CHECKSUMS, LABELS, frames_with, picture_name
from sim.scene.world import CAMERAS


@dataclass(frozen=True)
class FileTree:
    """Files below a folder, by relative path. plain: plain files; special: links, pipes and the
    like, which are never opened.
    """

    root: Path
    plain: frozenset[str]
    special: frozenset[str]

    def names(self, folder: str) -> set[str]:
        """Names of the plain files directly in a folder."""
        start = f"{folder}/"
        inside = (path.removeprefix(start) for path in self.plain if path.startswith(start))
        return {name for name in inside if "/" not in name}


def tree_of(root: Path) -> FileTree:
    """All files below a folder; links are not followed."""
    plain, special = set(), set()
    for where, folders, files in os.walk(root):
        for name in (*folders, *files):
            path = Path(where, name)
            mode = path.lstat().st_mode
            if stat.S_ISREG(mode):
                plain.add(path.relative_to(root).as_posix())
            elif not stat.S_ISDIR(mode):
                special.add(path.relative_to(root).as_posix())
    return FileTree(root, frozenset(plain), frozenset(special))


@dataclass(frozen=True)
class Checksums:
    """digests: path -> SHA-256 in the files SHA256SUMS, of which two may name the same path."""

    digests: Mapping[str, frozenset[str]]


def read_checksums(tree: FileTree, folders: Collection[str], log: FaultLog) -> Checksums:
    """Read SHA256SUMS of these folders, and of the top level if there is one."""
    digests: dict[str, set[str]] = {}
    for folder in ("", *folders):
        path = f"{folder}/{CHECKSUMS}" if folder else CHECKSUMS
        if path not in tree.plain:
            if folder:
                log.add("files", [Fault(path, MISSING)])
            continue
        listed = log.read(partial(read_sums, tree.root / path))
        for name, digest in (listed or {}).items():
            digests.setdefault(f"{folder}/{name}" if folder else name, set()).add(digest)
    return Checksums({path: frozenset(both) for path, both in digests.items()})


def check_listing(
    tree: FileTree, checksums: Checksums, folders: Collection[str]
) -> Iterator[Fault]:
    """Check that the plain files are those that the checksums list."""
    for path in sorted(tree.special):
        yield Fault(path, "is a link or a special file; a data set has only plain files")
    for path in sorted(set(checksums.digests) - tree.plain - tree.special):
        yield Fault(path, MISSING)
    whole = CHECKSUMS in tree.plain
    for path in sorted(tree.plain - set(checksums.digests)):
        folder, _, name = path.rpartition("/")
        if name == CHECKSUMS and (not folder or folder in folders):
            continue
        # Without a list of the top level, only the sequences' own files must be listed.
        if whole or path.partition("/")[0] in folders or path.startswith("."):
            yield Fault(path, f"is listed in no {CHECKSUMS}")


def check_digests(tree: FileTree, checksums: Checksums, paths: Collection[str]) -> Iterator[Fault]:
    """Check the SHA-256 of these files."""
    for path in sorted(paths):
        wanted = checksums.digests.get(path)
        if wanted is None or path not in tree.plain:
            continue
        try:
            digest = sha256_of(tree.root / path)
        except OSError as error:
            yield Fault(path, f"cannot be read: {error.strerror}")
            continue
        if wanted != {digest}:
            yield Fault(path, f"is not the file that {CHECKSUMS} names (its SHA-256 differs)")


def check_completeness(
    tree: FileTree,
    name: str,
    frames: int,
    backgrounds: int,
    labels: Collection[str],
    arrived: Sequence[Sequence[bool]] | None,
) -> Iterator[Fault]:
    """Check that every frame has its pictures and labels, and that no file is superfluous.

    arrived: per frame and view, None where the tables are damaged.
    """
    for v, camera in enumerate(CAMERAS):
        wanted = {picture_name(i) for i in range(backgrounds)}
        folder = f"{name}/background_{camera}"
        yield from _differences(folder, wanted, tree.names(folder), "of no background frame")
        has_picture = [arrived is None or arrived[i][v] for i in range(frames)]
        wanted = {picture_name(i) for i in range(frames) if has_picture[i]}
        there = tree.names(f"{name}/{camera}")
        for i in range(frames):
            if not has_picture[i] and picture_name(i) in there:
                there.remove(picture_name(i))
                yield Fault(
                    f"{name}/{camera}/{picture_name(i)}",
                    "is there, but truth.parquet says that this picture did not arrive",
                )
        yield from _differences(f"{name}/{camera}", wanted, there, "of no frame")
    for label, folders in LABELS.items():
        suffix = ".npz" if label == "float" else ".png"
        named = label in labels
        superfluous = "of no frame" if named else "of a label that manifest.json does not name"
        for folder in folders:
            framed = frames_with(folder, frames) if named else ()
            wanted = {picture_name(i, suffix) for i in framed}
            path = f"{name}/{folder}"
            yield from _differences(path, wanted, tree.names(path), superfluous)


def check_repetition(tree: FileTree, name: str, checksums: Checksums) -> Iterator[Fault]:
    """Check that no picture repeats another frame's byte for byte where the masks differ."""
    for camera in CAMERAS:
        first: dict[frozenset[str], str] = {}
        for file in sorted(tree.names(f"{name}/{camera}")):
            digest = checksums.digests.get(f"{name}/{camera}/{file}")
            if digest is None:
                continue
            other = first.setdefault(digest, file)
            masks = [
                checksums.digests.get(f"{name}/seg_{camera}/{name_}") for name_ in (file, other)
            ]
            if masks[0] is not None and masks[0] != masks[1]:
                yield Fault(
                    f"{name}/{camera}/{file}",
                    f"is the very picture {camera}/{other}, though the masks of the two differ",
                )


def _differences(
    folder: str, wanted: set[str], there: set[str], superfluous: str
) -> Iterator[Fault]:
    for name in sorted(wanted - there):
        yield Fault(f"{folder}/{name}", MISSING)
    for name in sorted(there - wanted):
        yield Fault(f"{folder}/{name}", f"is {superfluous}")
