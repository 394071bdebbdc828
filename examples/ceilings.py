"""The ceilings of `default`: the same tracker with perfect detections, and perfect association.

Prints the table of docs/tracker.md, "Ceilings":
    pjpdaf-bench dataset make core --seeds 1 --labels none --export none --out sets/core
    python examples/ceilings.py --from sets/core
Without --from it renders: python examples/ceilings.py core --seeds 1
"""

from __future__ import annotations

from replays import Result, Variant, by_group, main, outcome, share

from scenarios.play.job import System
from scenarios.play.oracle import Oracle

VARIANTS = tuple(
    Variant(name, System(), oracle)
    for name, oracle in (
        ("as it is", Oracle()),
        ("perfect detections", Oracle(detections=True)),
        ("perfect association", Oracle(association=True)),
        ("both", Oracle(detections=True, association=True)),
        ("perfect prediction", Oracle(process=True)),
    )
)


def show(found: list[Result]) -> None:
    """Print a row for each group, a column for each variant."""
    print("| group | n | " + " | ".join(variant.name for variant in VARIANTS) + " |")
    print("|---|---:" + "|---" * len(VARIANTS) + "|")
    for group, results in by_group(found):
        cells = []
        for variant in VARIANTS:
            mine = [result for result in results if result.variant == variant.name]
            cells.append(f"{share(mine)}; {outcome(mine)}")
        print(f"| {group} | {len(results) // len(VARIANTS)} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main({"all": VARIANTS}, show, "Ceilings of the preset default.")
