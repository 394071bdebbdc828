"""Checks of a data set from its files alone: a module per kind of file or label."""
