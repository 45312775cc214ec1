"""What every link owes, whoever writes it: this file finds it by the registry."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Link, Scales
from microgripper_control.effects.registry import registry
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Initial, simulate

PERIOD = 1e-3
STROKE = 20e-6  # m
ADDED = [link for link in registry().values() if not link.nominal]
every_link = pytest.mark.parametrize("link", ADDED, ids=lambda link: link.name)
# Where a parameter matters only if another one, nominally zero, is not.
SHOWING = {
    "amplifier_lag": {"third": 0.3},
    "contact": {"relaxing": 0.5, "adhesion": 0.5},
    "friction": {"distributed": 0.3},
    "restoring_force_hysteresis": {"distributed": 0.5},
    "rate_dependent_hysteresis": {"slope": 3e-8},
    "asymmetric_hysteresis": {"plays": 3e-8},
    "extra_resonance": {"second": 0.1},
}
Streamed = Callable[[Model, Array, float], Array]


def towards_nothing(link: Link, share: float) -> dict[str, float]:
    """Nominal values, but those that make the effect vanish only this share away from there."""
    return {
        p.name: p.vanishing + share * (p.nominal - p.vanishing)
        for p in link.parameters
        if p.vanishing is not None
    }


@every_link
def test_off_is_absent(link: Link, paper: Model, lively: Array) -> None:
    model = paper.with_link(link.name, **towards_nothing(link, 0.0))
    for hold in Hold:
        expected = simulate(paper, lively, PERIOD, hold=hold, random=True)
        np.testing.assert_array_equal(
            simulate(model, lively, PERIOD, hold=hold, random=True), expected
        )


@every_link
def test_nearly_off_is_nearly_absent(link: Link, slow: Model, lively: Array) -> None:
    absent = simulate(slow, lively, PERIOD)
    errors = []
    for share in (1e-3, 1e-6):
        model = slow.with_link(link.name, **towards_nothing(link, share))
        errors.append(np.max(np.abs(simulate(model, lively, PERIOD, random=True) - absent)))
    assert errors[1] <= max(0.1 * errors[0], 1e-9 * STROKE)
    assert errors[1] < 1e-4 * STROKE


@every_link
def test_an_idle_parameter_changes_nothing(link: Link, paper: Model, lively: Array) -> None:
    scales = Scales(PERIOD, 10.0, (0.0, 150.0), 1e4, (0.0, STROKE), 5e7, 0.0038)
    for values in link.starts(scales):
        model = paper.with_link(link.name, **values)
        expected = simulate(model, lively, PERIOD)
        for name in link.idle(model.values(link.name)):
            half = {(link.name, name): 0.5 * model.value(link.name, name)}
            np.testing.assert_array_equal(
                simulate(model.with_values(half), lively, PERIOD), expected
            )


@every_link
def test_streaming_is_batch(link: Link, paper: Model, lively: Array, streamed: Streamed) -> None:
    model = paper.with_link(link.name)
    batch = simulate(model, lively, PERIOD, random=True)
    np.testing.assert_array_equal(streamed(model, lively, PERIOD), batch)


@every_link
def test_streaming_is_batch_on_a_divided_period(
    link: Link, slow: Model, lively: Array, streamed: Streamed
) -> None:
    model = slow.with_link("sensor_lag").with_link("transport_delay", delay=2.3e-3)
    model = model.with_link(link.name)
    batch = simulate(model, lively, PERIOD, random=True)
    np.testing.assert_array_equal(streamed(model, lively, PERIOD), batch)


def test_streaming_is_batch_with_all_links_at_once(
    slow: Model, lively: Array, streamed: Streamed
) -> None:
    model = slow
    for link in ADDED:
        model = model.with_link(link.name)
    batch = simulate(model, lively, PERIOD, random=True)
    assert np.all(np.isfinite(batch))
    np.testing.assert_array_equal(streamed(model, lively, PERIOD), batch)


@every_link
def test_a_rig_at_rest_stays_at_rest(link: Link, paper: Model) -> None:
    """In equilibrium from the first sample on, whatever the link has inside."""
    if link.random:
        pytest.skip("moves by itself")
    settled = np.full(300, 70.0)
    model = paper.with_link(link.name)
    moved = simulate(model, settled, PERIOD, initial=Initial.FIRST_SAMPLE)
    assert np.ptp(moved) < 1e-9 * STROKE


@every_link
def test_it_depends_smoothly_on_what_is_fitted(
    link: Link, paper: Model, slow: Model, lively: Array
) -> None:
    """Identification takes forward differences with steps of 1e-5.

    A hardly damped mass that bounces under a force is no smooth matter; the others see more of it.
    """
    base = paper if link.force else slow
    base = base.with_link(link.name, **SHOWING.get(link.name, {}))
    both_ways = 1.2 * lively - 30.0
    for parameter in link.parameters:
        if not parameter.fitted or link.random:
            continue
        value = parameter.nominal or parameter.high * 1e-4

        def moved(share: float, name: str = parameter.name, value: float = value) -> Array:
            changed = base.with_values({(link.name, name): value * (1.0 + share)})
            return simulate(changed, both_ways, PERIOD)

        fine = (moved(1e-5) - moved(0.0)) / 1e-5
        coarse = (moved(1e-3) - moved(-1e-3)) / 2e-3
        assert np.linalg.norm(coarse) > 0.0, parameter.name
        assert np.linalg.norm(fine - coarse) < 0.1 * np.linalg.norm(coarse), parameter.name
