"""Hypothesis tracker: joint configurations of head and hands over stereo candidates."""
