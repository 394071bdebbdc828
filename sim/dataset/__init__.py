"""Labelled stereo data sets on disk: what is written, read back, verified and exported."""
