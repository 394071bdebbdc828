"""The nominal room: its pixels stay, whatever varied surroundings there are beside it."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from scenarios.cache.key import EXTENSIONS, machine
from sim.camera.render import StereoRenderer
from sim.scene.world import build
from sim.specs import RigSpec, SceneSpec

# Of a version before there were varied surroundings.
IDS = "9708d544d16b51146f82990d66738ed4dc4a48600577d2bfb734a0f45e7c8baf"
COLOUR = "ca815ccf6417361ce508dce327d12305003a16a3de56b0244aed8c36ecbf9fd3"


def room_without_person():
    rig = RigSpec(focal_px=135.0, width_px=160, height_px=120)
    with StereoRenderer(build(SceneSpec(rig=rig))) as renderer:
        return renderer.render(amodal=False, person=False)


def test_the_nominal_room_is_drawn_as_ever():
    views = room_without_person()
    names = hashlib.sha256(b"".join(view.geoms.astype("<i4").tobytes() for view in views))
    assert names.hexdigest() == IDS
    if not all(extension in machine() for extension in EXTENSIONS):
        pytest.skip("colours are the same bits only where the processor has AVX2 and FMA")
    colour = hashlib.sha256(b"".join(np.ascontiguousarray(v.colour).tobytes() for v in views))
    assert colour.hexdigest() == COLOUR
