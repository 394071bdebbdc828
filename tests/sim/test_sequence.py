import hashlib
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from pjpdaf.camera import project, to_camera, triangulate
from sim.camera.colour import GAMMA, balance_rgb, light_rgb
from sim.camera.exposure import MOST_SUBFRAMES, SUBFRAME_PX, subframes
from sim.person.rest import rest_pose
from sim.script import Performance
from sim.sequence import Simulation, rig_of
from sim.specs import (
    CalibrationError,
    ClockSpec,
    ObjectSpec,
    RigSpec,
    RoomSpec,
    SceneSpec,
    SensorSpec,
)

CAN = ObjectSpec("can", "can", (0.066, 0.066, 0.115), (0.72, 0.08, 0.10), (0.5, -0.3))
RIG = RigSpec(tilt_rad=0.28, focal_px=270.0, width_px=320, height_px=240)
SCENE = SceneSpec(rig=RIG, room=RoomSpec(objects=(CAN,)))


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
        assert [p.shape for p in frame.pictures] == [(RIG.height_px, RIG.width_px, 3)] * 2
        assert [p.dtype for p in frame.pictures] == [np.uint8] * 2
    assert [truth.events[:1] for _, truth in played] == [(), ("lift",), ("lift",)]


def test_the_truth_moves_with_the_picture(simulation, played):
    for _, truth in played:
        for camera, view in zip(simulation.rig.cameras, truth.views, strict=True):
            offset = view.centroids_px - project(camera, truth.centres_m)
            assert np.linalg.norm(offset, axis=1).max() < 15
    # Up by 0.1 m a frame, 0.21 px a mm at this distance.
    rows = [truth.views[0].centroids_px[2, 1] for _, truth in played]
    assert rows[0] - rows[1] > 15
    assert rows[1] - rows[2] > 15


def test_any_order_gives_the_same_frames(simulation, played):
    again = simulation.render(2)
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
    can[v - 30 : v + 30, u - 22 : u + 23] = True
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
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=600
    )
    assert done.stdout.strip() == digest_of_all(), done.stderr


def test_a_performance_of_one_frame_plays_and_closes():
    quick = performance(frames=1, background_frames=1)
    with Simulation(quick) as simulation:
        ((frame, truth),) = simulation.frames()
        assert frame.index == truth.index == 0
        assert len(simulation.background()) == 1
    np.testing.assert_allclose(rig_of(quick).T, [-0.09, 0, 0], atol=1e-12)


class Sliding:
    """The right hand slides across the table at 1 m/s towards the person's left."""

    def pose(self, t_s):
        palms = ((0.34, -0.32 + 1.0 * t_s, 0.77), (0.34, 0.25, 0.77))
        return rest_pose(SCENE.anatomy, palms_m=palms, time_s=t_s)

    def events(self, t_s):
        return ()


def filmed(script=None, sensor=None, clock=None, **changed):
    """A quiet performance with these effects."""
    scene = replace(
        SCENE, sensor=sensor or SensorSpec(noise_sd=0.0), clock=clock or ClockSpec(), **changed
    )
    return performance(scene=scene, script=script or Sliding(), frames=6, fps=15.0)


def depth_of_right_hand(simulation, truth):
    return float(to_camera(simulation.rig.left, truth.centres_m[1])[2])


@pytest.fixture(scope="module")
def quiet():
    with Simulation(filmed()) as playing:
        yield playing


def redness(picture, box):
    """Light of red less that of blue in a box: next to nothing on the grey table."""
    x, y, w, h = box
    cut = (picture[y : y + h, x : x + w].astype(float) / 255) ** GAMMA
    return cut[..., 2] - cut[..., 0]


def spread_along_rows(weight):
    """Mean and variance of the column of a weight (h, w), over all its rows."""
    x = np.arange(weight.shape[1])
    mean = (weight * x).sum() / weight.sum()
    return mean, (weight * (x - mean) ** 2).sum() / weight.sum()


