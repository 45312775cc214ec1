"""Effects before and behind the actuator against closed forms and independent solvers."""

from __future__ import annotations

import numpy as np
import pytest
from rig_runs import PERIOD, STEP, answer, element
from scipy.integrate import solve_ivp
from scipy.signal import bessel, butter, freqs, lsim

from microgripper_control.validation.block import Array, Block
from microgripper_control.validation.effects.form import Element


def sine(frequency: float, samples: int, step: float = STEP) -> Array:
    return np.sin(2.0 * np.pi * frequency * step * np.arange(1, samples + 1))


def response(made: Element, frequency: float, samples: int, step: float = STEP) -> complex:
    """Gain and phase on the second half of a sine, from the output's and input's correlation."""
    t = step * np.arange(1, samples + 1)
    carrier = np.exp(-2j * np.pi * frequency * t)
    out = answer(made, sine(frequency, samples, step), step=step)
    late = slice(samples // 2, None)
    return complex(
        (out * carrier)[late].sum() / (sine(frequency, samples, step) * carrier)[late].sum()
    )


def test_the_amplifier_s_bessel_filter_is_scipy_s() -> None:
    u = 40.0 * sine(300.0, 4000)
    system = bessel(4, 1.0 / 5e-4, analog=True, norm="delay")
    t = STEP * np.arange(4001)
    expected = lsim(system, np.concatenate([[0.0], u]), t)[1][1:]
    assert answer(element("amplifier_lag", "a", 5e-4), u) == pytest.approx(expected, abs=1e-8)


def test_a_held_jump_goes_through_the_bessel_filter_as_scipy_says() -> None:
    u = np.full(500, 10.0)
    system = bessel(4, 1.0 / 5e-4, analog=True, norm="delay")
    t = STEP * np.arange(501)
    expected = lsim(system, np.full(501, 10.0), t)[1][1:]
    found = answer(element("amplifier_lag", "a", 5e-4), u, slant=0.0)
    assert found == pytest.approx(expected, abs=1e-8)
    assert found.max() < 1.01 * 10.0


def test_the_soft_current_limit_agrees_with_solve_ivp() -> None:
    made = element("slew_limit", "a", 0.2, sink=0.7, growth=0.3)
    u = np.concatenate([np.full(4000, 30.0), np.full(4000, 5.0)])
    found = answer(made, u, slant=0.0)

    def rate(t: float, v: list[float]) -> list[float]:
        away = (30.0 if t < 4000 * STEP else 5.0) - v[0]
        limit = 160.0 / 0.2 / (1.0 + 0.3 * v[0] / 160.0) * (1.0 if away > 0.0 else 0.7)
        return [limit * np.tanh(away / 0.8)]

    t = STEP * np.arange(1, 8001)
    solved = solve_ivp(rate, (0.0, t[-1]), [0.0], t_eval=t, rtol=1e-8, atol=1e-8, max_step=1e-4)
    assert found == pytest.approx(solved.y[0], abs=0.02)


def test_the_reservoir_lends_its_boost_once_and_then_folds_back() -> None:
    lasting = 160.0 / 0.5
    found = answer(element("slew_limit", "b", 0.5, boost=1.5), np.full(30_000, 160.0), slant=0.0)
    rates = np.diff(found) / STEP
    assert rates[0] == pytest.approx(2.5 * lasting, rel=1e-3)
    assert rates[10_000] < 1.5 * lasting
    assert (np.diff(rates[:10_000]) <= 1e-6).all()


def test_saturation_leaves_all_below_its_knee_and_bends_all_above() -> None:
    u = np.linspace(0.0, 160.0, 321)
    v = answer(element("saturation", "a", 0.25, width=0.1), u)
    assert v[u <= 120.0] == pytest.approx(u[u <= 120.0], abs=1e-12)
    assert (v[u > 120.0] < u[u > 120.0]).all()
    assert (np.diff(v) >= 0.0).all()


def test_the_pipeline_is_late_by_its_delay_on_average() -> None:
    made = element("transport_delay", "a", 6e-3)
    t = STEP * np.arange(1, 6001)
    late = t - answer(made, t.copy())
    assert late[3000:].mean() == pytest.approx(6e-3, rel=2e-3)
    assert late[3000:].max() - late[3000:].min() == pytest.approx(1e-3, rel=0.03)


@pytest.mark.parametrize("frequency", [40.0, 150.0])
def test_the_mount_s_two_modes_have_their_transfer_function(frequency: float) -> None:
    made = element("extra_resonance", "b", 0.2, tone=0.3, damping=0.05)
    s = 2j * np.pi * frequency
    expected = 1.0 + 0.0j
    for w, mu in ((2.0 * np.pi * 150.0, 0.2), (1.7 * 2.0 * np.pi * 150.0, 0.07)):
        expected -= mu * s**2 / (s**2 + 2.0 * 0.05 * w * s + w**2)
    assert response(made, frequency, 60_000) == pytest.approx(expected, rel=2e-3)


def test_the_sensor_s_butterworth_has_its_transfer_function() -> None:
    made = element("sensor_lag", "b", 2e-3)
    expected = freqs(*butter(3, 1e3, analog=True), [2.0 * np.pi * 100.0])[1][0]
    assert response(made, 100.0, 40_000) == pytest.approx(expected, rel=1e-3)


def test_exposures_average_a_ramp_to_its_middle_and_are_held() -> None:
    window = 8e-3
    t = STEP * np.arange(1, 20_001)
    late = t - answer(element("sensor_lag", "a", window), t.copy())
    assert late[5000:].mean() == pytest.approx(0.5 * window + window / 8.0, rel=1e-3)
    assert late[5000:].max() - late[5000:].min() == pytest.approx(window / 4.0, rel=0.02)


def test_the_converter_is_off_by_half_a_step_and_its_bow_at_most() -> None:
    size = 1e-7
    x = np.linspace(-3e-6, 3e-6, 4001)
    off = answer(element("sensor_quantization", "a", size, bow=0.3), x) - x
    assert np.abs(off).max() <= (0.5 + 0.3) * size * 1.0001
    assert len(np.unique(np.round((x + off) / size, 6))) < 70


def test_the_hum_is_at_the_mains_and_wanders_by_hundredths_of_a_hertz() -> None:
    made = element("mains_hum", "a", 1e-7, region=0.1)
    found = np.zeros(10_000)
    made.run(Block(-PERIOD, PERIOD, found, found, found))
    spectrum = np.abs(np.fft.rfft(found * np.hanning(10_000)))
    peak = np.fft.rfftfreq(10_000, PERIOD)[spectrum.argmax()]
    assert peak == pytest.approx(50.0, abs=0.1)
    assert found.std() == pytest.approx(1e-7 / np.sqrt(2.0), rel=0.15)


def test_drift_begins_at_nothing_and_grows_slowly() -> None:
    for form in "ab":
        found = np.zeros(10_000)
        element("thermal_drift", form, 1e-6).run(Block(-PERIOD, PERIOD, found, found, found))
        assert abs(found[0]) < 2e-8
        assert np.abs(found).max() > 1e-8
        assert np.abs(np.diff(found)).max() < 2e-9
