"""The solve under forces, with laws whose answer is known: springs and dampers of its own kind."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from microgripper_control.core.signals import FREE, LEVELS, POSITION, ROWS, Array, Timing
from microgripper_control.effects import force_balance, mass_under_forces
from microgripper_control.effects.base import Force, Link, Load, Stage, Values
from microgripper_control.effects.mechanics import second_order
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Model, nominal_model

Run = Callable[..., Array]


def spring(
    c: Array, before: Array, after: Array, x0: float, x1: float, v: float, step: float
) -> float:
    return float(-c[0] * x1)


def spring_by_path(
    c: Array, before: Array, after: Array, x0: float, x1: float, v: float, step: float
) -> float:
    after[0] = before[0] - c[0] * (x1 - x0)
    return float(after[0])


def damper(
    c: Array, before: Array, after: Array, x0: float, x1: float, v: float, step: float
) -> float:
    return float(-c[0] * v)


def load(law: Callable[..., float], size: float, states: int = 0, brakes: bool = False) -> Load:
    stiffness = 0.0 if law is damper else size
    return Force(law, lambda values: [size], lambda values: stiffness, states, brakes=brakes), {}


def grid(steps: tuple[float, ...], ramped: bool) -> Timing:
    return Timing(sum(steps), steps, ramped)


def under(values: Values, loads: list[Load], w: Array, timing: Timing) -> Array:
    prepared = mass_under_forces.prepare(values, timing, np.zeros(LEVELS), loads)
    bus = np.zeros((ROWS, len(w)))
    bus[FREE] = w
    force_balance.kernel(prepared.coefficients, prepared.state, bus)
    return bus[POSITION]


def alone(values: Values, w: Array, timing: Timing) -> Array:
    prepared = second_order.prepare(values, timing, np.zeros(LEVELS))
    bus = np.zeros((ROWS, len(w)))
    bus[FREE] = w
    second_order.kernel(prepared.coefficients, prepared.state, bus)
    return bus[POSITION]


@pytest.fixture
def wandering() -> Array:
    return np.append(0.0, np.random.default_rng(1).normal(size=300).cumsum())


@pytest.mark.parametrize("ramped", [False, True])
@pytest.mark.parametrize("law", [spring, spring_by_path])
@pytest.mark.parametrize("share", [1e-3, 0.1, 2.0])
def test_a_spring_is_more_stiffness(
    slow: Model, wandering: Array, share: float, law: Callable[..., float], ramped: bool
) -> None:
    values = slow.values("second_order")
    size = share * values["k"]
    stiffer = {**values, "k_s": values["k_s"] + size}
    states = 1 if law is spring_by_path else 0
    for steps in ((1e-3,), (0.3e-3, 0.7e-3), (2e-5,)):
        expected = alone(stiffer, wandering, grid(steps, ramped))
        found = under(values, [load(law, size, states)], wandering, grid(steps, ramped))
        effect = np.max(np.abs(expected - alone(values, wandering, grid(steps, ramped))))
        assert np.max(np.abs(found - expected)) < 5e-3 * effect


@pytest.mark.parametrize("period", [1e-3, 0.5])
@pytest.mark.parametrize("share", [0.1, 1.0])
def test_for_a_link_behind_the_ringing_is_drawn_with_few_substeps(
    wandering: Array, share: float, period: float
) -> None:
    """What has died away by the next jump is not followed as if it went on."""
    values = nominal_model().values("second_order")
    size = share * values["k"]
    timing = Timing.divide(period, {0.0}, second_order.settling(values, period), ramped=False)
    assert len(timing.quiet) > 10
    w = np.repeat(wandering, len(timing.steps))
    expected = alone({**values, "k_s": values["k_s"] + size}, w, timing)
    found = under(values, [load(spring, size)], w, timing)
    effect = np.max(np.abs(expected - alone(values, w, timing)))
    assert np.max(np.abs(found - expected)) < 1e-2 * effect
    loads = [load(spring, size)]
    prepared = mass_under_forces.prepare(values, timing, np.zeros(LEVELS), loads)
    assert len(prepared.coefficients) < 4 * len(timing.steps)


@pytest.mark.parametrize("ramped", [False, True])
def test_a_damper_is_more_damping(slow: Model, wandering: Array, ramped: bool) -> None:
    values = slow.values("second_order")
    damped = {**values, "b": 4.0 * values["b"]}
    expected = alone(damped, wandering, grid((1e-3,), ramped))
    found = under(values, [load(damper, 3.0 * values["b"])], wandering, grid((1e-3,), ramped))
    effect = np.max(np.abs(expected - alone(values, wandering, grid((1e-3,), ramped))))
    assert np.max(np.abs(found - expected)) < 5e-3 * effect


@pytest.mark.parametrize("ramped", [False, True])
@pytest.mark.parametrize("times", [0.3, 3.0, 30.0])
@pytest.mark.parametrize("brakes_first", [False, True])
def test_a_spring_beside_what_brakes_is_both(
    slow: Model, wandering: Array, brakes_first: bool, times: float, ramped: bool
) -> None:
    values = slow.values("second_order")
    size, brake = 0.5 * values["k"], times * values["b"]
    both = {**values, "k_s": values["k_s"] + size, "b": values["b"] + brake}
    loads = [load(spring_by_path, size, 1), load(damper, brake, brakes=True)]
    loads = loads[::-1] if brakes_first else loads
    for steps in ((1e-3,), (0.3e-3, 0.7e-3), (2e-5,)):
        expected = alone(both, wandering, grid(steps, ramped))
        found = under(values, loads, wandering, grid(steps, ramped))
        effect = np.max(np.abs(expected - alone(values, wandering, grid(steps, ramped))))
        assert np.max(np.abs(found - expected)) < 5e-3 * effect


def test_forces_add_up_each_with_its_own_state(slow: Model, wandering: Array) -> None:
    values = slow.values("second_order")
    part = 0.1 * values["k"]
    loads = [load(spring_by_path, part, 1), load(spring, part), load(spring_by_path, 2.0 * part, 1)]
    stiffer = {**values, "k_s": values["k_s"] + 4.0 * part}
    expected = alone(stiffer, wandering, grid((2e-5,), True))
    found = under(values, loads, wandering, grid((2e-5,), True))
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.ptp(expected))


def test_the_error_falls_with_the_fourth_power_of_the_step(slow: Model) -> None:
    values = slow.values("second_order")
    size, period, coarse = 0.5 * values["k"], 1e-4, 40
    stiffer = {**values, "k_s": values["k_s"] + size}
    w = np.sin(np.arange(1, coarse + 1) / 7.0)
    expected = alone(stiffer, w, grid((period,), True))
    errors = []
    for parts in (8, 16, 32):
        fine = np.interp(np.arange(1, coarse * parts + 1) / parts, np.arange(coarse + 1), [0.0, *w])
        found = under(values, [load(spring, size)], fine, grid((period / parts,), True))
        errors.append(np.max(np.abs(found[parts - 1 :: parts] - expected)))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.7), orders


def test_a_law_that_gives_nonsense_ends_in_nonsense_not_in_a_hang(slow: Model) -> None:
    values = slow.values("second_order")
    runaway = Force(spring, lambda _: [-1e9 * values["k"]], lambda _: 0.0)
    found = under(values, [(runaway, {})], np.ones(2000), grid((1e-3,), False))
    assert not np.all(np.isfinite(found)) or np.max(np.abs(found)) > 1e3


def test_the_ringing_is_divided_from_jump_to_jump_not_from_step_to_step(paper: Model) -> None:
    """Twelve steps cost a cut each, and the mass goes where a stiffer one goes in one step."""
    values, period, parts = paper.values("second_order"), 1e-3, 12
    size = 0.5 * values["k"]
    steps = (0.01 * period,) * (parts - 1) + (period * (1.0 - 0.01 * (parts - 1)),)
    cut = Timing(period, steps, False, quiet=frozenset(range(1, parts)))
    rows = [
        len(
            mass_under_forces.prepare(
                values, timing, np.zeros(LEVELS), [load(spring_by_path, size, 1)]
            ).coefficients
        )
        for timing in (grid((period,), False), cut)
    ]
    assert rows[0] < rows[1] < rows[0] + parts
    w = np.repeat(np.random.default_rng(3).uniform(0.0, 1.0, 200), parts)
    stiffer = {**values, "k_s": values["k_s"] + size}
    expected = alone(stiffer, w, cut)
    found = under(values, [load(spring_by_path, size, 1)], w, cut)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=2e-3 * np.ptp(expected))


def test_a_mass_that_never_rests_is_divided_only_so_far(slow: Model) -> None:
    values = {**slow.values("second_order"), "b": 0.0, "m": 1e-9}
    prepared = mass_under_forces.prepare(
        values, grid((1.0,), False), np.zeros(LEVELS), [load(spring_by_path, 1e3, 1)]
    )
    assert len(prepared.coefficients) == 2 + mass_under_forces.MOST_SUBSTEPS


def test_every_force_has_its_own_place_among_the_links() -> None:
    forces = [link for link in registry().values() if link.force]
    assert {link.stage for link in forces} == {Stage.MECHANICS}
    assert [link.name for link in registry().values() if link.solver] == ["second_order"]


def test_a_link_is_a_kernel_or_a_force() -> None:
    link = registry()["contact"]
    with pytest.raises(ValueError, match="either a kernel or a force"):
        Link("x", link.stage, 0, "x", "x", link.parameters)
