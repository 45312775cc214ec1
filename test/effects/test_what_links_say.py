"""What links say of themselves is true of the plant with them, whatever their values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from microgripper_control.effects.base import Scales
from microgripper_control.effects.registry import link_named
from microgripper_control.plant.model import Model

SCALES = Scales(1e-3, 10.0, (0.0, 160.0), 1e3, (-1e-5, 1e-5), 5e7, 0.0038)


def said(paper: Model, name: str, **values: float) -> str:
    link = link_named(name)
    assert link.says is not None
    return link.says(paper.with_link(name, **values).values(name), SCALES)


@pytest.mark.parametrize(
    ("name", "values", "told"),
    [
        ("sensor_lag", {"averaging": 0.0, "time_constant": 0.0}, "the sensor lags: "),
        ("transport_delay", {"delay": 0.0}, "the rig answers late: "),
    ],
)
def test_a_clock_without_a_lag_is_all_there_is(
    paper: Model, name: str, values: dict[str, float], told: str
) -> None:
    assert said(paper, name, clock=2e-3, **values) == f"{told}it is read anew every 2.0 ms"


def test_a_flexure_that_is_not_symmetric_softens_one_way(paper: Model) -> None:
    """k + 2 q x."""
    both = said(paper, "nonlinear_stiffness", quadratic=5e10, cubic=0.0, levelling=0.0)
    assert both == (
        "the flexure stiffens by 2.0 % in one part of the stroke and softens by 2.0 % in another"
    )
    one = said(paper, "nonlinear_stiffness", quadratic=0.0, cubic=-1e15, levelling=0.0)
    assert one == "the flexure softens by 0.60 % over the stroke"


def test_plays_that_widen_are_not_the_whole_loop(paper: Model) -> None:
    plays = {"strength": 0.0, "slope": 1e-8, "widest": 20.0}
    wider = said(paper, "rate_dependent_hysteresis", growth=0.3, **plays)
    assert wider.endswith(
        "plays of up to 20 V, a part of the loop, widen by 30 % per decade of rate"
    )
    narrower = said(paper, "rate_dependent_hysteresis", growth=-0.3, **plays)
    assert "narrow by 30 %" in narrower


@pytest.mark.parametrize(
    ("rate", "lines"),
    [(80.0, [50.0, 60.0]), (100.0, [60.0]), (120.0, [50.0]), (500.0, [50.0, 60.0])],
)
def test_hum_is_tried_wherever_its_line_shows(rate: float, lines: list[float]) -> None:
    """A line on half of the rate, or on zero, has no phase of its own."""
    starts = link_named("mains_hum").starts(replace(SCALES, sample_period=1.0 / rate))
    assert sorted({float(np.rint(start["frequency"])) for start in starts}) == lines


def test_no_mode_is_looked_for_where_the_samples_cannot_show_one() -> None:
    link = link_named("extra_resonance")
    assert not link.starts(replace(SCALES, sample_period=1.0 / 1.0))
    assert link.starts(replace(SCALES, sample_period=1.0 / 10.0))
