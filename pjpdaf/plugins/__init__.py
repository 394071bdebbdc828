"""Detectors and trackers by name, and the checks that those of users go through."""
