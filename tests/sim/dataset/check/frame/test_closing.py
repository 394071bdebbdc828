"""Depth from view to view and back in a small picture of a room full of edges."""

import shutil

import numpy as np
import pytest
from damaged_dataset import SEQ, edit_png, faults_of, files, finish

from scenarios.play.recipe import sized
from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from scenarios.spec.scenario import in_varied_surroundings
from sim.dataset.files.layout import LABELS
from sim.dataset.files.manifest import SequenceEntry
from sim.dataset.writer import write_sequence
from sim.sequence import Simulation

DEPTH = f"{SEQ}/depth_right/000001.png"


@pytest.fixture(scope="module")
def furnished(tmp_path_factory):
    """One frame of 160 x 120 pixels: shelves of books, a plant, a chair, all of one instance."""
    root = tmp_path_factory.mktemp("furnished")
    scenario = in_varied_surroundings(load_scenario("drink"), "drink")
    scene = sized(perform(scenario, 0, {"frames": 1, "background_frames": 1}), (160, 120))
    (root / SEQ).mkdir()
    with Simulation(scene) as simulation:
        write_sequence(simulation, root / SEQ, tuple(LABELS), {"test": "drink"})
    entry = SequenceEntry(SEQ, "drink", "drink", scenario.group, 0, "", "", 1, scene.fps)
    finish(root, [entry])
    return root


@pytest.fixture
def room(furnished, tmp_path):
    shutil.copytree(furnished, tmp_path / "copy")
    return tmp_path / "copy"


def test_a_room_full_of_edges_has_no_fault(room):
    assert faults_of(room) == []


def nearer(depth):
    """A tenth of the picture, of table and wall, 2 % nearer."""
    height, width = depth.shape
    changed = depth.copy()
    part = changed[: height // 4, -2 * width // 5 :]
    part[:] = np.rint(part * 0.98)
    return changed


def noisy(depth):
    """Everywhere off by 30 mm, to both sides: most pixels are edges."""
    off = np.random.default_rng(7).normal(0, 300, depth.shape)
    return np.where(depth > 0, np.clip(depth + off, 1, 65535), 0).astype(np.uint16)


@pytest.mark.parametrize("damage", [nearer, noisy])
def test_depth_of_no_surface_is_named(room, damage):
    edit_png(room / DEPTH, damage)
    named = files(faults_of(room))
    assert any("/depth_" in file or "/disparity_right" in file for file in named), named
