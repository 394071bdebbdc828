"""Presentation of a stress test: failures, maps, curves, probabilities, on one page."""
