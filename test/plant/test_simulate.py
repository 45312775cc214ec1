"""The nominal chain against a general integrator; streaming, holds and initial states."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import Initial, Plant, simulate

STROKE = 20e-6  # m
PERIOD = 1e-3
AGREEMENT = 1e-6 * STROKE
SLOW = 80.0 - 80.0 * np.cos(2.0 * np.pi * np.arange(45) / 30.0)
FAST = np.append(0.0, np.random.default_rng(7).uniform(0.0, 160.0, 44))  # goes anywhere

# Voltage, V, and its rate, V/s, at a time within a piece.
Course = Callable[[float], tuple[float, float]]

with_any_n = pytest.mark.parametrize("n", [1.0, 1.5])


@pytest.fixture
def paper() -> Model:
    return nominal_model()


def rig(n: float) -> Model:
    """The paper's actuator; at other exponents h keeps its size, about 1 um."""
    scale = 1e-6 ** (1.0 - n)
    values = {"n": n, "beta": 0.0152 * scale, "gamma": -0.0227 * scale}
    return nominal_model().with_values({("bouc_wen", name): v for name, v in values.items()})


def integrated(model: Model, pieces: list[tuple[float, Course]]) -> Array:
    """Positions at the ends of the pieces, m, from rest at 0 V, by equations (1), (2), (4).

    Between two pieces the voltage may jump; the hysteresis then runs along the jump.
    """
    w, s = model.values("bouc_wen"), model.values("second_order")
    n = w["n"]

    def grow(h: float, rate: float) -> float:
        fading = w["beta"] * abs(rate) * h * abs(h) ** (n - 1.0)
        return w["alpha"] * w["d"] * rate - fading - w["gamma"] * rate * abs(h) ** n

    def along(_: float, h: Array, jump: float) -> list[float]:
        return [grow(h[0], jump)]

    def rates(t: float, y: Array, course: Course) -> list[float]:
        u, rate = course(t)
        h, x, v = y
        pull = s["k"] * (w["d"] * u - h) - (s["k"] + s["k_s"]) * x - s["b"] * v
        return [grow(h, rate), v, pull / s["m"]]

    u, y, positions = 0.0, np.zeros(3), []
    small = [1e-15, 1e-15, 1e-15 * np.sqrt(s["k"] / s["m"])]
    for duration, course in pieces:
        jump = course(0.0)[0] - u
        if jump != 0.0:
            solved = solve_ivp(along, (0, 1), y[:1], args=(jump,), rtol=1e-10, atol=1e-17)
            y[0] = solved.y[0, -1]
        options = {"args": (course,), "rtol": 1e-8, "atol": small}
        y = solve_ivp(rates, (0.0, duration), y, "DOP853", **options).y[:, -1]
        u = course(duration)[0]
        positions.append(y[1])
    return np.array(positions)


def held(level: float) -> Course:
    return lambda t: (level, 0.0)


def straight(old: float, new: float, duration: float) -> Course:
    rate = (new - old) / duration
    return lambda t: (old + rate * t, rate)


def smooth(begin: float, speed: float) -> Course:
    """From 0 V at rest, 2 and 5 Hz times `speed`, with time counted from `begin`, s."""
    a, b = 4.0 * np.pi * speed, 10.0 * np.pi * speed

    def course(t: float) -> tuple[float, float]:
        phase, quick = a * (begin + t), b * (begin + t)
        u = 60.0 * (1.0 - np.cos(phase)) + 20.0 * (1.0 - np.cos(quick))
        return u, 60.0 * a * np.sin(phase) + 20.0 * b * np.sin(quick)

    return course


def test_a_held_voltage_at_the_start_is_x_0(paper: Model) -> None:
    assert simulate(paper, np.array([5.0, 5.0]), PERIOD)[0] == 0.0


