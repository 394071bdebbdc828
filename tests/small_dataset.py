"""A small real data set, made once for all test processes."""

import pytest
from shared import copied, shared

from scenarios.play.recipe import sized
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.dataset.files.layout import LABELS, sequence_name
from sim.dataset.files.manifest import SequenceEntry, manifest_record, write_manifest
from sim.dataset.writer import write_sequence
from sim.sequence import Simulation

SIZE_PX = (320, 240)
# Hands that merge; a lens, lost pictures and a wrong calibration; a hand that leaves the view.
SEQUENCES = (
    ("cross", 101, {"frames": 6, "background_frames": 2}),
    (
        "drink",
        102,
        {
            "frames": 4,
            "background_frames": 1,
            "lens_k1": -0.15,
            "lens_k2": 0.03,
            "dropped": 10,
            "calibration_baseline": 2.0,
        },
    ),
    ("leave_view", 103, {"frames": 5, "background_frames": 1}),
)


def simulation_of(number):
    """The live simulation of a sequence of the data set."""
    name, seed, overrides = SEQUENCES[number]
    return Simulation(sized(perform(load_scenario(name), seed, overrides), SIZE_PX))


def make(root):
    folder = root / "set"
    folder.mkdir()
    entries = []
    for index, (name, seed, overrides) in enumerate(SEQUENCES):
        scenario = load_scenario(name)
        target = folder / sequence_name(index)
        target.mkdir()
        with simulation_of(index) as simulation:
            write_sequence(simulation, target, tuple(LABELS), {"test": name})
        entries.append(
            SequenceEntry(
                target.name, name, name, scenario.group, seed, "", f"{seed}", overrides["frames"], 3
            )
        )
    settings = {"labels": list(LABELS), "size": None}
    write_manifest(folder, manifest_record(entries, settings, {}, complete=True))


@pytest.fixture(scope="session")
def dataset_made(tmp_path_factory):
    """Folder of a data set with all labels; read only, copy it to change it."""
    return shared(tmp_path_factory, "dataset", make) / "set"


dataset_copy = copied("dataset_made")
