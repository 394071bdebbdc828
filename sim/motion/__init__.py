"""Motion in continuous time: strokes, curves, plans of hand paths, and their measurement."""
