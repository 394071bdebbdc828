"""Scenarios: parameters, units, files, names, and the draw of concrete values."""
