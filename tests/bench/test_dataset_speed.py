"""What writing a data set costs beside rendering it. Ratios within one run.

Run with `pytest tests/bench --benchmark-enable`.
"""

import time

import pytest

from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.dataset.labels.labeller import Labeller
from sim.dataset.writer import write_sequence
from sim.sequence import Simulation

FRAMES = 3
LABELS = ("depth", "seg", "amodal")  # colour, depth, ids, amodal masks, boxes, keypoints


@pytest.fixture(scope="module")
def simulation():
    overrides = {"frames": FRAMES, "background_frames": 0}
    with Simulation(perform(load_scenario("cross"), 100, overrides)) as opened:
        opened.render(0)
        yield opened


def render(simulation, labels):
    """The same passes and labels, and nothing written."""
    labeller = Labeller(simulation, [name for name in labels if name in Labeller.WANTED])
    for index in range(FRAMES):
        labeller.labelled(index)


def write(simulation, labels, folder):
    folder.mkdir()
    write_sequence(simulation, folder, labels, {})


def test_bare_renderer(benchmark, simulation):
    benchmark.group = "labelled stereo frames"
    benchmark.pedantic(render, args=(simulation, LABELS), rounds=3)


def test_writer(benchmark, simulation, tmp_path_factory):
    benchmark.group = "labelled stereo frames"

    def fresh():
        return (simulation, LABELS, tmp_path_factory.mktemp("written") / "seq"), {}

    benchmark.pedantic(write, setup=fresh, rounds=3)


@pytest.mark.long
@pytest.mark.benchmark(group="a label beside depth, ids and masks, CPU", timer=time.process_time)
@pytest.mark.parametrize("label", ["none", *Labeller.WANTED])
def test_label(benchmark, simulation, label):
    labeller = Labeller(simulation, [label] if label in Labeller.WANTED else [])

    def make():
        for index in range(FRAMES):
            labeller.labelled(index)
            if label == "flow" and index:
                labeller.flow(index - 1)

    benchmark.pedantic(make, rounds=5, warmup_rounds=1)


@pytest.mark.long
def test_writing_takes_little_of_the_time_of_rendering(simulation, tmp_path):
    """About 1.3 in CPU time of all threads, which other processes do not change much.

    Two pictures with noise take 26 ms of PNG, depth and ids 12; to render them takes 180.
    """

    def cpu_s(work, *arguments):
        start = time.process_time()
        work(simulation, LABELS, *arguments)
        return time.process_time() - start

    ratios = [cpu_s(write, tmp_path / str(k)) / cpu_s(render) for k in range(5)]
    assert min(ratios) < 1.45
