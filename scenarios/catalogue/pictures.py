"""Pictures of scenarios: the hardest frame of each, drawn by worker processes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rich.console import Console

from pjpdaf.arrays import Image
from pjpdaf.errors import BenchError, InfrastructureError
from reports.pictures.overlay import LETTERS
from reports.pictures.truth_overlay import merged_text, thumbnail
from scenarios.catalogue.film import target_labels
from scenarios.catalogue.frame_choice import hardest_frame, truths_without_pictures
from scenarios.console.progress import progress_bar
from scenarios.spec.draw import perform
from scenarios.spec.scenario import Scenario
from sim.contact.contact import Unposable
from sim.processes import Answer, Lost, WorkerPool
from sim.script import Performance
from sim.sequence import Simulation
from sim.truth import Truth, ViewTruth

SEEDS = 10  # of these the first that can be posed is drawn
MOST_FRAMES = 60  # of a scenario, among which its picture is chosen
PAGE_PX, MARKDOWN_PX = 320, 240  # side of one view
TIME_LIMIT_S = 300.0  # of one picture


@dataclass(frozen=True, eq=False)
class ScenarioPicture:
    """A frame of a scenario: both views (h, w, 3) BGR for page and Markdown, and a caption."""

    large: Image
    small: Image
    caption: str


def draw_scenarios(scenarios: Sequence[Scenario], workers: int) -> list[ScenarioPicture]:
    """Draw every scenario in worker processes. Raises the BenchError of the first that fails."""
    console = Console(stderr=True)
    pictures: dict[int, ScenarioPicture] = {}
    with progress_bar(console) as progress, WorkerPool(min(workers, len(scenarios))) as pool:
        task = progress.add_task("starting", total=len(scenarios))
        pool.renderer()
        for ended in pool.outcomes(_draw_or_fault, dict(enumerate(scenarios)), TIME_LIMIT_S):
            if ended is not None:
                index, outcome = ended
                pictures[index] = _unpack(scenarios[index], outcome)
                progress.update(task, advance=1, description=scenarios[index].name)
    return [pictures[index] for index in range(len(scenarios))]


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
    step = -(-performance.frames // MOST_FRAMES)
    truths = list(truths_without_pictures(performance, range(0, performance.frames, step)))
    with Simulation(performance) as simulation:
        shot = simulation.render(hardest_frame(truths).index)
        large, small = (
            thumbnail(shot.frame, simulation.rig.cameras, target_labels(shot), shot.truth, side)
            for side in (PAGE_PX, MARKDOWN_PX)
        )
    seed = f"seed {performance.seed}, " if performance.seed else ""
    return ScenarioPicture(large, small, seed + caption(shot.truth))


def _first_performance(scenario: Scenario) -> Performance:
    for seed in range(SEEDS):
        try:
            return perform(scenario, seed)
        except Unposable as fault:
            reason = str(fault)
    raise BenchError(f"none of the seeds 0 to {SEEDS - 1} can be posed; the last: {reason}")


def caption(truth: Truth) -> str:
    """Describe a frame: number, time, events, merged and invisible targets."""
    phrases = [f"frame {truth.index} ({truth.time_s:.1f} s)", *truth.script_events]
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
