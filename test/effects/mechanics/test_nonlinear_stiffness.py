"""The nonlinear stiffness against static roots and an integrator."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq

from microgripper_control.core.signals import Array
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Initial, simulate

LINK = "nonlinear_stiffness"
QUADRATIC, CUBIC = 1e3, 5e7  # of k, 1/m and 1/m^2: 2 % each of the force at 20 um


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_at_rest_it_stands_at_the_root(paper: Model, sign: float) -> None:
    s = paper.values("second_order")
    quadratic, cubic = sign * QUADRATIC * s["k"], sign * CUBIC * s["k"]
    model = paper.with_link(LINK, quadratic=quadratic, cubic=cubic)
    absent = paper.with_values({("bouc_wen", "alpha"): 0.0})
    model = model.with_values({("bouc_wen", "alpha"): 0.0})
    for voltage in (20.0, 90.0, 160.0):
        u = np.full(10, voltage)
        x = simulate(model, u, 1e-3, initial=Initial.FIRST_SAMPLE)
        w = model.value("bouc_wen", "d") * voltage
        roots = np.roots([cubic, quadratic, s["k"] + s["k_s"], -s["k"] * w])
        linear = simulate(absent, u, 1e-3, initial=Initial.FIRST_SAMPLE)[0]
        root = roots[np.argmin(np.abs(roots - linear))].real
        np.testing.assert_allclose(x, root, rtol=1e-12)
        assert sign * (linear - root) > 0.0


@pytest.mark.parametrize(("levelling", "far"), [(4e9, 2.6), (-1e9, 1.4)])
def test_the_cubic_term_levels_off_or_steepens(paper: Model, levelling: float, far: float) -> None:
    """Against the root of the balance at rest; `far` is 1 + |levelling| x^2 at 20 um."""
    assert 1.0 + abs(levelling) * 2e-5**2 == pytest.approx(far)
    s = paper.values("second_order")
    model = paper.with_link(LINK, quadratic=0.0, cubic=10.0 * CUBIC * s["k"], levelling=levelling)
    model = model.with_values({("bouc_wen", "alpha"): 0.0})

    def balance(x: float, push: float) -> float:
        changed = 1.0 + abs(levelling) * x * x
        cubic = 10.0 * CUBIC * s["k"] * x**3
        pulled = cubic / changed if levelling > 0.0 else cubic * changed
        return float((s["k"] + s["k_s"]) * x + pulled - push)

    for voltage in (60.0, 160.0):
        push = s["k"] * model.value("bouc_wen", "d") * voltage
        x = simulate(model, np.full(10, voltage), 1e-3, initial=Initial.FIRST_SAMPLE)
        np.testing.assert_allclose(x, brentq(balance, 0.0, 1e-4, (push,), xtol=1e-16), rtol=1e-9)


@pytest.mark.parametrize(("rig", "tolerance"), [("paper", 4e-3), ("slow", 4e-4)])
def test_it_meets_an_integrator(
    rig: str,
    tolerance: float,
    agreement: Callable[..., list[float]],
    request: pytest.FixtureRequest,
) -> None:
    model: Model = request.getfixturevalue(rig)
    k = model.value("second_order", "k")
    values = {"quadratic": QUADRATIC * k, "cubic": CUBIC * k}

    def force(x: float, v: float, own: Array) -> tuple[float, list[float]]:
        return -values["quadratic"] * x * x - values["cubic"] * x * x * x, []

    assert max(agreement(model, LINK, values, force, 0)) < tolerance


def test_planted_values_are_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    truth = np.array([-3e10, 4e15])
    rig = paper.with_link(LINK, quadratic=truth[0], cubic=truth[1])
    found, errors = recover(rig, LINK, {"quadratic": 1e10, "cubic": 1e15}, lively, 1e-3)
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert np.all(errors < 0.2 * np.abs(truth))
