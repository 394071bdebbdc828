"""Names of pictures: their order, and which belong together in two views."""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from pathlib import Path

Key = Hashable


@dataclass(frozen=True)
class Pairing:
    """Files of both views, moment by moment, None = missing; note: a doubt in words, or "".

    in_order: the names do not say what belongs together, so the views must be equally long.
    """

    pairs: tuple[tuple[Path | None, Path | None], ...]
    in_order: bool
    note: str = ""


def natural_key(name: str) -> tuple[tuple[int, int, str], ...]:
    """Key that sorts 'f2' before 'f10': digits by value, text without case."""
    pieces = re.split(r"([0-9]+)", name)
    return tuple((1, int(p[-300:]), "") if p.isdecimal() else (0, 0, p.lower()) for p in pieces)


def in_natural_order(files: Sequence[Path]) -> tuple[Path, ...]:
    """The files in natural order of their whole names."""
    return tuple(sorted(files, key=lambda f: (natural_key(f.name), f.name)))


def order_doubt(files: Sequence[Path]) -> str:
    """Words where names are decimal numbers whose order is another; "" where there is no doubt."""
    numbers = [re.fullmatch(r"\D*(\d{1,30}\.\d{1,30})", file.stem) for file in files]
    if not all(numbers):
        return ""
    decimals = [float(match[1]) for match in numbers if match]
    for k in range(len(decimals) - 1):
        if decimals[k] > decimals[k + 1]:
            return (
                f"{files[k].name} is taken to come before {files[k + 1].name}; as decimal numbers "
                "they come the other way round: if they are times, give all the same number of "
                "decimals"
            )
    return ""


def paired(left: Sequence[Path], right: Sequence[Path]) -> Pairing:
    """Pair files by their whole names, else by all numbers in them, else in order.

    A name that is in one view only has a missing picture beside it. Names are trusted where more
    than half of them are in both views: fewer, and these are two numberings.
    """
    doubt = order_doubt(left) or order_doubt(right)
    ways: tuple[Callable[[], tuple[list[Key], list[Key]]], ...] = (
        lambda: ([f.stem for f in left], [f.stem for f in right]),
        lambda: _numbers(left, right),
    )
    for keys_of in ways:
        keys = keys_of()
        files = [dict(zip(k, f, strict=True)) for k, f in zip(keys, (left, right), strict=True)]
        if len(files[0]) < len(left) or len(files[1]) < len(right):
            continue  # a key that two files of a view have
        common, union = files[0].keys() & files[1].keys(), files[0].keys() | files[1].keys()
        if 2 * len(common) > len(union):
            names = {key: (files[0].get(key) or files[1][key]).name for key in union}
            ordered = sorted(union, key=lambda key: (natural_key(names[key]), names[key]))
            return Pairing(
                tuple((files[0].get(key), files[1].get(key)) for key in ordered), False, doubt
            )
    if left and right and not doubt:
        doubt = (
            f"the names of the two views do not belong together ({left[0].name}, {right[0].name} "
            "...): they are paired in order"
        )
    return Pairing(tuple(zip(left, right, strict=False)), True, doubt)


def _numbers(left: Sequence[Path], right: Sequence[Path]) -> tuple[list[Key], list[Key]]:
    """All numbers of each name, but for those that tell the views apart (cam1, cam2).

    Names with unlike counts of numbers get one key, which is then no key.
    """
    views = [[tuple(map(int, re.findall(r"\d{1,300}", f.stem))) for f in v] for v in (left, right)]
    counts = {len(numbers) for view in views for numbers in view}
    if counts == {0} or len(counts) != 1:
        return [0] * len(left), [0] * len(right)
    kept = []
    for k in range(counts.pop()):
        values = [{numbers[k] for numbers in view} for view in views]
        if not (len(values[0]) == len(values[1]) == 1 and values[0] != values[1]):
            kept.append(k)
    keys: list[list[Key]] = [[tuple(n[k] for k in kept) for n in view] for view in views]
    return keys[0], keys[1]
