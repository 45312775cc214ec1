"""Contact against static solutions, a rigid stop and an integrator."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq

from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Scales
from microgripper_control.effects.registry import link_named
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


@pytest.mark.parametrize("relaxation", [0.02, 0.2])
@pytest.mark.parametrize(("rig", "tolerance"), [("paper", 2e-2), ("slow", 2e-3)])
def test_a_soft_object_meets_an_integrator(
    rig: str,
    tolerance: float,
    relaxation: float,
    agreement: Callable[..., list[float]],
    request: pytest.FixtureRequest,
) -> None:
    model: Model = request.getfixturevalue(rig)
    values = {"position": POSITION, "stiffness": 0.05 * model.value("second_order", "k")}
    values |= {"relaxing": 1.0, "stiffening": 1.5}
    values |= {"slowest": relaxation, "decades": np.log10(2.0)}

    def force(x: float, v: float, own: Array) -> tuple[float, list[float]]:
        push = values["stiffness"] * max(0.0, x - POSITION)
        slow = 0.5 * (own[0] + own[1])
        rates = [(push - own[0]) / (0.5 * relaxation), (push - own[1]) / relaxation]
        return -max(0.0, push + values["stiffening"] * (push - slow)), rates

    assert max(agreement(model, LINK, values, force, 2)) < tolerance


def test_a_soft_object_gives_way_as_a_standard_linear_solid(paper: Model) -> None:
    """Under a force that stays it creeps, slower than it relaxes in a place that stays."""
    k, d = paper.value("second_order", "k"), paper.value("bouc_wen", "d")
    stiff, soft, stiffening, relaxation = k + paper.value("second_order", "k_s"), 0.1 * k, 3.0, 0.05
    model = linear_rig(paper).with_link(
        LINK,
        position=0.0,
        stiffness=soft,
        relaxing=1.0,
        stiffening=stiffening,
        slowest=relaxation,
        decades=0.0,
    )
    x = simulate(model, np.full(600, 100.0), 1e-3)
    fast = stiff + soft * (1.0 + stiffening)
    slow = stiff + soft
    time = 1e-3 * np.arange(600)
    creeping = 1.0 / slow + (1.0 / fast - 1.0 / slow) * np.exp(-time / relaxation * slow / fast)
    settled = time > 0.02
    np.testing.assert_allclose(x[settled], (k * d * 100.0 * creeping)[settled], rtol=1e-3)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_planted_values_are_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]], exponent: float
) -> None:
    truth = np.array([1.12e-5, 2.7e6])
    rig = paper.with_link(LINK, position=truth[0], stiffness=truth[1], exponent=exponent)
    found, errors = recover(rig, LINK, {"position": 1.3e-5, "stiffness": 1e6}, lively, 1e-3)
    assert np.all(np.abs(found - truth) < 4.0 * errors)
    assert np.all(errors < 0.03 * truth)


def test_planted_values_of_a_soft_object_are_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    truth = {"position": 1.12e-5, "stiffness": 2.7e6, "stiffening": 0.8}
    truth |= {"slowest": 0.05, "decades": 0.8}
    rig = paper.with_link(LINK, **truth, relaxing=1.0)
    start = {"position": 1.3e-5, "stiffness": 1e6, "stiffening": 0.3}
    start |= {"slowest": 0.03, "decades": 0.5}
    found, errors = recover(rig, LINK, start, lively, 1e-3)
    assert np.all(np.abs(found - list(truth.values())) < 4.0 * errors)
    assert np.all(errors < 0.1 * np.array(list(truth.values())))


def test_what_sticks_snaps_in_and_lets_go_later(paper: Model) -> None:
    """Slowly up and down: it pulls from the touch on, on the way back beyond it, and no further."""
    s, d = paper.values("second_order"), paper.value("bouc_wen", "d")
    stiff, stiffness, adhesion, reach = s["k"] + s["k_s"], 2e6, 8.0, 4e-7
    model = linear_rig(paper).with_link(
        LINK, position=POSITION, stiffness=stiffness, adhesion=adhesion, reach=reach
    )
    voltage = 160.0 * np.concatenate([np.linspace(0.0, 1.0, 20_000), np.linspace(1.0, 0.0, 20_000)])
    x = simulate(model, voltage, 1e-3)
    push = s["k"] * d * np.append(0.0, voltage[:-1])
    free, stuck = push / stiff, (push + adhesion + stiffness * POSITION) / (stiff + stiffness)
    hanging = (push + adhesion) / stiff  # a neck that is whole
    up, beside, jump = np.arange(len(x)) < 20_000, 2e-8, adhesion / stiff
    assert np.ptp(x[up & (np.abs(free - POSITION) < beside)]) > jump
    for part, expected in (
        (up & (free < POSITION - beside), free),
        (up & (free > POSITION + beside), stuck),
        (~up & (stuck > POSITION + beside), stuck),
        (~up & (hanging < POSITION - beside) & (hanging > POSITION - 0.4 * reach), hanging),
        (~up & (hanging < POSITION - 1.1 * reach), free),
    ):
        assert np.count_nonzero(part) > 50
        np.testing.assert_allclose(x[part], expected[part], rtol=0.0, atol=0.04 * jump)


def test_planted_adhesion_is_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    truth = {"position": 1.12e-5, "stiffness": 2.7e6, "adhesion": 5.0, "reach": 3e-7}
    start = {"position": 1.2e-5, "stiffness": 1.5e6, "adhesion": 2.0, "reach": 5e-7}
    rig = paper.with_link(LINK, **truth, exponent=1.5)
    found, errors = recover(rig, LINK, start, lively, 1e-3)
    assert np.all(np.abs(found - list(truth.values())) < 4.0 * errors)
    assert np.all(errors < 0.1 * np.array(list(truth.values())))


def test_what_sticks_already_is_not_guessed_to_stick() -> None:
    scales = Scales(1e-3, 10.0, (0.0, 160.0), 1e3, (0.0, 2e-5), 1e7, 0.0038)
    link = link_named("contact")
    nominal = {p.name: p.nominal for p in link.parameters}
    guesses = link.more(nominal, scales)
    assert all(guess["adhesion"] > 0.0 for guess in guesses)
    assert {guess["exponent"] for guess in guesses} == {1.0, 1.5}
    assert not link.more({**nominal, "adhesion": 1.0}, scales)
    assert link.says is not None
    assert "sticks with 8.0 N until 400 nm before" in link.says(
        {**nominal, "adhesion": 8.0, "reach": 4e-7}, scales
    )


def test_an_object_that_hardly_relaxes_is_not_said_to() -> None:
    scales = Scales(1e-3, 10.0, (0.0, 160.0), 1e3, (0.0, 2e-5), 1e7, 0.0038)
    link = link_named("contact")
    soft = {p.name: p.nominal for p in link.parameters} | {"relaxing": 1.0, "stiffening": 0.4}
    assert link.says is not None
    assert "40 % more if pressed faster" in link.says(soft, scales)
    assert "faster" not in link.says(soft | {"stiffening": 0.01}, scales)


@pytest.mark.parametrize(
    ("position", "side", "unusual"),
    [
        (1e-5, 1.0, 0.0),
        (6.5e-6, 1.0, 0.5),
        (3e-6, 1.0, 1.0),
        (3e-6, -1.0, 0.0),
        (1.9e-5, -1.0, 1.0),
    ],
)
def test_what_is_touched_over_most_of_the_stroke_goes_by_another_name(
    position: float, side: float, unusual: float
) -> None:
    scales = Scales(1e-3, 10.0, (0.0, 160.0), 1e3, (0.0, 2e-5), 1e7, 0.0038)
    values = {"position": position, "side": side}
    assert link_named("contact").unusual(values, scales) == pytest.approx(unusual)
