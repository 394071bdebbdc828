"""Recorded motion: clips, their files, and their transfer to another body."""
