"""Things in a row never overlap and stay within their span."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from sim.surroundings.layout import in_a_row


@given(
    seed=st.integers(0, 1000),
    span=st.floats(0.5, 6.0),
    widths=st.lists(st.floats(0.1, 2.0), max_size=9),
)
def test_things_in_a_row_do_not_overlap(seed, span, widths):
    places = in_a_row(np.random.default_rng(seed), (-1.0, span - 1.0), widths)
    assert len(places) == len(widths)
    placed = sorted((p, w) for p, w in zip(places, widths, strict=True) if p is not None)
    edge = -1.0
    for middle, width in placed:
        assert middle - width / 2 >= edge - 1e-9
        edge = middle + width / 2
    assert edge <= span - 1.0 + 1e-9
    # The first is kept wherever it fits.
    assert not widths or (places[0] is not None) == (widths[0] <= span)
