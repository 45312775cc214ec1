"""What the tests of forces share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from microgripper_control.core.signals import Array
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

PERIOD = 1e-3

# force(x, v, own states) -> force on the mass, N, and the rates of its own states
OwnForce = Callable[[float, float, Array], tuple[float, Sequence[float]]]
Coupled = Callable[..., Array]


@pytest.fixture
def coupled() -> Coupled:
    """The mass under a force, by a general integrator that shares no code with the plant, m.

    From rest at a voltage that starts at 0 V; equations (1), (2), (4) and the force together.
    """

    def run(
        model: Model, voltage: Array, period: float, force: OwnForce, states: int, hold: Hold
    ) -> Array:
        w, s = model.values("bouc_wen"), model.values("second_order")

        def grow(h: float, rate: float) -> float:
            fading = w["beta"] * abs(rate) * h + w["gamma"] * rate * abs(h)
            return w["alpha"] * w["d"] * rate - fading

        def rates(t: float, y: Array, u: float, rate: float) -> list[float]:
            h, x, v = y[:3]
            push, own = force(x, v, y[3:])
            pull = s["k"] * (w["d"] * (u + rate * t) - h) - (s["k"] + s["k_s"]) * x - s["b"] * v
            return [grow(h, rate), v, (pull + push) / s["m"], *own]

        y, positions, u = np.zeros(3 + states), [0.0], 0.0
        small = [1e-14, 1e-14, 1e-14 * np.sqrt(s["k"] / s["m"]), *[1e-8] * states]
        for old, new in pairwise(voltage):
            if hold is Hold.ZERO and old != u:
                jump = solve_ivp(
                    lambda _, h, change: [grow(h[0], change)],
                    (0.0, 1.0),
                    y[:1],
                    args=(old - u,),
                    rtol=1e-10,
                    atol=1e-16,
                )
                y[0] = jump.y[0, -1]
            rate = (new - old) / period if hold is Hold.FIRST else 0.0
            with np.errstate(over="ignore", invalid="ignore"):  # its first guess of a step
                solved = solve_ivp(
                    rates, (0.0, period), y, "DOP853", args=(old, rate), rtol=1e-8, atol=small
                )
            y, u = solved.y[:, -1], old
            positions.append(y[1])
        return np.array(positions)

    return run


@pytest.fixture
def swept() -> Array:
    """A voltage from 0 V that turns slowly, V, 28 samples."""
    return 80.0 * (1.0 - np.cos(2.0 * np.pi * np.arange(28) / 20.0))


@pytest.fixture
def thrown() -> Array:
    """A voltage from 0 V that goes anywhere from sample to sample, V, 28 samples."""
    turns = np.cumsum(np.random.default_rng(3).uniform(0.1, 1.2, 28))
    return np.append(0.0, 80.0 + 60.0 * np.sin(turns[1:]))


@pytest.fixture
def agreement(
    coupled: Coupled,
    swept: Array,
    thrown: Array,
    without_hysteresis: Callable[[Model], Model],
) -> Callable[..., list[float]]:
    """Largest error of a link's force in shares of its largest effect, slow and fast.

    [held and swept, held and thrown, straight and swept, straight and thrown]. Straight voltages
    go to a linear material: the chain takes w, too, as straight, and hysteresis bends it a little.
    """

    def run(
        model: Model, link: str, values: dict[str, float], force: OwnForce, states: int
    ) -> list[float]:
        errors = []
        for hold in (Hold.ZERO, Hold.FIRST):
            rig = model if hold is Hold.ZERO else without_hysteresis(model)
            for voltage in (swept, thrown):
                expected = coupled(rig, voltage, PERIOD, force, states, hold)
                found = simulate(rig.with_link(link, **values), voltage, PERIOD, hold=hold)
                effect = np.max(np.abs(simulate(rig, voltage, PERIOD, hold=hold) - expected))
                errors.append(float(np.max(np.abs(found - expected)) / effect))
        return errors

    return run
