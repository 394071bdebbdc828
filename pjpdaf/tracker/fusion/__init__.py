"""Fusion: the update of the prediction by all views, one reading of Eq. 3.39-3.44 a file."""
