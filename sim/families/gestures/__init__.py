"""Gestures: what the steps of a script are made of, and the plan of a script."""
