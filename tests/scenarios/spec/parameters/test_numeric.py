"""Numbers: quantiles and shares of their distributions, values set by hand."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from scenarios.spec.parameters.distributions import Fixed, LogUniform, Normal, Uniform
from scenarios.spec.parameters.numeric import Numeric

NOMINALS = (
    Uniform(kind="uniform"),
    Uniform(kind="uniform", low=0.2, high=0.4),
    LogUniform(kind="log-uniform", low=0.15),
    Normal(kind="normal", mean=0.3, sd=0.1),
)


@pytest.mark.parametrize("nominal", NOMINALS, ids=lambda n: n.kind)
@given(share=st.floats(0.001, 0.999))
def test_cdf_undoes_quantile_and_values_stay_in_range(nominal, share):
    parameter = Numeric(unit="m/s", range=(0.1, 0.6), nominal=nominal)
    value = parameter.quantile(share)
    assert 0.1 <= value <= 0.6
    assert parameter.cdf(value) == pytest.approx(share, abs=1e-9)


def test_a_fixed_parameter_is_always_its_value_but_may_be_set():
    parameter = Numeric(unit="m", range=(0.2, 0.4), nominal=Fixed(kind="fixed", value=0.35))
    assert {parameter.quantile(s) for s in (0.0, 0.5, 0.99)} == {0.35}
    assert parameter.check("length", "30 cm") == pytest.approx(0.3)


def test_the_latent_of_the_median_is_zero_and_of_a_normal_its_z():
    wide = Numeric(unit="m", range=(-9, 9), nominal=Normal(kind="normal", mean=1.0, sd=0.5))
    assert wide.latent(1.0) == pytest.approx(0.0, abs=1e-12)
    assert wide.latent(1.5) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("unit", [["m"], {"m": 1}, 3, None])
def test_a_unit_that_is_no_word_is_a_fault_of_the_file(unit):
    with pytest.raises(ValidationError, match="unit"):
        Numeric.model_validate({"unit": unit, "range": [0, 1], "nominal": {"kind": "uniform"}})
