import math
from dataclasses import replace

import numpy as np
import pytest

from sim.camera.colour import GAMMA, balance_rgb, light_rgb
from sim.camera.sensor import RANKS, expose, light_gains, mean_light, quantiles, rounded_gaussian
from sim.randomness import generator
from sim.specs import CalibrationError, ClockSpec, RigSpec, SensorSpec

SILENT = {"noise_sd": 0.0}


def grey(level, size=(200, 200)):
    return np.full((*size, 3), level, np.uint8)


def light(picture):
    return (np.asarray(picture, float) / 255.0) ** GAMMA


def test_noise_is_addressed_by_seed_stream_and_frame():
    picture = grey(128, (60, 80))
    for sensor in (SensorSpec(noise_sd=3.0), SensorSpec(noise_sd=1.0, shot_noise_sd=3.0)):
        plain = expose(picture, sensor, 1, "left", 0)
        np.testing.assert_array_equal(plain, expose(picture, sensor, 1, "left", 0))
        for other in ((2, "left", 0), (1, "right", 0), (1, "left", 1), (1, "background/left", 0)):
            assert (plain != expose(picture, sensor, *other)).mean() > 0.5


def test_noise_is_the_quantile_of_a_uniform_number():
    """As numpy draws and adds it; of a size that is no multiple of the generator's words."""
    picture = np.random.default_rng(0).integers(0, 256, (39, 51, 3), np.uint8)
    picture[:4], picture[4:8] = 0, 255  # where it is clipped
    ranks = generator(5, "noise/left", 3).integers(0, RANKS, picture.shape, dtype=np.uint16)
    drawn = quantiles()[ranks]
    for sensor in (SensorSpec(noise_sd=3.0), SensorSpec(noise_sd=2.0, shot_noise_sd=5.0)):
        sd = np.sqrt(sensor.noise_sd**2 + sensor.shot_noise_sd**2 * picture / 128.0)
        expected = np.clip(np.rint(picture + sd * drawn), 0, 255)
        noisy = expose(picture, sensor, 5, "left", 3)
        # Single precision rounds one of thousands to the other side of a half.
        assert (noisy != expected).mean() < (1e-3 if sensor.shot_noise_sd else 1e-12)


def test_without_any_effect_the_picture_is_the_same_and_a_copy():
    picture = np.random.default_rng(0).integers(0, 256, (40, 50, 3), np.uint8)
    same = expose(picture, SensorSpec(**SILENT), 1, "left", 0)
    np.testing.assert_array_equal(same, picture)
    assert not np.shares_memory(same, picture)


@pytest.mark.parametrize("sd", [1.0, 3.0, 12.0])
def test_noise_has_the_asked_spread(sd):
    levels = rounded_gaussian(sd).astype(float)
    # Rounding to whole levels adds 1/12; the table ends at 4.3 sd.
    assert levels.std() == pytest.approx(np.sqrt(sd**2 + 1 / 12), rel=0.003)
    assert abs(levels.mean()) < 1e-12
    noisy = expose(grey(128), SensorSpec(noise_sd=sd), 5, "left", 3).astype(float)
    assert noisy.std() == pytest.approx(sd, rel=0.02, abs=0.05)


@pytest.mark.parametrize("shot_sd", [0.0, 6.0])
def test_noise_stops_at_black_and_white(shot_sd):
    sensor = SensorSpec(noise_sd=6.0, shot_noise_sd=shot_sd)
    for level in (0, 255):
        noisy = expose(grey(level, (50, 50)), sensor, 1, "left", 0).astype(int)
        assert 0.35 < (noisy == level).mean() < 0.65
        assert abs(noisy - level).max() < 60


