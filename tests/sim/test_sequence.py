import hashlib
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.camera import project
from sim.rest import rest_pose
from sim.script import Performance
from sim.sensor import expose, rounded_gaussian
from sim.sequence import Simulation, background, rig_of, simulate
from sim.specs import ObjectSpec, RigSpec, RoomSpec, SceneSpec, SensorSpec

CAN = ObjectSpec("can", "can", (0.066, 0.066, 0.115), (0.72, 0.08, 0.10), (0.5, -0.3))
SCENE = SceneSpec(rig=RigSpec(tilt_rad=0.28), room=RoomSpec(objects=(CAN,)))


class Lifting:
    """The left hand rises at 0.3 m/s."""

    def pose(self, t_s):
        palms = ((0.34, -0.20, 0.77), (0.34, 0.20, 0.77 + 0.3 * t_s))
        return rest_pose(SCENE.anatomy, palms_m=palms, time_s=t_s)

    def events(self, t_s):
        return ("lift",) if t_s > 0 else ()


def performance(**changed):
    plain = Performance(SCENE, Lifting(), frames=3, fps=3.0, background_frames=4, seed=7)
    return replace(plain, **changed)


def digest_of_all():
    found = hashlib.sha256()
    with Simulation(performance(frames=2)) as simulation:
        for frame in [*simulation.background(), *(f for f, _ in simulation.frames())]:
            for picture in frame.pictures:
                found.update(picture.tobytes())
    return found.hexdigest()


@pytest.fixture(scope="module")
def simulation():
    with Simulation(performance()) as playing:
        yield playing


@pytest.fixture(scope="module")
def played(simulation):
    return list(simulation.frames())


def test_frames_carry_index_time_and_both_pictures(played):
    assert [frame.index for frame, _ in played] == [0, 1, 2]
    assert [frame.time_s for frame, _ in played] == [0.0, 1 / 3, 2 / 3]
    for frame, truth in played:
        assert (truth.index, truth.time_s) == (frame.index, frame.time_s)
        assert [p.shape for p in frame.pictures] == [(480, 640, 3)] * 2
        assert [p.dtype for p in frame.pictures] == [np.uint8] * 2
    assert [truth.events[:1] for _, truth in played] == [(), ("lift",), ("lift",)]


def test_the_truth_moves_with_the_picture(simulation, played):
    for _, truth in played:
        for camera, view in zip(simulation.rig.cameras, truth.views, strict=True):
            offset = view.centroids_px - project(camera, truth.centres_m)
            assert np.linalg.norm(offset, axis=1).max() < 30
    # Up by 0.1 m a frame, 0.42 px a mm at this distance.
    rows = [truth.views[0].centroids_px[2, 1] for _, truth in played]
    assert rows[0] - rows[1] > 30
    assert rows[1] - rows[2] > 30


def test_any_order_gives_the_same_frames(simulation, played):
    again = simulation.shot(2)
    for before, after in zip(played[2][0].pictures, again.frame.pictures, strict=True):
        np.testing.assert_array_equal(before, after)
    np.testing.assert_array_equal(played[2][1].surfaces_m, again.truth.surfaces_m)


def test_the_background_has_no_person_and_noise_of_its_own(simulation):
    frames = simulation.background()
    assert [frame.index for frame in frames] == [0, 1, 2, 3]
    first, second = (frame.pictures[0].astype(int) for frame in frames[:2])
    assert (first != second).mean() > 0.5
    assert abs((first - second).mean()) < 0.05
    assert (first - second).std() == pytest.approx(3.0 * np.sqrt(2), rel=0.03)
    hsv_skin = (first[..., 2] > first[..., 1] * 1.25) & (first[..., 1] > first[..., 0] * 1.05)
    can = np.zeros(hsv_skin.shape, bool)
    u, v = project(simulation.rig.left, np.array([0.5, -0.3, 0.79])).astype(int)
    can[v - 60 : v + 60, u - 45 : u + 45] = True
    assert (hsv_skin & ~can).mean() < 0.01
    assert (hsv_skin & can).any()


def test_the_same_bytes_in_another_process():
    code = (
        "import importlib.util as u;"
        f"s = u.spec_from_file_location('t', {__file__!r}); m = u.module_from_spec(s);"
        "s.loader.exec_module(m); print(m.digest_of_all())"
    )
    environment = {**os.environ, "LP_NUM_THREADS": "0"}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=90
    )
    assert done.stdout.strip() == digest_of_all(), done.stderr


def test_one_shot_functions_play_and_close():
    quick = performance(frames=1, background_frames=1)
    ((frame, truth),) = simulate(quick)
    assert frame.index == truth.index == 0
    assert len(background(quick)) == 1
    np.testing.assert_allclose(rig_of(quick).T, [-0.09, 0, 0], atol=1e-12)


def test_noise_is_addressed_by_seed_stream_and_frame():
    grey = np.full((60, 80, 3), 128, np.uint8)
    sensor = SensorSpec(noise_sd=3.0)
    plain = expose(grey, sensor, 1, "left", 0)
    np.testing.assert_array_equal(plain, expose(grey, sensor, 1, "left", 0))
    for other in ((2, "left", 0), (1, "right", 0), (1, "left", 1), (1, "background/left", 0)):
        assert (plain != expose(grey, sensor, *other)).mean() > 0.5
    np.testing.assert_array_equal(expose(grey, SensorSpec(0.0), 1, "left", 0), grey)
    with pytest.raises(ValueError, match="noise_sd must not be negative, got -1"):
        expose(grey, SensorSpec(-1.0), 1, "left", 0)


@pytest.mark.parametrize("sd", [1.0, 3.0, 12.0])
def test_noise_has_the_asked_spread(sd):
    levels = rounded_gaussian(sd).astype(float)
    # Rounding to whole levels adds 1/12; the table ends at 4.3 sd.
    assert levels.std() == pytest.approx(np.sqrt(sd**2 + 1 / 12), rel=0.003)
    assert abs(levels.mean()) < 1e-12
    grey = np.full((200, 200, 3), 128, np.uint8)
    noisy = expose(grey, SensorSpec(sd), 5, "left", 3).astype(float)
    assert noisy.std() == pytest.approx(sd, rel=0.02, abs=0.05)


def test_noise_stops_at_black_and_white():
    for level in (0, 255):
        picture = np.full((50, 50, 3), level, np.uint8)
        noisy = expose(picture, SensorSpec(6.0), 1, "left", 0).astype(int)
        assert 0.35 < (noisy == level).mean() < 0.65
        assert abs(noisy - level).max() < 30