@with_any_n
@pytest.mark.parametrize("voltage", [SLOW, FAST], ids=["slow", "fast"])
@pytest.mark.parametrize("period", [1e-3, 5e-5], ids=["1 kHz", "20 kHz"])
def test_held_voltages(n: float, voltage: Array, period: float) -> None:
    """At 1 kHz the mechanics rests within a sample; at 20 kHz it rings on through the next ones."""
    expected = integrated(rig(n), [(period, held(u)) for u in voltage[:-1]])
    found = simulate(rig(n), voltage, period)
    np.testing.assert_allclose(found[1:], expected, rtol=0.0, atol=1e-2 * AGREEMENT)


@with_any_n
@pytest.mark.parametrize(
    ("voltage", "tolerance"),
    [(80.0 - 80.0 * np.cos(np.arange(240) / 150.0 * np.pi), AGREEMENT), (FAST, 2e-4 * STROKE)],
    ids=["slow", "fast"],
)
def test_straight_voltages(n: float, voltage: Array, tolerance: float) -> None:
    """w is taken as straight, too: how h bends it within a sample is lost, 1e-4 at the fastest."""
    pieces = [(PERIOD, straight(*pair, PERIOD)) for pair in pairwise(voltage)]
    expected = integrated(rig(n), pieces)
    found = simulate(rig(n), voltage, PERIOD, hold=Hold.FIRST)
    np.testing.assert_allclose(found[1:], expected, rtol=0.0, atol=tolerance)


@with_any_n
@pytest.mark.parametrize(("speed", "tolerance"), [(1.0, AGREEMENT), (10.0, 50.0 * AGREEMENT)])
def test_bandlimited_voltages(n: float, speed: float, tolerance: float) -> None:
    """Samples of a smooth voltage against the voltage itself: 2 and 5 Hz, 20 and 50 Hz.

    Its corners lie off the voltage by some 1e-5 where it turns fast, and h remembers how far.
    """
    times = PERIOD * np.arange(160)
    voltage = np.array([smooth(t, speed)(0.0)[0] for t in times])
    expected = integrated(rig(n), [(PERIOD, smooth(t, speed)) for t in times[:-1]])
    found = simulate(rig(n), voltage, PERIOD, hold=Hold.BANDLIMITED)
    inner = slice(0, -8)  # beyond the record nobody knows how the voltage ran on
    np.testing.assert_allclose(found[1:][inner], expected[inner], rtol=0.0, atol=tolerance)


@pytest.mark.parametrize("frequency", [20.0, 60.0, 150.0])
def test_a_slow_oscillator_answers_a_bandlimited_sine_as_its_transfer_function_says(
    paper: Model, frequency: float
) -> None:
    """The public Bouc-Wen benchmark's mass and spring, well damped, at its 750 Hz."""
    mechanics = {"m": 2.0, "b": 100.0, "k": 5e4, "k_s": 0.0}
    values = {("second_order", name): value for name, value in mechanics.items()}
    values |= {("bouc_wen", "d"): 1e-6, ("bouc_wen", "alpha"): 0.0}
    times = np.arange(750) / 750.0
    turns = 2j * np.pi * frequency
    gain = 1e-6 * 5e4 / (2.0 * turns**2 + 100.0 * turns + 5e4)
    expected = np.imag(gain * np.exp(turns * times))
    found = simulate(
        paper.with_values(values),
        np.sin(2.0 * np.pi * frequency * times),
        1.0 / 750.0,
        hold=Hold.BANDLIMITED,
        initial=Initial.PERIODIC,
    )
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-4 * abs(gain))


