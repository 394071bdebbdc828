"""Recordings for the Rerun viewer: what they share, and those of saved runs."""
