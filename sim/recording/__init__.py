"""Rendered sequences on disk, to be played again without rendering: light before the sensor."""
