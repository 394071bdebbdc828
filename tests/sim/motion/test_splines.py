"""Our splines against SciPy's, whose arithmetic they follow: the same bits."""

import platform

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.linalg import solve_banded

from sim.motion.splines import cubic, monotone, solve_tridiagonal

# Elsewhere compilers may fuse products and sums, in SciPy's code and not in ours.
SAME_BITS = platform.machine().lower() in ("x86_64", "amd64")


def assert_same(mine, theirs):
    assert mine.shape == np.shape(theirs)
    if SAME_BITS:
        np.testing.assert_array_equal(mine, theirs)
    else:
        np.testing.assert_allclose(mine, theirs, rtol=1e-9, atol=1e-12)


@st.composite
def paths(draw, least=2):
    n, seed = draw(st.integers(least, 90)), draw(st.integers(0, 2**32 - 1))
    shape = draw(st.sampled_from([(), (3,), (2, 4)]))
    rng = np.random.default_rng(seed)
    x = np.concatenate([[0.0], np.cumsum(rng.uniform(1e-3, 1.0, n - 1) ** 2)])
    y = rng.normal(size=(n, *shape))
    y[rng.random(n) < draw(st.sampled_from([0.0, 0.3]))] = 0.5  # plateaus
    return x / x[-1], y, rng


def assert_alike(mine, theirs, rng, outside):
    x = np.asarray(theirs.x)
    at = np.concatenate([x, rng.uniform(0.0, 1.0, 40), outside])
    for derivative in (0, 1, 2):
        assert_same(mine(at, derivative), theirs(at, derivative))
        assert_same(mine(float(at[-1]), derivative), theirs(float(at[-1]), derivative))


OUTSIDE = np.array([-0.2, 1.3])
FEW = settings(max_examples=40, deadline=None)


@FEW
@given(paths(), st.sampled_from(["natural", (0.3, -2.0)]))
def test_open_splines_are_scipys(path, ends):
    x, y, rng = path
    given_ends = ends if ends == "natural" else tuple((1, np.full(y.shape[1:], e)) for e in ends)
    assert_alike(cubic(x, y, ends), CubicSpline(x, y, bc_type=given_ends), rng, OUTSIDE)


@FEW
@given(paths(least=4))
def test_splines_of_one_polynomial_at_the_ends_are_scipys_and_so_are_integrals(path):
    x, y, rng = path
    mine, theirs = cubic(x, y, "not-a-knot"), CubicSpline(x, y)
    assert_alike(mine, theirs, rng, OUTSIDE)
    assert_alike(mine.antiderivative(), theirs.antiderivative(), rng, OUTSIDE)


@FEW
@given(paths(least=3))
def test_closed_splines_are_scipys(path):
    x, y, rng = path
    y[-1] = y[0]
    mine, theirs = cubic(x, y, "periodic"), CubicSpline(x, y, bc_type="periodic")
    assert_alike(mine, theirs, rng, OUTSIDE)
    assert_alike(mine.antiderivative(), theirs.antiderivative(), rng, np.zeros(0))


@FEW
@given(paths())
def test_monotone_splines_are_scipys(path):
    x, y, rng = path
    assert_alike(monotone(x, y), PchipInterpolator(x, y), rng, OUTSIDE)


@FEW
@given(st.integers(1, 60), st.integers(0, 2**32 - 1))
def test_equations_are_solved_as_lapack_does_with_pivots(n, seed):
    rng = np.random.default_rng(seed)
    banded, b = rng.normal(size=(3, n)), rng.normal(size=(n, 2))  # not dominated by the diagonal
    lower = np.concatenate([[0.0], banded[2, :-1]])
    upper = np.concatenate([banded[0, 1:], [0.0]])
    mine = solve_tridiagonal(lower, banded[1], upper, b)
    if n == 1:  # SciPy divides by another way
        np.testing.assert_allclose(mine, b / banded[1])
    else:
        assert_same(mine, solve_banded((1, 1), banded, b))


@pytest.mark.parametrize("ends", ["natural", "not-a-knot"])
def test_a_straight_line_stays_one(ends):
    x = np.array([0.0, 0.1, 0.5, 0.7, 1.0])
    at = np.linspace(-1.0, 2.0, 31)
    np.testing.assert_allclose(cubic(x, 2.0 * x - 1.0, ends)(at), 2.0 * at - 1.0, atol=1e-12)
