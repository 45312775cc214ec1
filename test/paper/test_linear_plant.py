"""Equation (15) against closed forms, scipy and numpy; the paper's slips."""

from __future__ import annotations

import math

import control
import numpy as np
import pytest
from scipy.signal import ss2tf

from microgripper_control.control.identified import Identified
from microgripper_control.control.linearised import Linearised
from microgripper_control.paper import printed
from microgripper_control.paper.linear_plant import (
    reproduce_linear_plant,
    state_space,
    transfer_function,
)

AS_PRINTED = Linearised(printed.K1, printed.K2)


@pytest.mark.parametrize("flexure", [False, True])
def test_the_transfer_function_agrees_with_scipy_and_numpy(
    identified: Identified, flexure: bool
) -> None:
    found = transfer_function(identified, AS_PRINTED, flexure=flexure)
    v = identified
    stiffness = v.k + flexure * v.k_s
    a = np.array([[0, 1, 0], [-stiffness / v.m, -v.b / v.m, -v.k / v.m], [0, 0, printed.K2]])
    b = np.array([[0], [v.k * (v.d - printed.K1) / v.m], [printed.K1 * printed.K2]])
    numerator, denominator = ss2tf(a, b, np.array([[1, 0, 0]]), np.array([[0]]))
    assert found.numerator == pytest.approx(numerator[0, -2:], rel=1e-6)
    assert found.denominator == pytest.approx(denominator, rel=1e-9)
    poles = np.roots(denominator)
    assert found.fast_pole == pytest.approx(poles[np.argmax(poles.imag)], rel=1e-9)
    assert found.slow_pole == pytest.approx(printed.K2, rel=1e-9)
    assert found.zero == pytest.approx(np.roots(numerator[0, -2:])[0], rel=1e-6)


def test_the_coefficients_agree_with_closed_forms(identified: Identified) -> None:
    v = identified
    found = transfer_function(v, AS_PRINTED, flexure=True)
    force = v.k / v.m
    assert found.numerator == pytest.approx(
        (force * (v.d - printed.K1), -force * v.d * printed.K2), rel=1e-6
    )
    assert found.zero == pytest.approx(printed.K2 * v.d / (v.d - printed.K1), rel=1e-6)
    assert found.fast_pole.real == pytest.approx(-v.b / (2.0 * v.m), rel=1e-9)
    assert abs(found.fast_pole) == pytest.approx(math.sqrt((v.k + v.k_s) / v.m), rel=1e-9)


@pytest.mark.parametrize("omega", [0.1, 10.0, 1e4, 1.2e5])
def test_the_frequency_response_is_that_of_the_equations(
    identified: Identified, omega: float
) -> None:
    v = identified
    s = 1j * omega
    h = printed.K1 * s / (s - printed.K2)  # per volt, (7)
    x = v.k * (v.d - h) / (v.m * s**2 + v.b * s + v.k + v.k_s)  # per volt, (4)
    assert state_space(v, AS_PRINTED, flexure=True)(s) == pytest.approx(x, rel=1e-9)


def test_the_slow_gain_has_no_hysteresis_left(identified: Identified) -> None:
    system = state_space(identified, AS_PRINTED, flexure=True)
    assert control.dcgain(system) == pytest.approx(identified.gain, rel=1e-9)


def test_the_slips_of_equation_15_come_out_of_the_computation(identified: Identified) -> None:
    found = reproduce_linear_plant(identified, AS_PRINTED)
    plain = found.without_flexure
    assert plain.denominator[3] == pytest.approx(7.013e9, rel=1e-3)
    assert plain.numerator[1] == pytest.approx(1.013e3, rel=1e-3)
    assert plain.numerator[0] == pytest.approx(printed.NUMERATOR[0], rel=1e-3)
    assert found.implied_k2["slow pole = k2"] == pytest.approx(-0.553, abs=1e-3)
    assert found.implied_k2["a0 = -k2 k/m"] == pytest.approx(-0.553, abs=1e-3)
    zero = found.implied_k2["zero = k2 d/(d - k1)"]
    assert abs(zero - printed.K2) > 0.01
    assert abs(zero - printed.SLOW_POLE) > 0.003
    assert found.printed_fast_pole == pytest.approx(printed.FAST_POLE, rel=1e-4)


def test_the_flexure_stiffens_the_plant(identified: Identified) -> None:
    found = reproduce_linear_plant(identified, AS_PRINTED)
    share = (identified.k + identified.k_s) / identified.k
    for index in (2, 3):
        ratio = found.with_flexure.denominator[index] / found.without_flexure.denominator[index]
        assert ratio == pytest.approx(share, rel=1e-4)
