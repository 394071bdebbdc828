"""The table of `scenarios measure`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median

from rich.table import Table
from rich.text import Text

from reports.summary.plain_table import plain_table
from scenarios.catalogue.survey import Survey
from sim.motion.measure import Speeds
from sim.person.kinematics import MAX_ELBOW_FLEXION_RAD, MAX_WRIST_BEND_RAD

# Hands of people who talk, seated, from recorded motion (the catalogue's preface).
RECORDED = Speeds(
    median_mps=0.2, high_mps=1.5, top_mps=3.9, step_m=(0.058, 0.292, 0.563), missed_m=(0.097, 0.421)
)


def survey_table(surveys: Sequence[Survey]) -> Table:
    """Build the table: a row per scenario, and recorded motion below to compare with."""
    table = plain_table("Motion as it is posed, before rendering")
    table.caption = Text(
        "inside: deepest overlap of two parts, 5 mm allowed; short: of a palm from its target, "
        "10 mm allowed; speed: of the hands, median/95 %/top; step: displacement in 1/3 s, "
        "50/90/99 %; missed: by a constant-velocity prediction, 50/90 %"
    )
    table.caption_justify = "left"
    table.add_column("scenario", no_wrap=True)
    headings = (
        "inside\nmm",
        "short\nmm",
        f"wrist\n<= {math.degrees(MAX_WRIST_BEND_RAD):.0f} deg",
        f"elbow\n<= {math.degrees(MAX_ELBOW_FLEXION_RAD):.0f} deg",
        "hands\napart mm",
        "speed\nm/s",
        "step\nmm",
        "missed\nmm",
        "redrawn\n%",
        "pose\nms",
        "build\ns",
    )
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    for row in surveys:
        table.add_row(row.name, *_cells(row), style="bold red" if row.faults else None)
    table.add_section()
    table.add_row("recorded talk", "", "", "", "", "", *_speed_cells(RECORDED), "", "", "")
    return table


def _cells(row: Survey) -> tuple[str, ...]:
    measures = [seed.measures for seed in row.seeds]
    return (
        f"{1000 * max(row.deepest_m, 0.0):.1f}",
        f"{1000 * row.short_m:.1f}",
        f"{math.degrees(max(m.wrist_bend_rad for m in measures)):.0f}",
        f"{math.degrees(max(m.elbow_flexion_rad for m in measures)):.0f}",
        f"{1000 * min(m.hands_gap_m for m in measures):.0f}",
        *_speed_cells(row.hands),
        f"{100 * row.redrawn_share:.0f}",
        f"{median(seed.pose_ms for seed in row.seeds):.2f}",
        f"{median(seed.build_s for seed in row.seeds):.2f}",
    )


def _speed_cells(speeds: Speeds) -> tuple[str, str, str]:
    return (
        f"{speeds.median_mps:.2f}/{speeds.high_mps:.2f}/{speeds.top_mps:.1f}",
        "/".join(f"{1000 * s:.0f}" for s in speeds.step_m),
        "/".join(f"{1000 * m:.0f}" for m in speeds.missed_m),
    )
