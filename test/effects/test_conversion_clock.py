"""A sensor's own clock against positions taken at the moments of its conversions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from microgripper_control.core.signals import POSITION, ROWS, Timing
from microgripper_control.effects import conversion_clock
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import Initial, simulate

PERIOD = 1e-3  # s
FIRST = Initial.FIRST_SAMPLE


@pytest.mark.parametrize("clock", [0.13e-3, 0.7e-3, 1e-3, 2.3e-3, 41e-3])
@pytest.mark.parametrize("share", [0.0, 0.4, 0.95])
def test_each_reading_is_the_line_at_the_last_conversion(clock: float, share: float) -> None:
    timing = Timing.divide(PERIOD, {0.0, 0.3}, {0.45}, ramped=True)
    x = np.cumsum(np.random.default_rng(3).normal(size=3 * 150))
    bus = np.zeros((ROWS, len(x)))
    bus[POSITION] = x
    age = share * clock
    prepared = conversion_clock.prepare(clock, age, timing, np.zeros(ROWS))
    conversion_clock.kernel(prepared.coefficients, prepared.state, bus)
    ends = np.append(0.0, np.cumsum(np.resize(timing.steps, len(x))))
    last = clock * np.floor((ends[1:] + age) / clock) - age
    beside = np.abs((ends[1:] + age) / clock - np.rint((ends[1:] + age) / clock)) < 1e-9
    expected = np.interp(last, ends, np.append(0.0, x))
    np.testing.assert_allclose(bus[POSITION][~beside], expected[~beside], rtol=0.0, atol=1e-9)


def test_a_plant_reads_on_the_clock_of_a_lag_or_a_delay() -> None:
    time = PERIOD * np.arange(2000)
    voltage = 80.0 - 80.0 * np.cos(2.0 * np.pi * 3.0 * time)
    still = {"averaging": 0.0, "time_constant": 0.0}
    free = simulate(nominal_model(), voltage, PERIOD, hold=Hold.FIRST)
    lag = nominal_model().with_link("sensor_lag", **still, clock=5e-3)
    delay = nominal_model().with_link("transport_delay", delay=0.0, clock=5e-3)
    for model in (lag, delay):
        held = simulate(model, voltage, PERIOD, hold=Hold.FIRST, reading_age=2e-3)
        at = 5 * ((np.arange(2000) + 2) // 5) - 2
        later = at > 0
        np.testing.assert_allclose(held[later], free[at[later]], rtol=0.0, atol=1e-9)
    assert lag.unclocked().clock == 0.0


@pytest.mark.parametrize("hold", [Hold.ZERO, Hold.FIRST])
@pytest.mark.parametrize("lag", [(8.8e-3, 0.0), (0.0, 1e-3), (0.0, 5e-3), (2.3e-3, 0.6e-3)])
def test_a_lag_is_read_at_any_instant_of_a_long_sample(
    hold: Hold, lag: tuple[float, float]
) -> None:
    """The same plant sampled 500 times as fast gives the motion that is averaged and filtered."""
    averaging, filtering = lag
    period, finer, clock, age = 5e-3, 500, 2.2e-3, 1.3e-3
    step, time = period / finer, period * np.arange(800)
    voltage = 80.0 - 80.0 * np.cos(2.0 * np.pi * 3.0 * time)
    dense = step * np.arange(len(time) * finer - finer + 1)
    each = np.floor(dense / period + 1e-9) * period if hold is Hold.ZERO else dense
    course = simulate(nominal_model(), np.interp(each, time, voltage), step, hold=hold)
    if averaging > 0.0:
        window = round(averaging / step)
        area = np.append(0.0, np.cumsum((course[1:] + course[:-1]) / 2.0))
        before = np.concatenate([course[0] * np.arange(-window, 0), area])[: len(area)]
        course = (area - before) / window
    if filtering > 0.0:
        kept = np.exp(-step / filtering)
        late = filtering * (1.0 - kept) / step  # exact for straight lines
        rest = course[0]
        course = lfilter([1.0 - late, late - kept], [1.0, -kept], course - rest) + rest
    last = time - np.mod(time + age, clock)
    values = {"averaging": averaging, "time_constant": filtering}
    model = nominal_model().with_link("sensor_lag", **values, clock=clock)
    found = simulate(model, voltage, period, hold=hold, reading_age=age)
    error = found - np.interp(last, dense, course)
    assert np.std(error) < 3e-9  # of a motion of 20 um


def test_in_a_steady_state_it_goes_on_from_period_to_period() -> None:
    """And does not begin each anew: a period is no whole number of conversions."""
    clock, period = 0.37e-3, 0.5
    elastic = nominal_model().with_values({("bouc_wen", "alpha"): 0.0})
    model = elastic.with_link("transport_delay", delay=1e-4, clock=clock)
    voltage = 75.0 - 75.0 * np.cos(2.0 * np.pi * np.arange(500) / 500.0)
    for age in (0.0, 0.1e-3, 0.35e-3):
        three = simulate(model, np.tile(voltage, 3), 1e-3, reading_age=age)
        later = (age + 2.0 * period) % clock
        third = simulate(model, voltage, 1e-3, initial=Initial.PERIODIC, reading_age=later)
        np.testing.assert_allclose(third[1:], three[-499:], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("age", [0.0, 1e-3, 2.9e-3])
def test_in_a_steady_state_each_sample_is_the_line_at_the_last_conversion(age: float) -> None:
    model = nominal_model().with_link("sensor_lag", clock=3.7e-3, time_constant=0.0, averaging=0.0)
    voltage = 80.0 - 80.0 * np.cos(2.0 * np.pi * np.arange(50) / 50.0)
    steady = {"hold": Hold.FIRST, "initial": Initial.PERIODIC}
    found = simulate(model, voltage, 1e-3, reading_age=age, **steady)
    x = np.tile(simulate(nominal_model(), voltage, 1e-3, **steady), 3)
    instants = 0.05 + 1e-3 * np.arange(50)
    read = instants - (instants - 0.05 + age + 1e-12) % 3.7e-3
    np.testing.assert_allclose(found, np.interp(read, 1e-3 * np.arange(150), x), atol=2e-9)


@pytest.mark.parametrize(("delay", "clock"), [(0.86013e-3, 0.156137e-3), (0.93037e-3, 0.213172e-3)])
def test_a_stiff_rig_has_followed_a_step_before_most_readings(delay: float, clock: float) -> None:
    """The same plant sampled 500 times as fast gives the position that each conversion meets."""
    finer, age = 500, 0.041236e-3
    voltage = 80.0 + 1.5 * np.cumsum(np.random.default_rng(4).normal(size=400))
    step = PERIOD / finer
    course = simulate(nominal_model(), np.repeat(voltage, finer), step, initial=FIRST)
    time = PERIOD * np.arange(len(voltage))
    last = time - np.mod(time + age, clock) - delay
    expected = np.interp(last, step * np.arange(len(course)), course)
    late = nominal_model().with_link("transport_delay", delay=delay, clock=clock)
    found = simulate(late, voltage, PERIOD, initial=FIRST, reading_age=age)
    begun = 5  # samples, at most, in which the first reading is older than the recording
    assert np.std((found - expected)[begun:]) < 0.025 * np.std(np.diff(found))
