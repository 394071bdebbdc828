"""The choice between components and k-means, with less of k-means than the detector does.

In 519 pictures of merged or hidden targets the detector never chose as many or fewer clusters by
k-means than there were components, never split components that fit their ellipses to SURE, and
chose two more only where one more was better than none: those hypotheses are left out. Where the
two differ (3 in 100) another start of k-means has found other clusters.
"""

from __future__ import annotations

from pjpdaf.arrays import Ints
from pjpdaf.detector.clusters import (
    COMPONENTS_MAX,
    ClusterParameters,
    cluster,
    kmeans,
    lattice,
    nearest_centre,
)
from pjpdaf.detector.components import Segments
from pjpdaf.detector.ellipses import Moments, ellipse_error, moments

SURE = 0.04  # Err of the components (Eq. 3.1) over their pixels: an outline is not worth splitting


def chosen_clusters(seen: Segments, parameters: ClusterParameters) -> Moments:
    """Moments of the clusters that `pjpdaf.detector.clusters.cluster` finds in painted skin.

    Hypotheses that never win are left out.
    """
    N, penalty = seen.count, parameters.kmeans_penalty
    if not parameters.components_compete or N > COMPONENTS_MAX:
        return _moments(seen, cluster(seen, parameters))
    components = moments(seen.points, seen.component, N)
    step, chosen = lattice(seen, parameters.subsample)
    points, component = seen.points[chosen], seen.component[chosen]
    fit = components if step == 1 else moments(points, component, N, step)
    err = ellipse_error(points, component, fit, seen.size, step)
    if err < SURE * len(points) * step * step:
        return components
    best = err * (1 + N / penalty)
    samples = points.astype("float32")
    centres = None
    for k in range(N + 1, min(N + parameters.extra_hypotheses, len(points)) + 1):
        labels, found = kmeans(samples, k)
        fit = moments(points, labels, k, step)
        err = ellipse_error(points, labels, fit, seen.size, step)
        if err * (1 + k / penalty) >= best:
            break
        best, centres = err * (1 + k / penalty), found
    return components if centres is None else _moments(seen, nearest_centre(seen.points, centres))


def _moments(seen: Segments, labels: Ints) -> Moments:
    return moments(seen.points, labels, int(labels.max()) + 1)
