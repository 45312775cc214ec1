"""Classes and safe ranges against what simulated h and displacement do."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from microgripper_control.core.signals import Array
from microgripper_control.effects.bouc_wen_behaviour import BehaviourClass, behaviour, classify
from microgripper_control.effects.material.bouc_wen import advance

D, ALPHA = 1.4447e-7, 0.0801
TABLE_1 = {"d": D, "alpha": ALPHA, "beta": 0.0152, "gamma": -0.0227, "n": 1.0}


def values(beta: float, gamma: float, n: float = 1.0, alpha: float = ALPHA) -> dict[str, float]:
    """beta and gamma per volt at h = 1 um, so that any n gives h of about that size."""
    size = 1e-6 ** (n - 1.0)
    return {"d": D, "alpha": alpha, "beta": beta / size, "gamma": gamma / size, "n": n}


def follow(v: dict[str, float], voltage: Array, h: float = 0.0) -> Array:
    result = np.empty(len(voltage))
    u = float(voltage[0])
    for k, new in enumerate(voltage):
        h = advance(h, float(new) - u, v["alpha"] * v["d"], v["beta"], v["gamma"], v["n"])
        u, result[k] = float(new), h
    return result


def settled_displacement(v: dict[str, float], span: float, steps: int = 400) -> Array:
    """d u - h on the way up of a settled cycle over `span` volts, then on the way down.

    Begun near the settled h: with n > 1 a rise from h = 0 may not survive the range.
    """
    cycle = np.concatenate([np.linspace(0.0, span, steps), np.linspace(span, 0.0, steps)[1:]])
    voltage = np.tile(cycle, 30)
    turning = behaviour(v).turning_hysteresis
    free = v["d"] * voltage - follow(v, voltage, -turning if math.isfinite(turning) else 0.0)
    return free[-len(cycle) :]


def backward_motion(v: dict[str, float], span: float) -> float:
    """How far the displacement runs against the voltage in a settled cycle, m."""
    loop = settled_displacement(v, span)
    up, down = np.diff(loop[:400]), np.diff(loop[400:])
    return float(max(0.0, -up.min(), down.max()))


def test_table_1_is_not_bounded_but_behaves_within_160_volts() -> None:
    found = behaviour(TABLE_1)
    assert found.kind is BehaviourClass.GROWING
    assert not found.kind.bounded
    above, below = TABLE_1["beta"] + TABLE_1["gamma"], TABLE_1["beta"] - TABLE_1["gamma"]
    # By hand, n = 1: ln(1/alpha)/(beta - gamma) to zero, then an exponential up to H*.
    late = math.log1p(-above / below * (1.0 - ALPHA) / ALPHA) / -above
    assert found.safe_span == pytest.approx(math.log(1.0 / ALPHA) / below + late, rel=1e-9)
    assert found.first_rise == pytest.approx(late, rel=1e-9)
    assert found.safe_span == pytest.approx(225.0, abs=1.0)
    assert found.safe_span / 2.0 == pytest.approx(112.0, abs=1.0)


@pytest.mark.parametrize(
    ("beta", "gamma", "n"),
    [(0.0152, -0.0227, 1.0), (0.022, -0.021, 1.0), (0.03, -0.035, 2.0), (0.02, -0.03, 1.5)],
)
def test_a_settled_cycle_turns_where_computed(beta: float, gamma: float, n: float) -> None:
    v = values(beta, gamma, n)
    span = behaviour(v).safe_span
    assert math.isfinite(span)
    assert backward_motion(v, 0.98 * span) == 0.0
    assert backward_motion(v, 1.05 * span) > 0.0


@pytest.mark.parametrize(("gamma", "n"), [(-0.03, 2.0), (-0.04, 1.5)])
def test_h_escapes_where_computed(gamma: float, n: float) -> None:
    v = values(0.01, gamma, n)
    found = behaviour(v)
    assert found.safe_span <= found.escape
    h = follow(v, np.array([0.0, 0.99, 1.01]) * found.escape)
    assert np.isfinite(h[1])
    assert h[1] > 3.0 * found.turning_hysteresis
    assert not np.isfinite(h[2])


@pytest.mark.parametrize(("beta", "gamma"), [(0.02, 0.01), (0.01, 0.02), (0.02, 0.02)])
def test_a_model_that_never_turns_has_no_limit(beta: float, gamma: float) -> None:
    v = values(beta, gamma)
    assert behaviour(v).safe_span == math.inf
    assert backward_motion(v, 2000.0) == 0.0


@settings(max_examples=60, deadline=None)
@given(
    beta=st.floats(0.001, 0.05),
    gamma=st.floats(-0.05, 0.05),
    n=st.sampled_from([1.0, 1.5, 2.0]),
    seed=st.integers(0, 1000),
)
def test_h_stays_below_h0_in_the_bounded_classes(
    beta: float, gamma: float, n: float, seed: int
) -> None:
    v = values(beta, gamma, n)
    found = behaviour(v)
    voltage = np.cumsum(np.random.default_rng(seed).normal(0.0, 100.0, 300))
    if found.kind.bounded:
        assert np.abs(follow(v, voltage)).max() <= found.growing_below * (1.0 + 1e-6)


def test_h_outgrows_any_bound_where_not_bounded() -> None:
    rising = np.linspace(0.0, 5000.0, 100)
    h = follow(TABLE_1, rising)
    assert h[-1] > 1e9 * h[10]
    ratchet = values(-0.01, 0.02)
    assert classify(ratchet) is BehaviourClass.RATCHETING
    assert behaviour(ratchet).safe_span == 0.0
    shaken = follow(ratchet, np.tile([0.0, 10.0], 400), h=1e-7)
    assert abs(shaken[-2]) > 10.0 * abs(shaken[0])


@pytest.mark.parametrize(
    ("v", "kind"),
    [
        (values(0.02, 0.01), BehaviourClass.ONE),
        (values(0.01, 0.02), BehaviourClass.TWO),
        (values(0.02, 0.01, alpha=0.0), BehaviourClass.FIVE),
        (values(0.01, -0.01), BehaviourClass.GROWING),
        (values(-0.01, 0.0), BehaviourClass.RATCHETING),
    ],
)
def test_the_classes(v: dict[str, float], kind: BehaviourClass) -> None:
    assert classify(v) is kind


def test_h_grows_between_minus_h1_and_h0() -> None:
    v = values(0.01, 0.02)
    found = behaviour(v)
    assert found.growing_below == pytest.approx(ALPHA * D / 0.03)
    assert found.growing_above == pytest.approx(-ALPHA * D / 0.01)
    for h, grows in (
        (0.99 * found.growing_below, True),
        (1.01 * found.growing_below, False),
        (0.99 * found.growing_above, True),
        (1.01 * found.growing_above, False),
    ):
        assert (advance(h, 0.01, ALPHA * D, v["beta"], v["gamma"], 1.0) > h) is grows
