"""What makes a force costly."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.search.labour import (
    is_costly,
    is_laborious_with,
    is_long,
    is_long_with,
)
from microgripper_control.diagnosis.search.refit import nominal_trial
from microgripper_control.diagnosis.search.rounds import FEW, few_long
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import simulate

PERIOD = 1e-3


@pytest.mark.parametrize(
    ("hold", "frequency", "costly"),
    [
        (Hold.FIRST, 150.0, False),
        (Hold.BANDLIMITED, 150.0, True),  # a sample period is divided as the voltage bends
        (Hold.BANDLIMITED, 0.2, False),
    ],
)
def test_a_force_is_costly_where_the_voltage_bends(
    hold: Hold, frequency: float, costly: bool
) -> None:
    voltage = 75.0 - 70.0 * np.cos(2.0 * np.pi * frequency * PERIOD * np.arange(2000))
    answer = simulate(nominal_model(), voltage, PERIOD, hold=hold)
    run = Recording("run", PERIOD, voltage, answer)
    evidence = Evidence.gather([run], [], Conditions(hold), nominal_model())
    assert is_costly(evidence, nominal_model().with_link("nonlinear_stiffness")) == costly


def test_what_a_sample_costs_does_not_depend_on_others_that_are_finer() -> None:
    """A recording at 50 kHz takes few substeps a sample: one at 1 kHz beside it as many as ever."""

    def run(period: float, samples: int) -> Recording:
        voltage = 75.0 - 70.0 * np.cos(2.0 * np.pi * 0.5 * period * np.arange(samples))
        return Recording("run", period, voltage, 1e-7 * voltage)

    slow, fast = run(PERIOD, 40_000), run(2e-5, 2000)
    hysteresis = nominal_model().with_link("restoring_force_hysteresis")
    for held_out in ([], [fast]):
        evidence = Evidence.gather([slow], held_out, Conditions(), nominal_model())
        assert is_costly(evidence, hysteresis)
    assert not is_costly(Evidence.gather([fast], [], Conditions(), nominal_model()), hysteresis)


@pytest.mark.parametrize(("samples", "long"), [(2000, False), (200_000, True)])
def test_a_costly_force_is_long_on_many_samples(samples: int, long: bool) -> None:
    voltage = 75.0 - 70.0 * np.cos(2.0 * np.pi * 0.5 * PERIOD * np.arange(samples))
    run = Recording("run", PERIOD, voltage, 1e-7 * voltage)
    evidence = Evidence.gather([run], [], Conditions(Hold.ZERO), nominal_model())
    friction = nominal_model().with_link("friction")
    assert is_costly(evidence, friction)
    assert is_long(evidence, friction) == long
    assert not is_long(evidence, nominal_model().with_link("creep"))


@pytest.mark.parametrize(("samples", "laborious"), [(4000, False), (40_000, True)])
def test_only_of_many_samples_a_part_is_fitted_first(samples: int, laborious: bool) -> None:
    """Friction is costly on either; of few samples all are fitted at once."""
    voltage = 75.0 - 70.0 * np.cos(2.0 * np.pi * 0.5 * PERIOD * np.arange(samples))
    run = Recording("run", PERIOD, voltage, 1e-7 * voltage)
    evidence = Evidence.gather([run], [], Conditions(Hold.ZERO), nominal_model())
    nominal = nominal_trial(evidence, nominal_model())
    assert is_laborious_with(evidence, nominal, "friction") == laborious
    assert not is_laborious_with(evidence, nominal, "creep")


def test_of_what_takes_long_only_the_first_few_join() -> None:
    voltage = 75.0 - 70.0 * np.cos(2.0 * np.pi * 0.5 * PERIOD * np.arange(200_000))
    run = Recording("run", PERIOD, voltage, 1e-7 * voltage)
    evidence = Evidence.gather([run], [], Conditions(Hold.ZERO), nominal_model())
    stiff = nominal_model().with_link("contact", position=0.0, stiffness=1e8)
    beside = nominal_trial(evidence, stiff)
    long = ["friction", "backlash", "restoring_force_hysteresis"]
    assert len(long) > FEW
    assert all(is_long_with(evidence, beside, name) for name in long)
    names = ["friction", "creep", "backlash", "restoring_force_hysteresis", "saturation"]
    assert few_long(evidence, beside, names) == ["friction", "creep", "backlash", "saturation"]
