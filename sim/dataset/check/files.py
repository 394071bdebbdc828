"""The files of a data set: which are there, which should be, whether their checksums hold."""

from __future__ import annotations

import os
import stat
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pjpdaf.errors import BenchError
from sim.dataset.check.fault import MISSING, Fault, fault_of
from sim.dataset.files.checksums import read_sums, sha256_of
from sim.dataset.files.layout import CHECKSUMS, LABELS, picture_name
from sim.scene.world import CAMERAS

PICTURES = (*CAMERAS, *(f"background_{camera}" for camera in CAMERAS))


@dataclass(frozen=True)
class Tree:
    """plain: the plain files below a folder, by relative path; odd: what is neither file nor folder
    (links, pipes): never opened.
    """

    root: Path
    plain: frozenset[str]
    odd: frozenset[str]

    def names(self, folder: str) -> set[str]:
        """Names of the plain files right in a folder."""
        start = f"{folder}/"
        inside = (path.removeprefix(start) for path in self.plain if path.startswith(start))
        return {name for name in inside if "/" not in name}


def tree_of(root: Path) -> Tree:
    """All files below a folder; links are not followed."""
    plain, odd = set(), set()
    for where, folders, files in os.walk(root):
        for name in (*folders, *files):
            path = Path(where, name)
            mode = path.lstat().st_mode
            if stat.S_ISREG(mode):
                plain.add(path.relative_to(root).as_posix())
            elif not stat.S_ISDIR(mode):
                odd.add(path.relative_to(root).as_posix())
    return Tree(root, frozenset(plain), frozenset(odd))


@dataclass(frozen=True)
class Sums:
    """digests: path -> SHA-256 as the files SHA256SUMS have it; faults: of these files."""

    digests: Mapping[str, frozenset[str]]
    faults: tuple[Fault, ...]


def sums_of(tree: Tree, folders: Collection[str]) -> Sums:
    """What the top level's SHA256SUMS says, if there is one, and those of these folders."""
    digests: dict[str, set[str]] = {}
    faults = []
    for folder in ("", *folders):
        path = f"{folder}/{CHECKSUMS}" if folder else CHECKSUMS
        if path not in tree.plain:
            if folder:
                faults.append(Fault(path, MISSING))
            continue
        try:
            listed = read_sums(tree.root / path)
        except BenchError as error:
            faults.append(fault_of(error, tree.root))
            continue
        for name, digest in listed.items():
            digests.setdefault(f"{folder}/{name}" if folder else name, set()).add(digest)
    return Sums({path: frozenset(found) for path, found in digests.items()}, tuple(faults))


def listing_faults(tree: Tree, sums: Sums, folders: Collection[str]) -> Iterator[Fault]:
    """Files that are listed and missing, there and not listed, or no files."""
    for path in sorted(tree.odd):
        yield Fault(path, "is a link or a special file; a data set has only plain files")
    for path in sorted(set(sums.digests) - tree.plain - tree.odd):
        yield Fault(path, MISSING)
    whole = CHECKSUMS in tree.plain
    for path in sorted(tree.plain - set(sums.digests)):
        folder, _, name = path.rpartition("/")
        if name == CHECKSUMS and (not folder or folder in folders):
            continue
        # Without a list of the top level, only the sequences' own files must be listed.
        if whole or path.partition("/")[0] in folders or path.startswith("."):
            yield Fault(path, f"is listed in no {CHECKSUMS}")


def damaged(tree: Tree, sums: Sums, paths: Collection[str]) -> Iterator[Fault]:
    """Those of the files that are not what the lists say."""
    for path in sorted(paths):
        wanted = sums.digests.get(path)
        if wanted is None or path not in tree.plain:
            continue
        try:
            found = sha256_of(tree.root / path)
        except OSError as error:
            yield Fault(path, f"cannot be read: {error.strerror}")
            continue
        if wanted != {found}:
            yield Fault(path, f"is not the file that {CHECKSUMS} names (its SHA-256 differs)")


def completeness_faults(
    tree: Tree,
    name: str,
    frames: int,
    backgrounds: int,
    labels: Collection[str],
    arrived: Sequence[Sequence[bool]] | None,
) -> Iterator[Fault]:
    """Pictures and labels of a sequence that are missing, or are of no frame.

    arrived: per frame and view, None where that is not known.
    """
    for v, camera in enumerate(CAMERAS):
        wanted = {picture_name(i) for i in range(backgrounds)}
        yield from _compared(tree, f"{name}/background_{camera}", wanted, "of no background frame")
        came = [arrived is None or arrived[i][v] for i in range(frames)]
        wanted = {picture_name(i) for i in range(frames) if came[i]}
        there = tree.names(f"{name}/{camera}")
        for i in range(frames):
            if not came[i] and picture_name(i) in there:
                there.remove(picture_name(i))
                yield Fault(
                    f"{name}/{camera}/{picture_name(i)}",
                    "is there, but truth.parquet says that this picture did not arrive",
                )
        yield from _differences(f"{name}/{camera}", wanted, there, "of no frame")
    for label, folders in LABELS.items():
        suffix = ".npz" if label == "float" else ".png"
        named = label in labels
        wanted = {picture_name(i, suffix) for i in range(frames)} if named else set()
        without = "of no frame" if named else "of a label that manifest.json does not name"
        for folder in folders:
            yield from _compared(tree, f"{name}/{folder}", wanted, without)


def twice_faults(tree: Tree, name: str, sums: Sums) -> Iterator[Fault]:
    """Pictures that are those of another frame byte for byte, where the masks are not."""
    for camera in CAMERAS:
        first: dict[frozenset[str], str] = {}
        for file in sorted(tree.names(f"{name}/{camera}")):
            digest = sums.digests.get(f"{name}/{camera}/{file}")
            if digest is None:
                continue
            other = first.setdefault(digest, file)
            masks = [sums.digests.get(f"{name}/seg_{camera}/{one}") for one in (file, other)]
            if masks[0] is not None and masks[0] != masks[1]:
                yield Fault(
                    f"{name}/{camera}/{file}",
                    f"is the very picture {camera}/{other}, though the masks of the two differ",
                )


def _compared(tree: Tree, folder: str, wanted: set[str], without: str) -> Iterator[Fault]:
    yield from _differences(folder, wanted, tree.names(folder), without)


def _differences(folder: str, wanted: set[str], there: set[str], without: str) -> Iterator[Fault]:
    for name in sorted(wanted - there):
        yield Fault(f"{folder}/{name}", MISSING)
    for name in sorted(there - wanted):
        yield Fault(f"{folder}/{name}", f"is {without}")
