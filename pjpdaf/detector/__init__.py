"""Hands and head detection, thesis 3.1: pictures to ellipses."""
