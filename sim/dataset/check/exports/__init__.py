"""Checks of the exports against the sequences that they repeat."""
