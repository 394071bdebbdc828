"""Checks of the pictures and labels of a frame."""
