"""A second mode is looked for in what the first leaves."""

from __future__ import annotations

import pytest
from driven_by_steps import refitted

from microgripper_control.diagnosis.fits.fitting import base_of, begun
from microgripper_control.diagnosis.fits.trial import with_guess
from microgripper_control.diagnosis.search.finishing import POLISHED, refined
from microgripper_control.diagnosis.search.further_part import add_further_parts
from microgripper_control.diagnosis.search.pool import Pool
from microgripper_control.plant.model import Model, nominal_model

MODE = "extra_resonance"
NOISE = 15e-9  # m


def with_one_mode(rig: Model) -> Pool:
    """What one mode at 90 Hz explains of a rig that is driven by steps."""
    pool = refitted(rig, NOISE)
    guess = with_guess(pool.refit.model, MODE, {"share": 0.1, "frequency": 88.0, "damping": 0.04})
    start = begun(base_of(pool.evidence, pool.refit), guess, [MODE])
    pool.add(refined(pool.evidence, start, POLISHED, 40))
    return pool


def test_a_second_mode_is_found_beside_the_first() -> None:
    first = {"share": 0.1, "frequency": 90.0, "damping": 0.03}
    second = {"second": -0.05, "second_frequency": 210.0, "second_damping": 0.02}
    pool = with_one_mode(nominal_model().with_link(MODE, **first, **second))
    assert pool.leader.rmse > 3.0 * NOISE
    add_further_parts(pool, jobs=1)
    assert pool.leader.rmse == pytest.approx(NOISE, rel=0.1)
    for name, value in second.items():
        assert pool.leader.model.value(MODE, name) == pytest.approx(value, rel=0.1)


def test_what_one_mode_explains_is_given_no_second() -> None:
    pool = with_one_mode(nominal_model().with_link(MODE, share=0.1, frequency=90.0, damping=0.03))
    known = pool.leader
    assert known.rmse == pytest.approx(NOISE, rel=0.1)
    add_further_parts(pool, jobs=1)
    assert pool.leader is known
