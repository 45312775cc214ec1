"""A delay shifts, by whole samples and by parts of one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

PERIOD = 1e-3
Alone = Callable[..., Array]


@pytest.mark.parametrize("samples", [1, 3, 250])
@pytest.mark.parametrize("hold", [Hold.ZERO, Hold.FIRST])
def test_whole_samples_shift_the_numbers(
    paper: Model, lively: Array, samples: int, hold: Hold
) -> None:
    u = lively - lively[0]  # at rest before the run, also where the voltage has no jumps
    model = paper.with_link("transport_delay", delay=samples * PERIOD)
    delayed, prompt = (simulate(m, u, PERIOD, hold=hold) for m in (model, paper))
    np.testing.assert_allclose(delayed[samples:], prompt[:-samples], rtol=1e-12, atol=1e-20)
    np.testing.assert_array_equal(delayed[:samples], 0.0)


@pytest.mark.parametrize("tenths", [3, 9, 14])
def test_parts_of_a_sample_are_exact(slow: Model, lively: Array, tenths: int) -> None:
    """As the same voltage would give, sampled ten times as fast and shifted there."""
    fine = np.repeat(lively, 10)
    shifted = np.concatenate([np.zeros(tenths), fine])[: len(fine)]
    expected = simulate(slow, shifted, PERIOD / 10)[::10]
    found = simulate(slow.with_link("transport_delay", delay=tenths * PERIOD / 10), lively, PERIOD)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-16)


def test_a_straight_signal_is_read_off_between_its_corners(alone: Alone) -> None:
    u = np.random.default_rng(3).normal(size=50)
    u[0] = 0.0
    for delay in (0.2e-3, 1.7e-3, 4e-3):
        out = alone("transport_delay", {"delay": delay}, u, (PERIOD,), ramped=True)
        t = PERIOD * np.arange(50)
        np.testing.assert_allclose(out, np.interp(t - delay, t, u), atol=1e-9)


@pytest.mark.parametrize(
    ("link", "values"),
    [("amplifier_lag", {"lag": 3e-5}), ("slew_limit", {"time": 1e-6})],
)
def test_a_jump_late_in_the_sample_meets_later_links_there(
    slow: Model,
    finely: Callable[[Model, Array, float], Array],
    link: str,
    values: dict[str, float],
) -> None:
    """Boundaries that other links count from a jump move with it: else 16 % and 7 % are lost."""
    u = np.random.default_rng(1).uniform(0.0, 160.0, 30)
    model = slow.with_link(link, **values)
    prompt = simulate(model, u, PERIOD)
    model = model.with_link("transport_delay", delay=0.7e-3)
    expected = finely(model, u, PERIOD)
    error = np.linalg.norm(simulate(model, u, PERIOD) - expected)
    assert error < 0.02 * np.linalg.norm(prompt - expected)


def test_a_planted_delay_is_found(
    slow: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    rig = slow.with_link("transport_delay", delay=1.37e-3)
    found, errors = recover(rig, "transport_delay", {"delay": 1.2e-3}, lively, PERIOD)
    assert abs(found[0] - 1.37e-3) < 4.0 * errors[0]
    assert errors[0] < 1e-6
