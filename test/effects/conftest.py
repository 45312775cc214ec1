"""What the tests of links share."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.signal import cont2discrete, lfilter

from microgripper_control.core.signals import LEVELS, POSITION, ROWS, VOLTAGE, Array, Timing
from microgripper_control.effects.base import Link
from microgripper_control.effects.registry import link_named
from microgripper_control.plant.chain import Chain
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import Plant, simulate

Transfer = tuple[list[float], list[float]]  # numerator and denominator
NOISE = 15e-9  # m, of the sensor in the tests that recover planted values


@pytest.fixture
def paper() -> Model:
    """The paper's actuator: 18 kHz, at rest within a fifth of a millisecond."""
    return nominal_model()


@pytest.fixture
def slow(paper: Model) -> Model:
    """The maker's figures: 0.33 N/um, 1.3 kHz and hardly damped."""
    stiffness, omega = 0.33e6, 2.0 * np.pi * 1300.0
    mass = stiffness / omega**2
    values = {"k": stiffness, "k_s": 0.0, "m": mass, "b": 0.04 * mass * omega}
    return paper.with_values({("second_order", key): value for key, value in values.items()})


@pytest.fixture
def without_hysteresis() -> Callable[[Model], Model]:
    """The same rig as a linear one, so that linear theory has the answer."""
    return lambda model: model.with_values({("bouc_wen", "alpha"): 0.0})


@pytest.fixture
def filtered() -> Callable[[Model, Array, Transfer], Array]:
    """Linear theory at 1 kHz, m: the mechanics of a rig without hysteresis and a filter."""

    def run(linear: Model, voltage: Array, transfer: Transfer) -> Array:
        v = linear.values("second_order")
        numerator, denominator = transfer
        gain = linear.value("bouc_wen", "d") * v["k"]
        mechanics = [v["m"], v["b"], v["k"] + v["k_s"]]
        system = gain * np.array(numerator), np.polymul(denominator, mechanics)
        discrete, poles, _ = cont2discrete(system, 1e-3, "zoh")
        motion: Array = lfilter(discrete[0], poles, voltage)
        return motion

    return run


@pytest.fixture
def lively() -> Array:
    """A voltage with slow parts and fast ones, small steps and large ones, V, 1000 samples."""
    rng = np.random.default_rng(4)
    levels = np.repeat(rng.uniform(0.0, 160.0, 30), 20)
    t = np.arange(400)
    return np.concatenate([80.0 - 80.0 * np.cos(2.0 * np.pi * t * (0.002 + t * 2.5e-5)), levels])


@pytest.fixture
def streamed() -> Callable[[Model, Array, float], Array]:
    """The plant run live, sample by sample, from rest, m."""

    def run(model: Model, voltage: Array, period: float) -> Array:
        plant = Plant(model, period)
        readings = []
        for u in voltage:
            readings.append(plant.read())
            plant.write(u)
        return np.array(readings)

    return run


@pytest.fixture
def finely() -> Callable[[Model, Array, float], Array]:
    """As `simulate` from rest, but on 1024 internal steps a sample whatever the links ask for."""

    def run(model: Model, voltage: Array, period: float) -> Array:
        chain = Chain(model, period, np.zeros(ROWS), divisions=1024)
        bus = np.zeros((ROWS, (len(voltage) - 1) * chain.steps))
        bus[VOLTAGE] = np.repeat(voltage[:-1], chain.steps)
        chain.advance(bus)
        ends = bus[POSITION, chain.steps - 1 :: chain.steps]
        return chain.sense(np.append(chain.rest_position, ends))

    return run


@pytest.fixture
def alone() -> Callable[..., Array]:
    """One link by itself: what leaves at the end of each step, for what enters there.

    `steps` are the durations of one period's steps, s. The link starts at rest at `level`. Values
    left out are nominal.
    """

    def run(
        link: Link | str,
        values: Mapping[str, float],
        signal: Array,
        steps: tuple[float, ...],
        *,
        row: int = VOLTAGE,
        ramped: bool = False,
        level: float = 0.0,
    ) -> Array:
        link = link_named(link) if isinstance(link, str) else link
        levels = np.zeros(LEVELS)
        levels[row] = level
        nominal = {parameter.name: parameter.nominal for parameter in link.parameters}
        prepared = link.prepare({**nominal, **values}, Timing(sum(steps), steps, ramped), levels)
        bus = np.zeros((ROWS, len(signal)))
        bus[row] = signal
        link.kernel(prepared.coefficients, prepared.state, bus)
        return bus[row]

    return run


@pytest.fixture
def recover() -> Callable[..., tuple[Array, Array]]:
    """Fit parameters of a link, with d and the offset beside, to noisy data of a rig.

    Returns the estimates and their standard errors.
    """

    def fit(
        rig: Model,
        link: str,
        start: Mapping[str, float],
        voltage: Array,
        period: float,
    ) -> tuple[Array, Array]:
        measured = simulate(rig, voltage, period)
        measured = measured + NOISE * np.random.default_rng(8).normal(size=len(measured))
        keys = [*((link, name) for name in start), ("bouc_wen", "d")]
        begin = np.array([*start.values(), 1.02 * rig.value("bouc_wen", "d")])
        scales = np.abs(begin)
        bounds = np.array(
            [(p.low, p.high) for p in (link_named(name).parameter(key) for name, key in keys)]
        )

        def residual(z: Array) -> Array:
            inside = np.clip(z * scales, bounds[:, 0], bounds[:, 1])
            model = rig.with_values(dict(zip(keys, inside.tolist(), strict=True)))
            error = measured - simulate(model, voltage, period)
            return (error - error.mean()) / NOISE

        best = least_squares(
            residual, begin / scales, bounds=(bounds / scales[:, None]).T, diff_step=1e-5
        )
        errors = np.sqrt(np.diag(np.linalg.inv(best.jac.T @ best.jac)))
        return (best.x * scales)[:-1], (errors * scales)[:-1]

    return fit
