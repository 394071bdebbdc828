"""Summaries of a run: by target, by scenario, by group, and the error budget."""
