"""Charts as SVG: bars, lines, the speed curve, paths in space."""
