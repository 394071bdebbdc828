"""The verb `shrink`: the minimal and the most severe form of a case, with their survival rates."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from pjpdaf.errors import BenchError
from reports.summary.text import count
from reports.words import MEASURE_WORDS
from scenarios.console.lines import print_line
from scenarios.spec.corpus_case import numbered_label
from scenarios.stress.campaign import CampaignRequest, open_campaign
from scenarios.stress.case import Case
from scenarios.stress.case_file import (
    case_of,
    corpus_case,
    load_case,
    settings_of,
    system_to_play,
    write_case,
)
from scenarios.stress.drawn import drawn_space
from scenarios.stress.quarantine import name_quarantined
from scenarios.stress.search.evaluation import Evaluator
from scenarios.stress.shrink import MOST_RUNS, NEEDED, SEEDS, Shrunk, shrink
from scenarios.stress.space import Space
from scenarios.stress.survival import Survival

MAX_FRESH = 100_000


@dataclass(frozen=True)
class ShrinkRequest:
    """The options of `shrink`. path: a case file; fresh: episodes for the survival rates.

    detector, tracker: None: those of the file; a plug-in that it names must be named here too.
    """

    campaign: CampaignRequest
    path: Path
    fresh: int = 100
    detector: str | None = None
    tracker: str | None = None


def shrink_verb(request: ShrinkRequest) -> None:
    """Shrink a case, print what is left, write minimal.yaml and severe.yaml.

    Raises BenchError, and Interrupted after a signal.
    """
    if not 1 <= request.fresh <= MAX_FRESH:
        raise BenchError(f"--fresh must be between 1 and {MAX_FRESH}, got {request.fresh}")
    record = load_case(request.path)
    system = system_to_play(record, request.path, request.detector, request.tracker)
    options = {"case": record.digest, "event": record.event, "fresh": request.fresh}
    campaign_request = replace(
        request.campaign,
        target=record.family,
        detector=system.detector,
        tracker=system.tracker,
        settings=settings_of(system),
        options=options,
    )
    with open_campaign(campaign_request) as campaign:
        space, case = campaign.spaces[0], case_of(record)
        # What it sets beyond the family's own may be what matters: the rate, or what others draw.
        more = ("fps", *drawn_space(space).names)
        also = [name for name in case.values if name in more]
        space = Space.of(space.family, also)
        most = MOST_RUNS + 2 * request.fresh
        campaign.progress.start(f"{record.name}: shrink, at most", most)
        fidelity = campaign.fidelity_for(space)
        evaluator = Evaluator(campaign.runner, campaign.system, fidelity)
        shrunk = shrink(
            space, case, record.event, evaluator.evaluate, request.fresh, campaign.request.seed
        )
        written: list[str] = []
        for name, kept, survival in (
            ("minimal", shrunk.minimal, shrunk.minimal_survival),
            ("severe", shrunk.severe, shrunk.severe_survival),
        ):
            if kept is not None and survival is not None:
                path = campaign.folder / f"{name}.yaml"
                note = (
                    f"the {name} form of {record.name}; fails with {survival.text} fresh noise "
                    f"seeds in {fidelity}"
                )
                title = numbered_label(record.name, f"_{name}")
                form = corpus_case(title, kept, system, record.event, record.rho, "open", note)
                write_case(path, form, replace=True)
                written.append(f"{name}: {path}")
    out = Console()
    _print(out, shrunk, space, fidelity)
    for line in written:
        print_line(line, out)
    name_quarantined(campaign, out)


def _print(out: Console, shrunk: Shrunk, space: Space, fidelity: str) -> None:
    event = MEASURE_WORDS[shrunk.measure]
    print_line(
        f"{shrunk.case.family}: {event} with {shrunk.survival.text} fresh noise seeds in "
        f"{fidelity}, {len(shrunk.changed)} of {count(len(space.axes), 'parameter')} not nominal",
        out,
    )
    if shrunk.survival.failed < NEEDED:
        print_line(
            f"not shrunk: it must fail with {NEEDED} of {SEEDS} fresh noise seeds; this failure is "
            "one of noise",
            out,
        )
    runs = count(shrunk.runs, "run")
    changes = "" if shrunk.minimal is None else _differences(shrunk.minimal, shrunk, space)
    if shrunk.once is not None:
        words = changes if shrunk.once.narrowed else ""
        print_line(f"{runs}: needed with its own noise: {words or shrunk.once.words}", out)
    elif shrunk.minimal is not None:
        print_line(
            f"{runs}: {count(len(shrunk.needed), 'parameter')} left: "
            f"{changes or 'none, the nominal case fails'}; {shrunk.minimal.frames} of "
            f"{shrunk.case.frames} frames",
            out,
        )
    for name, survival in (
        ("minimal", shrunk.minimal_survival),
        ("most severe", shrunk.severe_survival),
    ):
        if survival is not None:
            print_line(f"{name}: {_rate(survival)}", out)


def _differences(minimal: Case, shrunk: Shrunk, space: Space) -> str:
    nominal = space.nominal()
    return ", ".join(f"{n} {minimal.values[n]} (nominal {nominal[n]})" for n in shrunk.needed)


def _rate(survival: Survival) -> str:
    return (
        f"fails with {survival.text} further seeds, {100 * survival.severity:.0f} % of the frames "
        "bad where it does"
    )
