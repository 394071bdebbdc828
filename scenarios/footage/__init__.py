"""The verbs of real footage: track, calibrate."""
