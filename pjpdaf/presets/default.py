"""Preset 'default': blobs with their looks, and hypotheses over joint configurations."""

from __future__ import annotations

from pjpdaf.detector.adaptation import BlobDetectorParameters
from pjpdaf.presets.record import Departure, Preset
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters

DEFAULT = Preset(
    "default",
    BlobDetectorParameters(),
    HypothesisParameters(),
    (
        Departure(
            "detector",
            "k-means over the skin pixels (section 3.1.2)",
            "the components themselves, each with its pixels, the direction of its fingers and a "
            "silhouette of the person; the tracker splits them",
            "only the tracker knows whether two hands, or a hand and the head, are in a blob",
            "see docs/tracker.md",
        ),
        Departure(
            "association",
            "per-view JPDA (section 3.4)",
            "joint configurations of both hands over stereo-consistent pairs, five hypotheses kept",
            "pairs of views say where a blob is in depth; a doubt that lasts needs more than one "
            "account of it",
            "see docs/tracker.md",
        ),
        Departure(
            "left and right",
            "by motion alone",
            "by the sleeve: a clothed arm from each shoulder, fitted to the silhouette",
            "no method that knows positions only can tell a crossing from a bounce",
            "see docs/tracker.md",
        ),
        Departure(
            "filter",
            "constant velocity (section 3.2)",
            "a random walk whose step is a mixture of resting, moving and fast",
            "hands start and stop between frames; their velocity says little of the next frame",
            "see docs/tracker.md",
        ),
        Departure(
            "offsets",
            "none",
            "from the visible surface to the body's centre, from the palm's middle instead of the "
            "fingers' centroid",
            "a camera sees the front of a head and a hand",
            "see docs/tracker.md",
        ),
    ),
)
