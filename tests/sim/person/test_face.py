"""The face's texture: what is left alone would not change."""

from dataclasses import replace

import numpy as np
import pytest

from sim.person.face import EXPRESSIONS, _Canvas, face_texture
from sim.specs import Appearance


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_a_feature_changes_nothing_beyond_the_rows_that_it_is_painted_in(monkeypatch, expression):
    look = replace(Appearance(), expression=expression, beard=True)

    def painted():
        return face_texture(np.random.default_rng(3), look, 160)

    by_rows = painted()
    monkeypatch.setattr(_Canvas, "rows", lambda self, low_m, high_m: slice(None))
    np.testing.assert_array_equal(by_rows, painted())
    assert by_rows.std() > 20
