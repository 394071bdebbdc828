"""The map of failures over one parameter or two."""
