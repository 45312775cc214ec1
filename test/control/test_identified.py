from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from microgripper_control.control.identified import Identified
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate


def test_gain_of_the_paper_is_the_slope_of_a_plant_without_hysteresis(
    model: Model, identified: Identified
) -> None:
    assert identified.gain == pytest.approx(1.4447e-7 * 5e7 / (5e7 + 8.2e5), rel=1e-15)
    straight = model.with_values({("bouc_wen", "alpha"): 0.0})
    assert simulate(straight, np.full(5, 100.0), 1e-3)[-1] == pytest.approx(
        100.0 * identified.gain, rel=1e-7
    )


def test_reach_holds_all_that_a_cycled_plant_reaches(model: Model, identified: Identified) -> None:
    time = np.arange(4000) * 1e-3
    displacement = simulate(model, 80.0 * (1.0 - np.cos(2.0 * np.pi * time)), 1e-3)
    low, high = identified.reach(0.0, 160.0)
    assert low == 0.0
    assert displacement.min() >= low
    assert displacement.max() == pytest.approx(high, rel=2e-3)
    assert displacement.max() <= high


def test_reach_of_a_bipolar_drive_without_hysteresis_is_symmetric(identified: Identified) -> None:
    straight = replace(identified, alpha=0.0, voltage_range=(-100.0, 100.0))
    low, high = straight.reach(-100.0, 100.0)
    assert high == -low == pytest.approx(100.0 * identified.gain)


def test_values_that_cannot_be_run_have_no_reach(identified: Identified) -> None:
    wild = replace(identified, gamma=-100.0)
    with pytest.raises(MicrogripperError, match=r"gamma = -100: .* bounds within 0 \.\. 160 V"):
        wild.reach(0.0, 160.0)


def test_bad_values_are_named(identified: Identified) -> None:
    with pytest.raises(MicrogripperError, match=r"bouc_wen: alpha = 2 is outside .* 0 \.\. 0.95"):
        replace(identified, alpha=2.0)
    with pytest.raises(MicrogripperError, match="second_order: m = nan"):
        replace(identified, m=float("nan"))
    with pytest.raises(MicrogripperError, match=r"voltage range 1 \.\. 1 V"):
        replace(identified, voltage_range=(1.0, 1.0))
    with pytest.raises(MicrogripperError, match="ringing -1 s: must be 0 or more"):
        replace(identified, ringing=-1.0)
    with pytest.raises(MicrogripperError, match="bouc_wen: d is missing"):
        Identified.from_values({}, {}, (0.0, 160.0))