@pytest.mark.parametrize("seed", [100, 101])
@pytest.mark.parametrize(("read_sd", "shot_sd"), [(0.0, 4.0), (2.0, 6.0), (3.0, 12.0)])
def test_the_variance_of_shot_noise_is_a_line_over_the_signal(read_sd, shot_sd, seed):
    sensor = SensorSpec(noise_sd=read_sd, shot_noise_sd=shot_sd)
    levels = np.array([60, 80, 100, 128, 150, 180])  # black and white are 3.5 sd away
    found = [expose(grey(v), sensor, seed, "left", int(v)).astype(float) for v in levels]
    means = [picture.mean() for picture in found]
    np.testing.assert_allclose(means, levels, atol=0.15)
    slope, offset = np.polyfit(levels, [picture.var() for picture in found], 1)
    # 120 000 values a level: the variance is known to 0.4 %; rounding adds 1/12.
    assert slope == pytest.approx(shot_sd**2 / 128, rel=0.03)
    assert offset == pytest.approx(read_sd**2 + 1 / 12, abs=0.02 * shot_sd**2)


@pytest.mark.parametrize("ev", [-1.5, -1.0, 0.5, 1.0])
def test_exposure_doubles_the_light_per_ev(ev):
    for level in (40, 90, 150):
        seen = expose(grey(level), SensorSpec(exposure_ev=ev, **SILENT), 1, "left", 0)
        assert seen.std() == 0
        half_step = GAMMA * 0.5 / float(seen[0, 0, 0])  # rounding to whole values
        assert light(seen[0, 0, 0]) == pytest.approx(2**ev * light(level), rel=1.1 * half_step)


def test_white_balance_gains_each_channel_of_the_light():
    gains = (1.5, 1.0, 0.5)  # red, green, blue
    seen = expose(grey(120), SensorSpec(white_balance_rgb=gains, **SILENT), 1, "left", 0)
    np.testing.assert_allclose(light(seen[0, 0]) / light(120), gains[::-1], rtol=0.015)


@pytest.mark.parametrize("temperature_K", [2700.0, 4000.0, 7500.0])
def test_a_camera_balanced_for_the_light_shows_grey_as_grey(temperature_K):
    lit = np.rint(130 * np.array(light_rgb(temperature_K)[::-1])).astype(np.uint8)
    picture = np.broadcast_to(lit, (10, 10, 3)).copy()
    balanced = SensorSpec(white_balance_rgb=balance_rgb(temperature_K), **SILENT)
    assert np.ptp(lit) > 8
    np.testing.assert_allclose(expose(picture, balanced, 1, "left", 0), 130, atol=1.2)


def test_overexposure_is_white_and_nothing_wraps_round():
    ramp = np.repeat(np.arange(256, dtype=np.uint8), 3).reshape(1, 256, 3)
    seen = expose(ramp, SensorSpec(exposure_ev=1.5, **SILENT), 1, "left", 0)[0, :, 0].astype(int)
    assert (np.diff(seen) >= 0).all()
    assert (seen[200:] == 255).all()


@pytest.mark.parametrize("hz", [100.0, 120.0])
def test_flicker_has_its_frequency_and_size(hz):
    sensor = SensorSpec(flicker=0.05, flicker_hz=hz, flicker_rad=0.7)
    times = np.arange(1000) / 1000.0
    gains = np.array([light_gains(sensor, t)[1] for t in times])
    spectrum = np.abs(np.fft.rfft(gains - gains.mean()))
    assert int(spectrum.argmax()) == hz  # 1 s of samples: 1 Hz a bin
    assert np.ptp(gains) / 2 == pytest.approx(0.05, rel=0.03)
    assert gains[0] == pytest.approx(1 + 0.05 * math.sin(0.7))
    quiet = replace(sensor, noise_sd=0.0)
    bright, dark = (
        light(expose(grey(180), quiet, 1, "left", 0, times[k])).mean()
        for k in (gains.argmax(), gains.argmin())
    )
    assert bright / dark == pytest.approx(1.05 / 0.95, rel=0.02)


def test_an_exposure_of_whole_periods_does_not_see_the_flicker():
    times = np.linspace(0, 0.05, 400)

    def swing(exposure_s):
        sensor = SensorSpec(flicker=0.05, exposure_time_s=exposure_s)
        return np.ptp([light_gains(sensor, t)[0] for t in times]) / 2

    assert swing(0.02) < 1e-12
    assert swing(0.005) == pytest.approx(0.05 * 2 / math.pi, rel=0.01)


