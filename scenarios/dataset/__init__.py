"""The verbs of `dataset`: make, verify, export, show."""