@pytest.mark.parametrize("frequency", [8.0, 40.0])
@pytest.mark.parametrize("lag", [0.2 * PERIOD, 2.0 * PERIOD])
def test_a_lag_answers_a_bandlimited_sine_as_its_transfer_function_says(
    paper: Model, frequency: float, lag: float
) -> None:
    """To a microsecond, without the corners that the lag asks for after a jump."""
    straight = paper.with_values({("bouc_wen", "alpha"): 0.0})
    v, d = straight.values("second_order"), straight.values("bouc_wen")["d"]
    turns = 2j * np.pi * frequency
    stiffness = v["k"] + v["k_s"]
    gain = v["k"] * d / (v["m"] * turns**2 + v["b"] * turns + stiffness) / (1.0 + lag * turns)
    times = PERIOD * np.arange(1000)
    model = straight.with_link("amplifier_lag", lag=lag, curvature=0.0)
    voltage = 80.0 + 50.0 * np.sin(2.0 * np.pi * frequency * times)
    found = simulate(model, voltage, PERIOD, hold=Hold.BANDLIMITED, initial=Initial.PERIODIC)
    expected = 80.0 * d * v["k"] / stiffness + 50.0 * np.imag(gain * np.exp(turns * times))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-6 * abs(turns) * 50.0 * abs(gain))


@pytest.mark.parametrize("samples", [0.3, 1.0, 2.75])
def test_a_delayed_voltage(paper: Model, samples: float) -> None:
    """The held voltage steps at the shifted instants, fractions of a sample included."""
    voltage = FAST[:25]
    whole, fraction = int(samples), samples % 1.0
    late = [0.0] * (whole + 1) + list(voltage)  # late[k + 1] steps in `fraction` of a sample in k
    pieces = []
    for k in range(len(voltage) - 1):
        if fraction > 0.0:
            pieces.append((fraction * PERIOD, held(late[k])))
        pieces.append(((1.0 - fraction) * PERIOD, held(late[k + 1])))
    expected = integrated(paper, pieces)[1 if fraction > 0.0 else 0 :: 2 if fraction > 0.0 else 1]
    model = paper.with_link("transport_delay", delay=samples * PERIOD)
    found = simulate(model, voltage, PERIOD)
    np.testing.assert_allclose(found[1:], expected, rtol=0.0, atol=1e-2 * AGREEMENT)


@pytest.mark.parametrize("links", [(), ("transport_delay", "creep", "friction", "mains_hum")])
def test_streaming_is_batch(paper: Model, links: tuple[str, ...]) -> None:
    model = paper
    for link in (*links, "sensor_noise", "sensor_quantization"):
        model = model.with_link(link)
    plant = Plant(model, PERIOD)
    streamed = []
    for u in FAST:
        streamed.append(plant.read())
        plant.write(u)
    np.testing.assert_array_equal(streamed, simulate(model, FAST, PERIOD, random=True))


def test_a_plant_starts_settled_at_its_first_voltage(paper: Model) -> None:
    plant = Plant(paper, PERIOD, initial_voltage=40.0)
    first = plant.read()
    plant.write(40.0)
    assert plant.read() == pytest.approx(first, abs=1e-15)
    assert first == pytest.approx(40.0 * 1.4447e-7 * 5e7 / (5e7 + 8.2e5))


@pytest.mark.parametrize("hold", list(Hold))
def test_a_first_sample_is_where_it_rests(paper: Model, hold: Hold) -> None:
    h, u = 3e-7, np.full(20, 55.0)
    conditions = {"hold": hold, "initial": Initial.FIRST_SAMPLE, "initial_hysteresis": h}
    x = simulate(paper, u, PERIOD, **conditions)
    expected = (1.4447e-7 * 55.0 - h) * 5e7 / (5e7 + 8.2e5)
    np.testing.assert_allclose(x, expected, rtol=1e-12)


@pytest.mark.parametrize("hold", [Hold.FIRST, Hold.BANDLIMITED])
def test_a_smooth_voltage_from_rest_has_come_to_its_first_value_one_way(
    paper: Model, hold: Hold
) -> None:
    u = np.full(20, 100.0)
    x = simulate(paper, u, PERIOD, hold=hold)
    risen = simulate(paper, np.append(np.linspace(0.0, 100.0, 500), u), PERIOD, hold=Hold.FIRST)
    np.testing.assert_allclose(x, risen[-1], rtol=1e-12)