def test_jpeg_leaves_blocks_of_eight_pixels_and_the_same_bytes_twice():
    y, x = np.mgrid[:240, :320]
    values = 60 + x / 4 + y / 4 + np.random.default_rng(3).normal(0, 6, x.shape)
    picture = np.repeat(np.clip(np.rint(values), 0, 255).astype(np.uint8)[..., None], 3, axis=2)

    def blockiness(seen):
        """Steps across the borders of blocks over the steps within them."""
        steps = np.abs(np.diff(seen[..., 1].astype(float), axis=1)).mean(axis=0)
        border = np.arange(1, 320) % 8 == 0
        return steps[border].mean() / steps[~border].mean()

    rough = expose(picture, SensorSpec(jpeg_quality=60, **SILENT), 1, "left", 0)
    fine = expose(picture, SensorSpec(jpeg_quality=95, **SILENT), 1, "left", 0)
    again = expose(picture, SensorSpec(jpeg_quality=60, **SILENT), 1, "left", 0)
    np.testing.assert_array_equal(rough, again)
    assert blockiness(picture) == pytest.approx(1.0, abs=0.05)
    assert blockiness(rough) > 1.15
    error = [np.abs(p.astype(int) - picture).mean() for p in (rough, fine)]
    assert error[0] > 1.3 * error[1] > 0


def test_the_mean_is_of_light_and_not_of_values():
    mean = mean_light([grey(0), grey(200)])
    assert light(mean[0, 0, 0]) == pytest.approx(light(200) / 2, rel=0.02)
    assert mean[0, 0, 0] > 130
    ramp = np.arange(256, dtype=np.uint8).reshape(1, 256, 1).repeat(3, axis=2)
    for count in (1, 2, 3, 15):
        np.testing.assert_array_equal(mean_light([ramp] * count), ramp)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: SensorSpec(noise_sd=-1.0), "SensorSpec.noise_sd must not be negative, got -1"),
        (lambda: SensorSpec(shot_noise_sd=-1.0), "SensorSpec.shot_noise_sd must not be negative"),
        (lambda: SensorSpec(exposure_time_s=math.nan), "exposure_time_s must be finite, got nan"),
        (lambda: SensorSpec(skew_s=-0.01), "SensorSpec.skew_s must not be negative"),
        (lambda: SensorSpec(exposure_ev=math.inf), "SensorSpec.exposure_ev must be finite"),
        (lambda: SensorSpec(white_balance_rgb=(1.0, -1.0, 1.0)), "white_balance_rgb must not be"),
        (lambda: SensorSpec(flicker=1.5), "SensorSpec.flicker must be from 0 to 1, got 1.5"),
        (lambda: SensorSpec(flicker=-0.1), "SensorSpec.flicker must be from 0 to 1"),
        (lambda: SensorSpec(flicker_hz=math.nan), "SensorSpec.flicker_hz must be finite"),
        (lambda: SensorSpec(jpeg_quality=101), "SensorSpec.jpeg_quality must be from 1 to 100"),
        (lambda: ClockSpec(jitter_s=-1.0), "ClockSpec.jitter_s must not be negative"),
        (lambda: ClockSpec(dropped=1.1), "ClockSpec.dropped must be from 0 to 1"),
        (lambda: ClockSpec(dropped=math.nan), "ClockSpec.dropped must be finite"),
        (lambda: ClockSpec(stamps="late"), "ClockSpec.stamps must be actual or nominal, got 'late"),
        (lambda: CalibrationError(baseline=-1.0), "CalibrationError.baseline must be above -1"),
        (lambda: CalibrationError(focal=math.nan), "CalibrationError.focal must be finite"),
        (lambda: CalibrationError(rotation_rad=(0, math.nan, 0)), "rotation_rad must be finite"),
        (lambda: RigSpec(focal_px=0.0), "RigSpec.focal_px must be above 0"),
        (lambda: RigSpec(distortion=(math.nan,)), "RigSpec.distortion must be finite"),
        (lambda: RigSpec(principal_offset_px=(math.inf, 0)), "principal_offset_px must be finite"),
    ],
)
def test_numbers_that_no_camera_has_are_refused_by_name(make, message):
    with pytest.raises(ValueError, match=message):
        make()
