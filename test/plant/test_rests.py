"""Where the voltage rests, only as much is simulated as moves: held against the live plant."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from microgripper_control.core.signals import Array
from microgripper_control.plant import chain
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import Plant, simulate

PERIOD = 1e-3  # s
RESTS = np.repeat([0.0, 40.0, 120.0, 10.0, 0.0], [300, 1500, 100, 900, 2000])  # V
SLOW = nominal_model().with_values({("second_order", "b"): 5e7})  # a second
ROUNDING = 1e-14  # m: far below what any recording shows


def with_friction(**others: dict[str, float]) -> Model:
    model = nominal_model().with_link("friction")
    for link, values in others.items():
        model = model.with_link(link, **values)
    return model


def live(model: Model, voltage: Array) -> Array:
    """The displacement read sample by sample, m: no rest is known of there."""
    plant = Plant(model, PERIOD, initial_voltage=voltage[0])

    def readings() -> Iterator[float]:
        for volts in voltage:
            yield plant.read()
            plant.write(volts)

    return np.fromiter(readings(), float)


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many internal steps the links are run over, call by call."""
    counted: list[int] = []
    for name in ("_run", "_run_and_see"):
        original = getattr(chain, name)

        def counting(
            links: list[object], bus: Array, *more: int, original: Callable[..., object] = original
        ) -> object:
            counted.append(bus.shape[1])
            return original(links, bus, *more)

        monkeypatch.setattr(chain, name, counting)
    return counted


@pytest.mark.parametrize(
    "model",
    [
        with_friction(),
        with_friction(creep={}),
        with_friction(transport_delay={"delay": 0.3}),  # longer than one looks whether all is still
        with_friction(transport_delay={"delay": 2.4e-3}, slew_limit={"time": 1e-5}),
        with_friction(sensor_lag={"time_constant": 0.2}),
        with_friction(sensor_lag={"clock": 0.7e-3}),
        with_friction(sensor_lag={"averaging": 0.6, "time_constant": 0.0}),
        nominal_model().with_link("slew_limit", time=5e-3),  # far from there when the rest begins
        SLOW.with_link("backlash", play=5e-6),  # which hides the mass on its way
    ],
    ids=[
        "friction",
        "creep",
        "long delay",
        "slew",
        "long lag",
        "clock",
        "average",
        "slow slew",
        "play",
    ],
)
def test_a_rest_is_as_the_live_plant_has_it(model: Model) -> None:
    found = simulate(model, RESTS, PERIOD)
    assert np.max(np.abs(found - live(model, RESTS))) < ROUNDING
    assert np.ptp(found) > 1e-6


def test_a_rest_takes_next_to_nothing(run: list[int]) -> None:
    simulate(with_friction(), RESTS, PERIOD)
    steps = chain.Chain(with_friction(), PERIOD, np.zeros(4)).steps
    assert sum(run) < 0.3 * len(RESTS) * steps


def test_what_creeps_does_not_rest(run: list[int]) -> None:
    model = with_friction(creep={})
    simulate(model, RESTS, PERIOD)
    steps = chain.Chain(model, PERIOD, np.zeros(4)).steps
    assert sum(run) > 0.9 * (len(RESTS) - 300) * steps


def test_what_goes_on_moving_is_seldom_looked_at(run: list[int]) -> None:
    simulate(
        nominal_model().with_link("extra_resonance", frequency=30.0, damping=1e-4, drag=0.01),
        RESTS,
        PERIOD,
    )
    assert len(run) < 30


@pytest.mark.parametrize("hold", [Hold.FIRST, Hold.BANDLIMITED])
def test_other_holds_rest_as_well(hold: Hold, monkeypatch: pytest.MonkeyPatch) -> None:
    found = simulate(with_friction(), RESTS, PERIOD, hold=hold)
    monkeypatch.setattr(chain.Chain, "is_laborious", False)
    assert np.max(np.abs(found - simulate(with_friction(), RESTS, PERIOD, hold=hold))) < ROUNDING
