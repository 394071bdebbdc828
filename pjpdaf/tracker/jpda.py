"""Joint probabilistic data association, thesis 3.4: gates, feasible events, association weights."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pjpdaf.arrays import Bools, Floats

# One cluster of overlapping gates costs measurements * 2^targets * targets in time and memory.
LARGEST_CLUSTER = 20
_MATRICES_TO = 4  # targets; above, 2^T x 2^T matrices cost more than they save
_SPLIT_ABOVE = 6  # targets; below, finding the clusters costs more than it saves


def squared_distances(innovations: Floats, S_inverse: Floats) -> Floats:
    """Mahalanobis distances squared z^T S^-1 z (Eq. 3.24).

    innovations (m, T, r) [px]; S_inverse (T, r, r) [px^-2]; returns (m, T), NaN where they are.
    """
    weighted = np.matmul(innovations[:, :, None], S_inverse)[:, :, 0]
    return np.asarray((weighted * innovations).sum(axis=2))


def clusters(gated: Bools) -> list[tuple[list[int], list[int]]]:
    """Targets whose gates share measurements, and those measurements, from gated (m, T).

    Every target is in exactly one cluster; a cluster may hold no measurement.
    """
    groups: list[tuple[int, int]] = []  # bit sets: targets, measurements
    for t, column in enumerate(gated.T.tolist()):
        targets = 1 << t
        measurements = sum(1 << j for j, inside in enumerate(column) if inside)
        apart = []
        for other in groups:
            if other[1] & measurements:
                targets, measurements = targets | other[0], measurements | other[1]
            else:
                apart.append(other)
        groups = [*apart, (targets, measurements)]
    return [(_bits(targets), _bits(measurements)) for targets, measurements in sorted(groups)]


def _bits(number: int) -> list[int]:
    return [i for i in range(number.bit_length()) if number >> i & 1]


def association_probabilities(
    likelihood: ArrayLike, gated: ArrayLike, p_detect: ArrayLike, clutter: float
) -> Floats:
    """Return the weights beta of Eq. 3.33-3.34 in one view, (m + 1, T); row 0: not detected.

    likelihood (m, T): N of Eq. 3.32, in the unit of `clutter`, the C of Eq. 3.32; gated (m, T);
    p_detect a number or (T,), 0..1. Exact: the sum over all feasible events is a recursion over
    measurements whose state is the set of targets already used, O(m 2^T T).

    Raises ValueError on wrong shapes or values, on a cluster of more than `LARGEST_CLUSTER`
    targets, and where no feasible event has a probability above zero.
    """
    L = np.asarray(likelihood, dtype=np.float64)
    mask = np.asarray(gated, dtype=bool)
    if L.ndim != 2 or mask.shape != L.shape:
        raise ValueError(
            f"likelihood and gated must both have shape (m, T), got {L.shape} and {mask.shape}"
        )
    T = L.shape[1]
    PD = np.empty(T)
    PD[:] = p_detect
    if not (0.0 <= clutter < math.inf and all(0.0 <= p <= 1.0 for p in PD.tolist())):
        raise ValueError(
            f"clutter must be at least 0 and p_detect within 0..1, got {clutter} and {PD}"
        )
    L = np.where(mask, L, 0.0)
    if not all(0.0 <= x < math.inf for x in L.ravel().tolist()):  # false for NaN
        raise ValueError("likelihood must be finite and at least 0 inside the gates")
    if T <= _SPLIT_ABOVE:
        return _cluster_weights(L, PD, clutter)
    beta = np.zeros((len(L) + 1, T))
    for targets, measurements in clusters(mask):
        if len(targets) > LARGEST_CLUSTER:
            raise ValueError(
                f"{len(targets)} targets share measurements, more than {LARGEST_CLUSTER}; "
                "lower the gate"
            )
        inner = _cluster_weights(L[np.ix_(measurements, targets)], PD[targets], clutter)
        beta[np.ix_([0, *(j + 1 for j in measurements)], targets)] = inner
    return beta


def _cluster_weights(L: Floats, PD: Floats, clutter: float) -> Floats:
    m, T = L.shape
    beta = np.zeros((m + 1, T))
    # A measurement outside every gate is clutter in all events: a common factor.
    top = L.max(axis=1, initial=0.0)
    used = top.nonzero()[0]
    if len(used):
        L = L[used]
        # Each event has exactly one factor a measurement, so a row may be scaled at will.
        scale = np.maximum(top[used], clutter)
        L = L / scale[:, None]
        C = clutter / scale
        if _spread(L, C, PD) > 280.0:
            beta[used + 1] = _logarithmic(L, C, PD)
        else:
            beta[used + 1] = (_by_matrices if T <= _MATRICES_TO else _linear)(L, C, PD)
    beta[0] = 1.0 - beta[1:].sum(axis=0)  # Eq. 3.34
    np.maximum(beta[0], 0.0, out=beta[0])  # rounding may leave -1e-16
    return beta


def _spread(L: Floats, C: Floats, PD: Floats) -> float:
    """Decimal orders between the sum of all events and the smallest one, at most."""
    m, T = L.shape
    factors = [*L.ravel().tolist(), *C.tolist()]  # plain numbers: few, several times as fast
    smallest = min(1.0, *(x for x in factors if x > 0.0))
    odds = min(min(p or 1.0, 1.0 - p or 1.0) for p in PD.tolist())
    return float(m * (math.log10(T + 1) - math.log10(smallest)) - T * math.log10(odds))


_IMPOSSIBLE = "no feasible event has a probability above 0; raise clutter above 0 or lower p_detect"


@lru_cache(maxsize=32)
def _subsets(T: int) -> tuple[NDArray[np.intp], NDArray[np.intp], Bools]:
    """Per subset s (bits) and target t, (2^T, T): s less t, s with t, t in s; 2^T: impossible."""
    sets = np.arange(1 << T)[:, None]
    bit = 1 << np.arange(T)
    member = (sets & bit) > 0
    nowhere = 1 << T
    without = np.where(member, sets ^ bit, nowhere)
    joined = np.where(member, nowhere, sets | bit)
    return without, joined, member


@lru_cache(maxsize=32)
def _joins(T: int) -> Floats:
    """(T + 1, 2^T, 2^T): entry (t, s, u) is 1 where u is s with t; the last is the identity."""
    _, joined, _ = _subsets(T)
    return np.array([*(np.eye((1 << T) + 1)[joined[:, t], :-1] for t in range(T)), np.eye(1 << T)])


def _by_matrices(L: Floats, C: Floats, PD: Floats) -> Floats:
    """Weights (m, T) of rows scaled to a largest factor of 1, for few targets.

    The sum over events is a product of matrices, one per measurement, from set to set.
    """
    m, T = L.shape
    joins = _joins(T)
    size = 1 << T
    factors = np.concatenate([L, C[:, None]], axis=1)
    A = (factors @ joins.reshape(T + 1, -1)).reshape(m, size, size)
    ahead = np.zeros((m, size))
    ahead[0, 0] = 1.0
    for j in range(m - 1):
        np.matmul(ahead[j], A[j], out=ahead[j + 1])
    behind = np.empty((m, size))
    behind[-1] = np.where(_subsets(T)[2], PD, 1.0 - PD).prod(axis=1)
    for j in range(m - 1, 0, -1):
        np.matmul(A[j], behind[j], out=behind[j - 1])
    total = ahead[0] @ A[0] @ behind[0]
    if not total > 0.0:
        raise ValueError(_IMPOSSIBLE)
    pairs = ((ahead @ joins[:T]) * behind).sum(axis=2)  # (T, m)
    return np.asarray(L * pairs.T / total)


def _linear(L: Floats, C: Floats, PD: Floats) -> Floats:
    """Weights (m, T) as `_by_matrices`, for many targets: O(m 2^T T)."""
    m, T = L.shape
    without, joined, member = _subsets(T)
    size = 1 << T
    ahead = np.zeros((m, size))  # weight of reaching each set before measurement j
    now = np.zeros(size + 1)
    now[0] = 1.0
    for j in range(m):
        ahead[j] = now[:size]
        now[:size] = C[j] * now[:size] + now[without] @ L[j]
    now[:size] = np.where(member, PD, 1.0 - PD).prod(axis=1)
    beta = np.empty((m, T))
    for j in range(m - 1, -1, -1):
        onward = now[joined]
        beta[j] = (ahead[j] @ onward) * L[j]
        now[:size] = C[j] * now[:size] + onward @ L[j]
    if not now[0] > 0.0:  # the weight of all events together
        raise ValueError(_IMPOSSIBLE)
    return np.asarray(beta / now[0])


def _logarithmic(L: Floats, C: Floats, PD: Floats) -> Floats:
    """Weights (m, T) as `_linear`, in logarithms: slower, and safe for any spread of factors."""
    m, T = L.shape
    without, joined, member = _subsets(T)
    size = 1 << T
    with np.errstate(divide="ignore"):
        log_l, log_c, detected, missed = np.log(L), np.log(C), np.log(PD), np.log1p(-PD)
    add: Any = np.logaddexp
    ahead = np.zeros((m, size))
    now = np.full(size + 1, -np.inf)
    now[0] = 0.0
    for j in range(m):
        ahead[j] = now[:size]
        now[:size] = add(log_c[j] + now[:size], add.reduce(now[without] + log_l[j], axis=1))
    now[:size] = np.where(member, detected, missed).sum(axis=1)
    beta = np.empty((m, T))
    for j in range(m - 1, -1, -1):
        onward = now[joined]
        pairs = add.reduce(ahead[j][:, None] + onward, axis=0) + log_l[j]
        step = add(log_c[j] + now[:size], add.reduce(onward + log_l[j], axis=1))
        total = add.reduce(ahead[j] + step)
        if not np.isfinite(total):
            raise ValueError(_IMPOSSIBLE)
        beta[j] = np.exp(pairs - total)
        now[:size] = step
    return beta