@pytest.mark.sample(1)
@pytest.mark.parametrize("exposure_s", [0.02, 0.04])
def test_a_moving_hand_is_blurred_over_its_path(quiet, exposure_s):
    """A path of L = v e f / Z adds L^2 / 12 to the variance of the hand's light along it."""
    index = 3
    with Simulation(filmed(sensor=SensorSpec(exposure_s, noise_sd=0.0))) as simulation:
        blurred = simulation.render(index)
    sharp = quiet.render(index)
    x, y, w, h = sharp.truth.views[0].boxes_px[1].astype(int)
    fingers = (x - 13, y + h // 2, w + 26, h // 2)  # without the blue sleeve
    skin = np.s_[y + h // 2 : y + h, x : x + w]
    depth_m = sharp.views[0].depth_m[skin][sharp.views[0].targets[skin] == 1].mean()
    length = 1.0 * exposure_s * RIG.focal_px / depth_m
    table = redness(quiet.background()[0].pictures[0], fingers)
    before, after = (
        spread_along_rows(redness(shot.frame.pictures[0], fingers) - table)
        for shot in (sharp, blurred)
    )
    assert after[0] == pytest.approx(before[0], abs=0.3)
    assert np.sqrt(12 * (after[1] - before[1])) == pytest.approx(length, rel=0.05)
    # All that does not move is as sharp as before, and the truth is of the middle.
    still = np.s_[10:60, 10:100]
    np.testing.assert_array_equal(blurred.frame.pictures[0][still], sharp.frame.pictures[0][still])
    for view, same in zip(blurred.truth.views, sharp.truth.views, strict=True):
        np.testing.assert_array_equal(view.centroids_px, same.centroids_px)
    np.testing.assert_array_equal(blurred.views[0].colour, sharp.views[0].colour)


def test_subframes_are_as_many_as_the_motion_needs():
    rig = rig_of(performance())
    still, fast = Still(), Sliding()
    assert subframes(fast, rig.cameras, 0.0, 0.2) == (0.2,)
    assert subframes(still, rig.cameras, 0.04, 0.2) == (0.2,)
    for exposure_s in (0.005, 0.01, 0.02, 0.04):
        times = np.array(subframes(fast, rig.cameras, exposure_s, 0.2))
        assert len(times) % 2 == 1
        assert times[len(times) // 2] == 0.2
        step_px = 1.0 * exposure_s / len(times) * RIG.focal_px / 1.0  # 1.0 m: the finger tips
        assert step_px <= SUBFRAME_PX
        if len(times) > 1:
            np.testing.assert_allclose(np.diff(times), exposure_s / len(times))
    assert len(subframes(fast, rig.cameras, 1.0, 0.6)) == MOST_SUBFRAMES
    assert min(subframes(fast, rig.cameras, 0.04, 0.0)) == 0.0


class Still:
    """Nothing moves."""

    def pose(self, t_s):
        return rest_pose(SCENE.anatomy, time_s=t_s)

    def events(self, t_s):
        return ()


def test_a_camera_balanced_for_the_lamp_shows_the_room_as_by_daylight(quiet):
    lamp = replace(SCENE.room, light_rgb=light_rgb(4500.0))
    sensor = SensorSpec(noise_sd=0.0, white_balance_rgb=balance_rgb(4500.0))
    plain = quiet.render(0).frame.pictures[0].astype(int)
    pictures = []
    for camera in (SensorSpec(noise_sd=0.0), sensor):
        with Simulation(filmed(sensor=camera, room=lamp)) as simulation:
            pictures.append(simulation.render(0).frame.pictures[0].astype(int))
    warm, balanced = pictures
    assert np.abs(warm - plain).mean() > 5
    assert np.abs(balanced - plain).mean() < 1.0


@pytest.mark.sample(1)
@pytest.mark.parametrize("skew_s", [0.02, 0.05])
def test_shutter_skew_moves_the_right_view_by_speed_times_delay(quiet, skew_s):
    with Simulation(filmed(sensor=SensorSpec(skew_s=skew_s, noise_sd=0.0))) as simulation:
        late = simulation.render(2)
    sharp = quiet.render(2)
    np.testing.assert_array_equal(late.frame.pictures[0], sharp.frame.pictures[0])
    assert (late.frame.pictures[1] != sharp.frame.pictures[1]).mean() > 0.005
    for view, expected in (
        (0, 0.0),
        (1, RIG.focal_px * skew_s / depth_of_right_hand(quiet, sharp.truth)),
    ):
        moved = late.truth.views[view].centroids_px - sharp.truth.views[view].centroids_px
        assert moved[1, 0] == pytest.approx(expected, abs=0.04 * expected)
        np.testing.assert_allclose(moved[[0, 2]], 0.0, atol=0.05)
    # Everything in three dimensions is of the frame's own time.
    assert late.truth.time_s == sharp.truth.time_s
    np.testing.assert_array_equal(late.truth.centres_m, sharp.truth.centres_m)
    np.testing.assert_array_equal(late.truth.velocities_mps, sharp.truth.velocities_mps)
    np.testing.assert_allclose(late.truth.surfaces_m, sharp.truth.surfaces_m, atol=1.5e-3)


def test_jitter_moves_picture_and_truth_and_the_stamp_as_asked(quiet):
    for stamps in ("actual", "nominal"):
        clock = ClockSpec(jitter_s=0.02, stamps=stamps)
        with Simulation(filmed(clock=clock)) as simulation:
            for index in (1, 4):
                shot = simulation.render(index)
                late_s = shot.truth.time_s - index / 15.0
                assert 1e-4 < abs(late_s) <= 0.02
                carried = index / 15.0 if stamps == "nominal" else shot.truth.time_s
                assert shot.frame.time_s == carried
                on_time = quiet.render(index).truth
                moved = shot.truth.centres_m - on_time.centres_m
                np.testing.assert_allclose(moved[1], [0, late_s, 0], atol=1e-9)
                at = shot.truth.views[0].centroids_px - on_time.views[0].centroids_px
                wanted = RIG.focal_px * late_s / depth_of_right_hand(quiet, on_time)
                assert at[1, 0] == pytest.approx(wanted, abs=0.3)


def test_lost_pictures_are_none_and_the_truth_stays():
    with Simulation(filmed(clock=ClockSpec(dropped=0.5))) as simulation:
        played = [simulation.render(index) for index in range(4)]
        background = simulation.background()
    lost = np.array([[p is None for p in shot.frame.pictures] for shot in played])
    assert lost.any()
    assert not lost.all()
    with Simulation(filmed()) as simulation:
        for index in np.flatnonzero(lost.any(axis=1)):
            whole = simulation.render(int(index))
            np.testing.assert_array_equal(whole.truth.surfaces_m, played[index].truth.surfaces_m)
            for mine, its in zip(played[index].frame.pictures, whole.frame.pictures, strict=True):
                assert mine is None or (mine == its).all()
    assert all(p is not None for frame in background for p in frame.pictures)


@pytest.mark.long
def test_all_effects_together_give_the_same_frames_in_any_order():
    everything = SensorSpec(
        exposure_time_s=0.01,
        skew_s=0.03,
        exposure_ev=0.4,
        white_balance_rgb=(1.2, 1.0, 0.8),
        flicker=0.05,
        noise_sd=2.0,
        shot_noise_sd=3.0,
        jpeg_quality=80,
    )
    rig = replace(RIG, distortion=(-0.2, 0.08, 0.0, 0.0), principal_offset_px=(8.0, -5.0))
    clock = ClockSpec(jitter_s=0.02, dropped=0.1)
    playing = replace(filmed(sensor=everything, clock=clock, rig=rig), frames=2)
    with Simulation(playing) as simulation:
        straight = [simulation.render(index) for index in range(2)]
    with Simulation(playing) as simulation:
        back = [simulation.render(index) for index in (1, 0)][::-1]
    for one, other in zip(straight, back, strict=True):
        assert one.frame.time_s == other.frame.time_s
        np.testing.assert_array_equal(one.truth.surfaces_m, other.truth.surfaces_m)
        for mine, its in zip(one.frame.pictures, other.frame.pictures, strict=True):
            assert (mine is None) == (its is None)
            if mine is not None:
                np.testing.assert_array_equal(mine, its)


def test_the_tracker_is_told_the_faulty_calibration_and_the_truth_uses_the_rig():
    error = CalibrationError(baseline=0.05)
    with Simulation(filmed(calibration_error=error)) as simulation:
        assert np.linalg.norm(simulation.rig.T) == pytest.approx(0.09)
        assert np.linalg.norm(simulation.calibration.T) == pytest.approx(0.09 * 1.05)
        truth = simulation.render(0).truth
        pixels = np.array([view.centroids_px for view in truth.views])
        for target in range(3):
            seen = pixels[:, target]
            right = to_camera(simulation.rig.left, triangulate(simulation.rig.cameras, seen))
            told = simulation.calibration
            wrong = to_camera(told.left, triangulate(told.cameras, seen))
            np.testing.assert_allclose(wrong, 1.05 * right, rtol=1e-5)  # rays miss each other
