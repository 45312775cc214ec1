"""Contact against static solutions, a rigid stop and an integrator."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq

from microgripper_control.core.signals import Array
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Initial, simulate

LINK = "contact"
POSITION = 1e-5  # m


def linear_rig(model: Model) -> Model:
    return model.with_values({("bouc_wen", "alpha"): 0.0})


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_at_rest_force_balances_force(paper: Model, exponent: float, side: float) -> None:
    s, d, stiffness = paper.values("second_order"), paper.value("bouc_wen", "d"), 3e6
    values = {"position": side * POSITION, "stiffness": stiffness, "exponent": exponent}
    model = linear_rig(paper).with_link(LINK, **values, side=side)
    for voltage in (40.0, 100.0, 160.0):
        x = simulate(model, np.full(10, side * voltage), 1e-3, initial=Initial.FIRST_SAMPLE)

        def excess(x: float, w: float = d * voltage) -> float:
            depth = max(0.0, x - POSITION)
            push = stiffness * 1e-6 * (depth / 1e-6) ** exponent
            return (s["k"] + s["k_s"]) * x + push - s["k"] * w

        np.testing.assert_allclose(side * x, brentq(excess, 0.0, 1e-4, xtol=1e-20), rtol=1e-11)


def test_short_of_the_object_nothing_changes(paper: Model, lively: Array) -> None:
    model = paper.with_link(LINK, position=1e-3, stiffness=1e8)
    np.testing.assert_allclose(
        simulate(model, lively, 1e-3), simulate(paper, lively, 1e-3), rtol=0.0, atol=1e-18
    )


@pytest.mark.parametrize("stiffness", [1e10, 1e12])
def test_a_rigid_stop_holds_without_chatter(paper: Model, lively: Array, stiffness: float) -> None:
    """Held over a sample, such a force would throw the mass far away."""
    free = simulate(paper, lively, 1e-3)
    found = simulate(paper.with_link(LINK, position=POSITION, stiffness=stiffness), lively, 1e-3)
    largest = paper.value("second_order", "k") / stiffness * np.max(free - POSITION)
    np.testing.assert_allclose(found, np.minimum(free, POSITION), rtol=0.0, atol=1.05 * largest)


def test_a_bouncing_mass_keeps_its_energy_and_loses_it_to_damping(slow: Model) -> None:
    """Over 250 swings between the stack's spring and a curved body."""
    undamped = linear_rig(slow).with_values({("second_order", "b"): 0.0})
    k = slow.value("second_order", "k")
    swings = {}
    for damping in (0.0, 3.0):
        model = undamped.with_link(
            LINK, position=POSITION, stiffness=2.0 * k, exponent=1.5, damping=damping
        )
        x = simulate(model, np.full(20_000, 160.0), 1e-5)
        swings[damping] = (np.std(x[:4000]), np.std(x[-4000:]))
    assert swings[0.0][1] == pytest.approx(swings[0.0][0], rel=2e-3)
    assert swings[3.0][1] < 0.9 * swings[3.0][0]


def test_damping_that_shows_in_slow_motion_bears_a_step_of_the_voltage(paper: Model) -> None:
    values = {"position": 5e-6, "stiffness": 9e5, "exponent": 1.5}
    model = linear_rig(paper).with_link(LINK, **values, damping=75.0)
    x = simulate(model, np.repeat([0.0, 120.0, 0.0, 160.0], 500), 2e-4)
    rest = simulate(linear_rig(paper).with_link(LINK, **values), np.full(10, 160.0), 1e-3)[-1]
    assert np.max(np.abs(x)) < 2.0 * rest
    assert x[-1] == pytest.approx(rest, rel=1e-9)


@pytest.mark.parametrize(
    ("rig", "stiffness", "exponent", "damping", "tolerance"),
    [
        ("paper", 0.04, 1.0, 0.0, 5e-3),
        ("paper", 10.0, 1.0, 0.0, 5e-3),
        ("paper", 0.2, 1.5, 20.0, 3e-2),
        ("slow", 0.04, 1.0, 0.0, 1e-3),
        ("slow", 0.2, 1.5, 20.0, 2e-3),
    ],
)
def test_it_meets_an_integrator(
    rig: str,
    stiffness: float,
    exponent: float,
    damping: float,
    tolerance: float,
    agreement: Callable[..., list[float]],
    request: pytest.FixtureRequest,
) -> None:
    model: Model = request.getfixturevalue(rig)
    values = {"position": POSITION, "stiffness": stiffness * model.value("second_order", "k")}
    values |= {"exponent": exponent, "damping": damping}

    def force(x: float, v: float, own: Array) -> tuple[float, list[float]]:
        depth = max(0.0, x - POSITION)
        grip = min(max(0.0, 1.0 + damping * v), 2.5)
        return -values["stiffness"] * depth * (depth / 1e-6) ** (exponent - 1.0) * grip, []

    assert max(agreement(model, LINK, values, force, 0)) < tolerance


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_planted_values_are_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]], exponent: float
) -> None:
    truth = np.array([1.12e-5, 2.7e6])
    rig = paper.with_link(LINK, position=truth[0], stiffness=truth[1], exponent=exponent)
    found, errors = recover(rig, LINK, {"position": 1.3e-5, "stiffness": 1e6}, lively, 1e-3)
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert np.all(errors < 0.03 * truth)
