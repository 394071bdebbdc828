"""The work that a stereo frame takes, counted: seconds differ, counts do not."""

from dataclasses import dataclass, field

import pytest

from scenarios.spec.draw import perform
from scenarios.spec.names import load_scenario
from sim.gl import load_mujoco
from sim.sequence import Simulation

PICTURE_PX = 640 * 480
COLOUR, LABELS, AMODAL, SHADOWS = "colour", "labels", "amodal", "shadows"


@dataclass
class Work:
    """Passes by kind, the pixels that they drew, the geoms sent, and the bytes read back."""

    passes: list[str] = field(default_factory=list)
    pixels: dict[str, int] = field(default_factory=dict)
    geoms: int = 0
    read_bytes: int = 0


@pytest.fixture
def work(monkeypatch):
    mujoco = load_mujoco()
    flags = mujoco.mjtRndFlag
    render, read = mujoco.mjr_render, mujoco.mjr_readPixels
    work = Work()

    def counted_render(viewport, scene, context):
        if scene.camera[0].orthographic:
            kind = SHADOWS
        elif not scene.flags[flags.mjRND_SEGMENT]:
            kind = COLOUR
        else:
            kind = LABELS if scene.ngeom > 60 else AMODAL
        work.passes.append(kind)
        work.pixels[kind] = work.pixels.get(kind, 0) + viewport.width * viewport.height
        work.geoms += scene.ngeom
        assert not scene.flags[flags.mjRND_SHADOW], "MuJoCo's shadows draw the scene twice more"
        render(viewport, scene, context)

    def counted_read(rgb, depth, viewport, context):
        work.read_bytes += rgb.nbytes + (0 if depth is None else depth.nbytes)
        read(rgb, depth, viewport, context)

    monkeypatch.setattr(mujoco, "mjr_render", counted_render)
    monkeypatch.setattr(mujoco, "mjr_readPixels", counted_read)
    return work


@pytest.fixture(scope="module")
def simulation():
    with Simulation(perform(load_scenario("cross"), 100, {"frames": 9})) as opened:
        opened.render(0)
        yield opened


def test_a_stereo_frame(simulation, work):
    simulation.render(5)
    per_view = [COLOUR, LABELS, AMODAL, AMODAL, AMODAL]
    # Both views share the shadow map.
    assert work.passes == [SHADOWS, *per_view, *per_view]
    assert work.geoms < 950  # of 130 in the scene; MuJoCo's own way: 9 times 2 views all of them
    both = 2 * PICTURE_PX
    assert work.pixels[COLOUR] < 0.6 * 4 * both  # four samples a pixel
    assert work.pixels[LABELS] < 0.5 * both
    assert work.pixels[AMODAL] < 0.15 * both
    assert work.read_bytes < 10e6  # all of all passes: 17 MB


def test_the_second_look_at_a_pose_draws_no_shadows(simulation, work):
    simulation.render(5)
    work.passes.clear()
    simulation._renderer.view(0, labels=False, amodal=False)
    assert work.passes == [COLOUR]


def test_the_empty_room_is_drawn_once(simulation, work):
    """It is the still scene but for the person's legs, which hide the floor under the table."""
    simulation.background_light()
    assert work.pixels.get(COLOUR, 0) < 0.1 * 4 * 2 * PICTURE_PX
