"""Intervals say what recordings leave open, also where a derivative would not tell."""

from __future__ import annotations

import math

import numpy as np
import pytest

from microgripper_control.core.parameters import Parameter
from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.fitting import refine
from microgripper_control.diagnosis.fits.identified_model import allowed, identified
from microgripper_control.diagnosis.fits.trial import Trial, fitted_keys
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import Initial, simulate

PERIOD = 1e-3
TIME = PERIOD * np.arange(8000)
VOLTAGE = 70.0 + 40.0 * np.sin(2.0 * np.pi * 3.0 * TIME) + 25.0 * np.sin(2.0 * np.pi * 41.0 * TIME)


def test_intervals_keep_to_what_is_allowed_or_say_that_nothing_is_known() -> None:
    """Damping of a contact that is met once, gently: a derivative would say -14 500 to 14 700."""
    limits = Parameter("damping", "s/m", 0.0, 0.0, 1000.0, "")
    assert allowed((-14_500.0, 14_700.0), limits) == (-math.inf, math.inf)
    assert allowed((-14_500.0, 700.0), limits) == (0.0, 700.0)
    assert allowed((30.0, 1400.0), limits) == (30.0, 1000.0)
    assert allowed((30.0, 50.0), limits) == (30.0, 50.0)


def test_what_may_be_anything_leaves_the_others_their_intervals() -> None:
    """A play that is taken up at once: its spread shows nothing, but could trade with its width."""
    rig = nominal_model().with_link("backlash", play=3e-7, spread=0.0)
    noise = 1.5e-8 * np.random.default_rng(2).standard_normal(len(TIME))
    recording = Recording("run", PERIOD, VOLTAGE, simulate(rig, VOLTAGE, PERIOD) + noise)
    evidence = Evidence.gather([recording], [], Conditions(), nominal_model())
    model = nominal_model().with_link("backlash", play=3e-7, spread=1e-5, slowness=10.0)
    free = fitted_keys(model, ["bouc_wen", "backlash"])
    found = identified(evidence, Trial(model, free, (0.0,), np.inf)).settings["backlash"]
    assert found["spread"].interval == (-math.inf, math.inf)
    low, high = found["play"].interval or (-math.inf, math.inf)
    assert low < 3e-7 < high
    assert high - low < 2e-8


def told_delay(samples: float, hold: Hold) -> tuple[float, float]:
    """The interval of a planted delay, both in samples, fitted from its nearest first guess."""
    rig = nominal_model().with_link("transport_delay", delay=samples * PERIOD)
    clean = simulate(rig, VOLTAGE, PERIOD, hold=hold, initial=Initial.FIRST_SAMPLE)
    noise = 1e-8 * np.random.default_rng(11).standard_normal(len(clean))
    recording = Recording("run", PERIOD, VOLTAGE.copy(), clean + noise)
    guess = (int(samples) + 0.5) * PERIOD
    model = nominal_model().with_link("transport_delay", delay=guess)
    evidence = Evidence.gather([recording], [], Conditions(hold=hold), nominal_model())
    free = fitted_keys(model, ["bouc_wen", "transport_delay"])
    found = identified(evidence, refine(evidence, Trial(model, free, (0.0,), np.inf)))
    low, high = found.settings["transport_delay"]["delay"].interval or (np.nan, np.nan)
    return low / PERIOD, high / PERIOD


@pytest.mark.parametrize("loud_first", [False, True])
def test_of_a_hum_the_loudest_recording_tells_the_size(loud_first: bool) -> None:
    """Each has its own; the order in which they are named tells nothing."""
    recordings = []
    for amplitude in (2e-8, 2e-7):
        noise = 1e-8 * np.random.default_rng(5).standard_normal(len(TIME))
        hum = amplitude * np.sin(2.0 * np.pi * 50.0 * TIME)
        reading = simulate(nominal_model(), VOLTAGE, PERIOD) + hum + noise
        recordings.append(Recording("run", PERIOD, VOLTAGE, reading))
    if loud_first:
        recordings.reverse()
    evidence = Evidence.gather(recordings, [], Conditions(), nominal_model())
    model = nominal_model().with_link("mains_hum", frequency=50.0, amplitude=1e-9)
    free = fitted_keys(model, ["bouc_wen", "mains_hum"])
    found = identified(evidence, refine(evidence, Trial(model, free, (0.0, 0.0), np.inf)))
    assert found.value("mains_hum", "amplitude") == pytest.approx(2e-7, rel=0.02)


@pytest.mark.parametrize("samples", [2.3, 2.6])
def test_parts_of_a_sample_leave_no_trace_where_the_voltage_is_held(samples: float) -> None:
    """The paper's plant rests a quarter of a millisecond after a step of the voltage."""
    low, high = told_delay(samples, Hold.ZERO)
    assert low == pytest.approx(2.0, abs=0.01)
    assert 2.6 < high < 3.0


def test_they_are_told_where_it_runs_smoothly() -> None:
    low, high = told_delay(2.3, Hold.FIRST)
    assert low < 2.3 < high
    assert high - low < 0.02
