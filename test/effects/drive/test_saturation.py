"""The output range, hard and soft."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Scales
from microgripper_control.effects.drive.saturation import LINK, limited
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Initial, simulate

Alone = Callable[..., Array]
COMMANDS = np.linspace(-100.0, 250.0, 701)


def curve(alone: Alone, low: float, high: float, softness: float) -> Array:
    values = {"low": low, "high": high, "low_softness": softness, "high_softness": softness}
    return alone("saturation", values, COMMANDS, (1e-3,))


def test_hard_it_clips(alone: Alone) -> None:
    np.testing.assert_array_equal(curve(alone, -20.0, 150.0, 0.0), np.clip(COMMANDS, -20.0, 150.0))


@pytest.mark.parametrize("softness", [1e-6, 0.1, 3.0, 30.0])
def test_soft_it_stays_inside_and_bends_once(alone: Alone, softness: float) -> None:
    out = curve(alone, -20.0, 150.0, softness)
    assert np.min(out) > -20.0 - 1e-9
    assert np.max(out) < 150.0 + 1e-9
    gain = np.diff(out) / np.diff(COMMANDS)
    assert np.all((gain >= -1e-12) & (gain <= 1.0 + 1e-12))


@pytest.mark.parametrize("softness", [1e-6, 0.1, 3.0])
def test_softness_takes_ln_2_of_itself_at_the_level(alone: Alone, softness: float) -> None:
    off = np.clip(COMMANDS, -20.0, 150.0) - curve(alone, -20.0, 150.0, softness)
    assert np.max(off) == pytest.approx(softness * np.log(2.0), rel=1e-6)
    assert np.min(off) == pytest.approx(-softness * np.log(2.0), rel=1e-6)


def test_with_the_levels_close_together_it_is_a_hyperbolic_tangent(alone: Alone) -> None:
    """The textbook's soft limiter, up to a gain that d makes up for."""
    values = {"low": -6.0, "high": 6.0, "low_softness": 30.0, "high_softness": 30.0}
    out = alone("saturation", values, COMMANDS, (1e-3,))
    np.testing.assert_allclose(out / 6.0, np.tanh(COMMANDS / 60.0), atol=0.01)


def test_levels_out_of_reach_change_no_bit(paper: Model, lively: Array) -> None:
    model = paper.with_link(
        "saturation", low=-900.0, high=1500.0, low_softness=10.0, high_softness=10.0
    )
    np.testing.assert_array_equal(simulate(model, lively, 1e-3), simulate(paper, lively, 1e-3))


def test_it_is_a_change_of_the_command(paper: Model, lively: Array) -> None:
    model = paper.with_link("saturation", low=0.0, high=120.0, low_softness=0.0, high_softness=0.0)
    np.testing.assert_array_equal(
        simulate(model, lively - 30.0, 1e-3),
        simulate(paper, np.clip(lively - 30.0, 0.0, 120.0), 1e-3),
    )


def test_it_starts_settled_at_what_gets_through(paper: Model) -> None:
    model = paper.with_link("saturation", low=0.0, high=100.0, low_softness=0.0, high_softness=0.0)
    x = simulate(model, np.full(50, 140.0), 1e-3, initial=Initial.FIRST_SAMPLE)
    expected = simulate(paper, np.full(50, 100.0), 1e-3, initial=Initial.FIRST_SAMPLE)
    np.testing.assert_array_equal(x, expected)


def test_planted_levels_are_found(
    paper: Model, lively: Array, recover: Callable[..., tuple[Array, Array]]
) -> None:
    for truth in ([8.0, 133.0, 0.5, 0.5], [5.0, 140.0, 3.0, 6.0]):
        names = ("low", "high", "low_softness", "high_softness")
        rig = paper.with_link("saturation", **dict(zip(names, truth, strict=True)))
        start = {"low": 4.0, "high": 145.0, "low_softness": 2.0, "high_softness": 2.0}
        found, errors = recover(rig, "saturation", start, lively, 1e-3)
        assert np.all(np.abs(found - truth) < 4.0 * errors)
        assert np.all(errors < 0.15)


def test_from_every_start_both_ends_are_felt() -> None:
    """An end out of reach has no slope: a fit would leave it there."""
    scales = Scales(1e-3, 10.0, (-20.0, 150.0), 1e4, (0.0, 1e-4), 5e7, 0.0038)
    for values in LINK.starts(scales):
        lowest = limited(-20.0, **values) + 20.0
        highest = limited(150.0, **values) - 150.0
        assert lowest > 0.01 * values["low_softness"]
        assert highest < -0.01 * values["high_softness"]
