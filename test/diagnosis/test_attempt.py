"""Which fits of an effect go on."""

from __future__ import annotations

from microgripper_control.diagnosis.fits.trial import Trial
from microgripper_control.diagnosis.search.attempt import best_of_each_kind
from microgripper_control.plant.model import nominal_model

EFFECT = "restoring_force_hysteresis"


def fit(distributed: float, left: float) -> Trial:
    return Trial(nominal_model().with_link(EFFECT, distributed=distributed), (), (), left)


def test_the_best_of_each_kind_goes_on_and_no_other() -> None:
    """A joint that slips bit by bit may begin behind one that saturates, and end before it."""
    found = [fit(1.0, 50e-9), fit(0.0, 40e-9), fit(1.0, 60e-9), fit(0.0, 45e-9)]
    assert {trial.fitted_rmse for trial in best_of_each_kind(found, EFFECT)} == {40e-9, 50e-9}
    assert [trial.fitted_rmse for trial in best_of_each_kind(found[:1], EFFECT)] == [50e-9]
