"""The chain: which links run, on which grid, and how a period closes."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.signals import POSITION, ROWS, VOLTAGE
from microgripper_control.plant.chain import MOST_PERIODS, Chain
from microgripper_control.plant.model import Model, nominal_model

PERIOD = 1e-3


@pytest.fixture
def paper() -> Model:
    return nominal_model()


def test_the_nominal_chain_needs_no_division(paper: Model) -> None:
    assert Chain(paper, PERIOD, np.zeros(ROWS)).timing.steps == (PERIOD,)


def test_divisions_change_nothing_under_a_held_voltage(paper: Model) -> None:
    voltage = np.random.default_rng(0).uniform(0.0, 160.0, 50)
    positions = []
    for divisions in (1, 7):
        chain = Chain(paper, PERIOD, np.zeros(ROWS), divisions=divisions)
        assert chain.steps == divisions
        bus = np.zeros((ROWS, 50 * divisions))
        bus[VOLTAGE] = np.repeat(voltage, divisions)
        chain.advance(bus)
        positions.append(bus[POSITION, divisions - 1 :: divisions])
    np.testing.assert_allclose(*positions, rtol=0.0, atol=1e-18)


def test_a_fraction_of_a_delay_puts_a_boundary_there(paper: Model) -> None:
    chain = Chain(paper.with_link("transport_delay", delay=2.25e-3), PERIOD, np.zeros(ROWS))
    np.testing.assert_allclose(chain.timing.steps, [0.25e-3, 0.75e-3])
    assert not chain.timing.quiet - {0}, "there the voltage jumps"


def test_the_voltage_is_quiet_where_only_a_follower_looks(paper: Model) -> None:
    chain = Chain(paper.with_link("backlash", play=1e-7), PERIOD, np.zeros(ROWS))
    assert chain.steps > 2
    assert chain.timing.quiet == frozenset(range(1, chain.steps))


def test_random_links_run_only_when_asked_for(paper: Model) -> None:
    noisy = paper.with_link("sensor_noise", std=1e-6)
    zeros = np.zeros(100)
    assert not np.any(Chain(noisy, PERIOD, np.zeros(ROWS)).sense(zeros))
    assert np.std(Chain(noisy, PERIOD, np.zeros(ROWS), random=True).sense(zeros)) > 5e-7


def test_the_levels_given_are_left_alone(paper: Model) -> None:
    levels = np.array([100.0, 2e-7, 0.0, 0.0])
    chain = Chain(paper.with_link("creep"), PERIOD, levels)
    np.testing.assert_array_equal(levels, [100.0, 2e-7, 0.0, 0.0])
    assert chain.rest_position > 0.0


def test_a_period_is_repeated_until_it_closes(paper: Model) -> None:
    """Small loops would take about 60 periods, slow creep thousands."""
    voltage = 80.0 + 4.0 * np.sin(2.0 * np.pi * np.arange(200) / 200.0)
    chain = Chain(paper.with_link("creep"), PERIOD, np.array([80.0, 0.0, 0.0, 0.0]))
    runs = 0

    def counted(bus: np.ndarray) -> None:
        nonlocal runs
        runs += 1
        Chain.advance(chain, bus)

    chain.advance = counted  # type: ignore[method-assign]
    bus = np.zeros((ROWS, 200))
    bus[VOLTAGE] = voltage
    chain.settle(bus)
    assert runs < MOST_PERIODS / 3
    closed = bus[POSITION].copy()
    for _ in range(200):
        bus[VOLTAGE] = voltage
        Chain.advance(chain, bus)
    np.testing.assert_allclose(bus[POSITION], closed, rtol=0.0, atol=1e-7 * np.ptp(closed))


def test_what_never_closes_ends(paper: Model) -> None:
    """Growth without bound, period by period."""
    ratchet = paper.with_values({("bouc_wen", "beta"): -0.05})
    chain = Chain(ratchet, PERIOD, np.array([0.0, 1e-7, 0.0, 0.0]))
    bus = np.zeros((ROWS, 100))
    bus[VOLTAGE] = 100.0 * np.sin(np.arange(100) / 50.0 * np.pi)
    with np.errstate(over="ignore", invalid="ignore"):
        chain.settle(bus)
    assert not np.max(np.abs(bus[POSITION])) < 1.0
