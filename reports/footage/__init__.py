"""Results on real footage: track files and their page."""
