"""The table of a data set's card that compares its spread with a uniform one."""

from __future__ import annotations

from collections.abc import Mapping

from reports.dataset.card_tables import IDENTITY, identity_part
from reports.summary.text import count
from sim.dataset.reader import Dataset
from sim.dataset.spread import Spread


def identity_line(dataset: Dataset) -> str:
    """How many rooms, bodies and rigs the sequences have, by their recipes."""
    found = {
        part: {identity_part(sequence, part) for sequence in dataset.sequences} - {""}
        for part in IDENTITY
    }
    if not all(found.values()):
        return "Rooms, bodies and rigs: not stated by the recipes."
    rooms, bodies, rigs = (len(found[part]) for part in IDENTITY)
    return (
        f"{count(len(dataset.sequences), 'sequence')}; different rooms: {rooms}, bodies: {bodies}, "
        f"rigs: {rigs} (`identity` in each recipe.json)."
    )


def spread_table(dataset: Dataset, spreads: Mapping[str, Spread]) -> str:
    """A row per quantity: its values, their share in each tenth of the range, and D."""
    lines = []
    for spread in spreads.values():
        quantity = spread.quantity
        unit = f" {quantity.unit}" if quantity.unit else ""
        scale = ", log" if quantity.log else ""
        if not spread.number:
            lines.append(f"| {quantity.title} | 0 | | | | |")
            continue
        five = " / ".join(f"{spread.quantile(q):.3g}" for q in (0.0, 0.25, 0.5, 0.75, 1.0))
        tenths = " ".join(f"{100 * share:.0f}" for share in spread.tenths)
        lines.append(
            f"| {quantity.title} | {spread.number} | {quantity.low:g} to {quantity.high:g}{unit}"
            f"{scale} | {five} | {tenths} | {spread.distance:.2f} |"
        )
    return "\n".join(
        [
            identity_line(dataset),
            "",
            "D: greatest difference of the distribution from the uniform one over the range "
            "(Kolmogorov-Smirnov): 0 is even, near 1 all at one end.",
            "",
            "| quantity | values | range | least / quartiles / greatest | % in each tenth | D |",
            "|---|--:|---|---|---|--:|",
            *lines,
        ]
    )
