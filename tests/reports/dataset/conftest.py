"""Small real data sets for the tests of this folder."""

import pytest
from shared import shared
from small_dataset import dataset_copy, dataset_made

from reports.dataset.sequence_view import sequence_views
from scenarios.play.recipe import sized
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.dataset.files.layout import sequence_name
from sim.dataset.files.manifest import SequenceEntry, manifest_record, write_manifest
from sim.dataset.reader import open_dataset
from sim.dataset.writer import write_sequence
from sim.sequence import Simulation

__all__ = ["dataset_copy", "dataset_made"]

HOSTILE = "</script><b>x{{ 7*7 }}"
SIZE_PX = (160, 120)
FRAMES = 20
LABELS = ("clean", "depth", "seg", "amodal", "disparity", "semantic", "normals", "flow")


@pytest.fixture(scope="session")
def labelled(tmp_path_factory):
    """Hands that cross within twelve frames; a lens and lost pictures, without seg and amodal."""
    return open_dataset(shared(tmp_path_factory, "labelled", _make) / "set")


def _make(root):
    folder = root / "set"
    folder.mkdir()
    lens = {"frames": 5, "lens_k1": -0.2, "lens_k2": 0.05, "dropped": 10}
    made = (("cross", 101, {"frames": FRAMES}, LABELS), ("calm_table", 102, lens, ("depth",)))
    entries = []
    for index, (name, seed, overrides, labels) in enumerate(made):
        scenario, target = load_scenario(name), folder / sequence_name(index)
        target.mkdir()
        changes = {"background_frames": 1, **overrides}
        with Simulation(sized(perform(scenario, seed, changes), SIZE_PX)) as simulation:
            write_sequence(simulation, target, labels, {"values": {"skin_ita": 30.0}})
        entries.append(
            SequenceEntry(
                target.name,
                HOSTILE if index else name,
                HOSTILE if index else name,
                scenario.group,
                seed,
                "",
                str(seed),
                overrides["frames"],
                3.0,
            )
        )
    settings = {"labels": list(LABELS), "size_px": list(SIZE_PX)}
    write_manifest(folder, manifest_record(entries, settings, {}, complete=True))


@pytest.fixture(scope="session")
def shown(labelled):
    return sequence_views(labelled.sequences)
