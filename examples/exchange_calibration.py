"""Reliability of the stated exchange probability of saved runs: a table, and a diagram.

    python examples/exchange_calibration.py runs/a runs/b --out reliability.svg

A frame counts where the tracker states a probability and the hands are more than 0.10 m apart; it
is exchanged where the swap margin is negative. Intervals: 95 %, episodes resampled, since the
frames of an episode go together.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np

from pjpdaf.targets import RIGHT_HAND, TARGETS
from reports.run.load import SavedRun, load
from reports.score.exchange import (
    Exchange,
    ReliabilityBin,
    calibration_error,
    reliability,
)

RESAMPLES = 2000


@dataclass(frozen=True)
class Interval:
    """A bin of the diagram with the 95 % interval of its observed share."""

    bin: ReliabilityBin
    low: float
    high: float


def exchanges(run: SavedRun) -> list[Exchange]:
    """The judged frames of each episode of a run."""
    hand = run.frames[run.frames["target"] == TARGETS[RIGHT_HAND]]
    columns = ["exchange_probability", "exchanged"]
    return [
        Exchange(*rows[columns].to_numpy(dtype=np.float64).T).judged
        for _, rows in hand.groupby(["scenario", "seed"], sort=False)
    ]


def pooled(episodes: Sequence[Exchange]) -> Exchange:
    """All frames of some episodes."""
    return Exchange(
        np.concatenate([one.stated for one in episodes]),
        np.concatenate([one.exchanged for one in episodes]),
    )


def intervals(episodes: Sequence[Exchange]) -> list[Interval]:
    """The bins, each with the interval of its share over resampled episodes."""
    rng = np.random.default_rng(0)
    bins = reliability(pooled(episodes))
    shares: dict[float, list[float]] = {one.low: [] for one in bins}
    for _ in range(RESAMPLES):
        again = [episodes[k] for k in rng.integers(0, len(episodes), len(episodes))]
        for one in reliability(pooled(again)):
            shares[one.low].append(one.observed)
    return [
        Interval(one, *(float(q) for q in np.quantile(shares[one.low], (0.025, 0.975))))
        for one in bins
    ]


def table(episodes: Sequence[Exchange], shown: Sequence[Interval]) -> str:
    """The table in Markdown, and the calibration error below it."""
    rows = ["| stated | frames | mean stated | exchanged | 95 % |", "|---|---|---|---|---|"]
    rows += [
        f"| {i.bin.low:g} to {i.bin.high:g} | {i.bin.frames} | {100 * i.bin.stated:.2f} % | "
        f"{100 * i.bin.observed:.2f} % | {100 * i.low:.1f} to {100 * i.high:.1f} % |"
        for i in shown
    ]
    every = pooled(episodes)
    rows.append(
        f"\n{len(episodes)} episodes, {len(every.stated)} frames, stated "
        f"{100 * every.stated.mean():.2f} %, exchanged {100 * every.exchanged.mean():.2f} %, "
        f"expected calibration error {calibration_error([i.bin for i in shown]):.4f}"
    )
    return "\n".join(rows)


def draw(shown: Sequence[Interval], path: Path) -> None:
    """Draw the reliability diagram; numbers beside the points are frames."""
    mpl.use("agg")
    mpl.rcParams["svg.hashsalt"] = "reliability"  # the same bytes each time
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(5.2, 4.2))
    axes.plot([0, 0.6], [0, 0.6], color="0.7", linewidth=1, label="calibrated")
    x = np.array([i.bin.stated for i in shown])
    y = np.array([i.bin.observed for i in shown])
    spread = np.array([[y[k] - i.low, i.high - y[k]] for k, i in enumerate(shown)]).T
    axes.errorbar(x, y, np.maximum(spread, 0.0), fmt="o", capsize=3, label="95 % interval")
    for i in shown:
        place = (i.bin.stated, i.bin.observed)
        axes.annotate(str(i.bin.frames), place, (6, -11), textcoords="offset points", fontsize=8)
    axes.set(xlabel="stated probability", ylabel="share of frames exchanged")
    axes.set(xlim=(-0.02, 0.62), ylim=(-0.03, 1.0))
    axes.legend(loc="upper left", frameon=False)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)


def main() -> None:
    """Read the runs, print the table, draw the diagram."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--out", type=Path, help="SVG or PNG")
    options = parser.parse_args()
    episodes = [one for folder in options.runs for one in exchanges(load(folder))]
    episodes = [one for one in episodes if len(one.stated)]
    if not episodes:
        parser.error("no frame of these runs has a stated exchange probability")
    shown = intervals(episodes)
    print(table(episodes, shown))
    if options.out is not None:
        draw(shown, options.out)


if __name__ == "__main__":
    main()
