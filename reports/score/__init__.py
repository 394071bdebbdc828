"""Scores of a played episode: errors, events, multi-object tracking metrics."""
