"""The name of the preset that is used where none is named; imports nothing."""

DEFAULT_PRESET = "default"
