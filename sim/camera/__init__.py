"""The cameras: rendering, rays, sensor, exposure, clock, and the calibration self-test."""