def test_from_rest_the_material_has_seen_no_more_than_the_amplifier_gave(paper: Model) -> None:
    limited = paper.with_link("saturation", low=0.0, high=120.0)
    told, given = (np.full(20, volts) for volts in (160.0, 120.0))
    found = simulate(limited, told, 1e-3, hold=Hold.FIRST)
    np.testing.assert_allclose(found, simulate(paper, given, 1e-3, hold=Hold.FIRST), rtol=1e-6)


def test_without_hysteresis_what_is_brought_along_fades(paper: Model) -> None:
    steady = paper.with_values(
        {("bouc_wen", "alpha"): 0.0, ("bouc_wen", "beta"): 0.3, ("bouc_wen", "gamma"): -0.01}
    )
    voltage = np.linspace(0.0, 160.0, 3)
    found = simulate(steady, voltage, 1e-3, initial=Initial.FIRST_SAMPLE, initial_hysteresis=-1e-6)
    assert np.all(np.isfinite(found))
    assert abs(found[-1] - simulate(steady, voltage, 1e-3)[-1]) < 1e-12


@pytest.mark.parametrize("hold", list(Hold))
@pytest.mark.parametrize("amplitude", [80.0, 5.0])
def test_a_periodic_voltage_meets_its_steady_cycle(
    paper: Model, hold: Hold, amplitude: float
) -> None:
    """Small loops take tens of periods to close when one waits for it."""
    u = 80.0 + amplitude * np.sin(2.0 * np.pi * np.arange(300) / 300.0)
    at_once = simulate(paper, u, PERIOD, hold=hold, initial=Initial.PERIODIC)
    waited = simulate(paper, np.tile(u, 60), PERIOD, hold=hold, initial=Initial.FIRST_SAMPLE)
    # The last periods, but the very last for the voltage's continuation beyond its end.
    np.testing.assert_allclose(at_once, waited[-600:-300], rtol=0.0, atol=1e-6 * np.ptp(at_once))


def test_a_period_may_begin_anywhere(paper: Model) -> None:
    u = 80.0 + 40.0 * np.sin(2.0 * np.pi * np.arange(300) / 300.0)
    x = simulate(paper, u, PERIOD, initial=Initial.PERIODIC)
    shifted = simulate(paper, np.roll(u, 111), PERIOD, initial=Initial.PERIODIC)
    np.testing.assert_allclose(np.roll(x, 111), shifted, rtol=0.0, atol=1e-9 * np.ptp(x))


@pytest.mark.parametrize(
    "voltage", [np.zeros(1), np.zeros((3, 2)), np.array([0.0, np.nan]), np.array([0.0, np.inf])]
)
def test_a_bad_voltage_is_refused(paper: Model, voltage: Array) -> None:
    with pytest.raises(MicrogripperError, match="two finite samples in one row"):
        simulate(paper, voltage, PERIOD)


@pytest.mark.parametrize("hold", Hold)
@pytest.mark.parametrize("initial", [Initial.REST, Initial.FIRST_SAMPLE])
@pytest.mark.parametrize("links", [(), ("transport_delay", "friction", "sensor_lag")])
def test_blocks_do_not_show(
    monkeypatch: pytest.MonkeyPatch, hold: Hold, initial: Initial, links: tuple[str, ...]
) -> None:
    model = nominal_model()
    for name in links:
        model = model.with_link(name)
    whole = simulate(model, FAST, PERIOD, hold=hold, initial=initial)
    monkeypatch.setattr("microgripper_control.plant.simulate.BLOCK", 7)
    parts = simulate(model, FAST, PERIOD, hold=hold, initial=initial)
    np.testing.assert_allclose(parts, whole, rtol=1e-12, atol=1e-18)
