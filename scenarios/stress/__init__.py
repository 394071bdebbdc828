"""Stress: search, shrink, map and estimate the failures of a tracker."""
