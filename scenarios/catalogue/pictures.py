"""Pictures of scenarios: the hardest frame of each, drawn by worker processes."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from pjpdaf.errors import BenchError, InfrastructureError
from reports.pictures.overlay import LETTERS
from reports.pictures.truth_overlay import merged_text, thumbnail
from reports.summary.text import count
from reports.words import label_text
from scenarios.catalogue.film import target_labels
from scenarios.catalogue.frame_choice import hardest_frame, truths_without_pictures
from scenarios.catalogue.scenario_picture import ScenarioPicture
from scenarios.catalogue.stored_picture import picture_from_bytes, picture_to_bytes
from scenarios.console.progress import progress
from scenarios.execute.journal import Journal
from scenarios.spec.draw import perform
from scenarios.spec.scenario import Scenario, digest
from sim.contact.contact import Unposable
from sim.processes import Answer, Lost, WorkerPool
from sim.script import Performance
from sim.sequence import Simulation
from sim.steps import counted
from sim.truth import Truth, ViewTruth

SEEDS = 10  # of these the first that can be posed is drawn
MOST_FRAMES = 60  # of a scenario, among which its picture is chosen
PAGE_PX, MARKDOWN_PX = 320, 240  # side of one view
TIME_LIMIT_S = 900.0  # of one picture, of 60 frames; a busy machine needs its time


def draw_scenarios(
    scenarios: Sequence[Scenario], pool: WorkerPool, journal: Journal | None = None
) -> list[ScenarioPicture]:
    """Draw every scenario in worker processes.

    journal: keeps what is drawn; what is in it is not drawn again. Raises the BenchError of the
    first that fails.
    """
    pictures = {} if journal is None else _kept_pictures(scenarios, journal)
    tasks = {index: one for index, one in enumerate(scenarios) if index not in pictures}
    frames = [len(_frames_seen(one)) for one in scenarios]
    with progress(running=pool.running_steps) as meter:

        def doing() -> str:
            return f"{len(pictures)}/{count(len(scenarios), 'scenario')}"

        meter.begin(doing(), sum(frames), finished=sum(frames[index] for index in pictures))
        for ended in pool.outcomes(_draw_or_fault, tasks, TIME_LIMIT_S):
            if ended is not None:
                index, outcome = ended
                pictures[index] = _unpack(scenarios[index], outcome)
                if journal is not None:
                    journal.append(digest(scenarios[index]), picture_to_bytes(pictures[index]))
                meter.finish(frames[index], doing())
    return [pictures[index] for index in range(len(scenarios))]


def _kept_pictures(scenarios: Sequence[Scenario], journal: Journal) -> dict[int, ScenarioPicture]:
    pictures = {}
    for index, scenario in enumerate(scenarios):
        data = journal.finished.get(digest(scenario))
        if data is not None:
            with suppress(ValueError):  # it is drawn again
                pictures[index] = picture_from_bytes(data)
    return pictures


def _unpack(
    scenario: Scenario, outcome: Answer[ScenarioPicture | BenchError] | Lost
) -> ScenarioPicture:
    if isinstance(outcome, Lost):
        fate = "takes too long" if outcome.late else "is killed"
        raise InfrastructureError(
            f"{scenario.name}: the process that draws it {fate}; try fewer --jobs"
        )
    if isinstance(outcome.value, BenchError):
        raise outcome.value
    return outcome.value


def _draw_or_fault(scenario: Scenario) -> ScenarioPicture | BenchError:
    try:
        return draw_scenario(scenario)
    except BenchError as fault:
        return fault.reworded(f"{scenario.name}: {fault}")


def draw_scenario(scenario: Scenario) -> ScenarioPicture:
    """Draw the hardest frame of the first seed that can be posed. Raises BenchError."""
    performance = _first_performance(scenario)
    truths = list(counted(truths_without_pictures(performance, _frames_seen(scenario))))
    with Simulation(performance) as simulation:
        shot = simulation.render(hardest_frame(truths).index)
        large, small = (
            thumbnail(shot.frame, simulation.rig.cameras, target_labels(shot), shot.truth, side)
            for side in (PAGE_PX, MARKDOWN_PX)
        )
    seed = f"seed {performance.seed}, " if performance.seed else ""
    return ScenarioPicture(large, small, seed + caption(shot.truth))


def _frames_seen(scenario: Scenario) -> range:
    """The frames among which a scenario's picture is chosen."""
    return range(0, scenario.frames, -(-scenario.frames // MOST_FRAMES))


def _first_performance(scenario: Scenario) -> Performance:
    for seed in range(SEEDS):
        try:
            return perform(scenario, seed)
        except Unposable as fault:
            reason = str(fault)
    raise BenchError(f"none of the seeds 0 to {SEEDS - 1} can be posed; the last: {reason}")


def caption(truth: Truth) -> str:
    """Describe a frame: number, time, events, merged and invisible targets."""
    phrases = [f"frame {truth.index} ({truth.time_s:.1f} s)", *map(label_text, truth.script_events)]
    for state, names_of in (("merged", merged_text), ("unseen", _unseen_names)):
        left, right = map(names_of, truth.views)
        if left == right:
            phrases += [f"{left} {state} in both views"] if left else []
        else:
            views = ((left, "left"), (right, "right"))
            phrases += [f"{names} {state} in the {side} view" for names, side in views if names]
    return ", ".join(phrases)


def _unseen_names(view: ViewTruth) -> str:
    return " and ".join(letter for t, letter in enumerate(LETTERS) if not view.visible_px[t])
