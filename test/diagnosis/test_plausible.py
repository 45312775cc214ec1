"""What a fit may do and what it may cost: ranges of parameters, effects that join others."""

from __future__ import annotations

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.trial import Trial, problem_of
from microgripper_control.diagnosis.search.labour import may_join
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model, nominal_model

RATE = "rate_dependent_hysteresis"
KEY = (RATE, "memory")


def evidence(
    nominal: Model, seconds: float, period: float = 1e-3, hold: Hold = Hold.ZERO
) -> Evidence:
    voltage = 80.0 - 75.0 * np.cos(np.arange(round(seconds / period)) / 50.0)
    recording = Recording("given", period, voltage, 1.3e-7 * voltage)
    return Evidence.gather([recording], [], Conditions(hold=hold), nominal)


def test_what_the_nominal_model_has_is_plausible() -> None:
    """It was identified elsewhere, on longer recordings: it is judged as it is."""
    nominal = nominal_model().with_link(RATE, memory=1.0)
    for given, memory in ((nominal, 1.0), (nominal_model(), 0.2)):
        problem = problem_of(evidence(given, 10.0), nominal, [KEY])
        at = problem.model_at(problem.point(nominal, (0.0,)))
        assert at.value(*KEY) == pytest.approx(memory, rel=1e-3)


def test_nothing_beyond_a_parameter_s_own_range_is_plausible() -> None:
    model = nominal_model()
    for name, link in registry().items():
        if link.starts(evidence(model, 10.0).scales):
            model = model.with_link(name)
    for seconds, period in ((20_000.0, 0.5), (0.002, 1e-6)):
        limits = problem_of(evidence(nominal_model(), seconds, period), model, []).limits
        assert KEY in limits
        for (link, name), (low, high) in limits.items():
            declared = registry()[link].parameter(name)
            assert declared.low <= low <= high <= declared.high, (link, name)


def test_what_is_touched_all_the_time_is_no_contact() -> None:
    """A damped spring far below the stroke would pass for a lag of the amplifier."""
    given = evidence(nominal_model(), 10.0)
    model = nominal_model().with_link("contact")
    low, high = problem_of(given, model, []).limits["contact", "position"]
    lowest, highest = given.scales.position
    assert lowest - 0.2 * given.scales.stroke < low < lowest
    assert highest < high < highest + 0.2 * given.scales.stroke


@pytest.mark.parametrize(
    ("leader", "effect", "seconds", "too_costly"),
    [
        ("friction", "slew_limit", 120.0, True),
        ("friction", "slew_limit", 5.0, False),
        ("amplifier_lag", "sensor_lag", 900.0, False),  # cheap, however long
        ("creep", "mains_hum", 900.0, False),
    ],
)
def test_what_would_take_seconds_a_simulation_joins_no_other(
    leader: str, effect: str, seconds: float, too_costly: bool
) -> None:
    given = evidence(nominal_model(), seconds, hold=Hold.FIRST)
    model = nominal_model().with_link(leader, **registry()[leader].starts(given.scales)[0])
    trial = Trial(model, (), (0.0,), 1e-7)
    assert may_join(given, trial, effect) != too_costly


@pytest.mark.parametrize(("effect", "may"), [("friction", False), ("mains_hum", True)])
def test_a_costly_force_is_not_the_third(effect: str, may: bool) -> None:
    given = evidence(nominal_model(), 5.0, hold=Hold.FIRST)
    model = nominal_model().with_link("creep")
    assert may_join(given, Trial(model, (), (0.0,), 1e-7), effect)
    trial = Trial(model.with_link("slew_limit"), (), (0.0,), 1e-7)
    assert may_join(given, trial, effect) == may
