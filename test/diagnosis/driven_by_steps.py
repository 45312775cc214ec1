"""A rig that is driven by steps, as a diagnosis begins with it: nothing tried yet but a refit."""

from __future__ import annotations

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.search.pool import Pool
from microgripper_control.diagnosis.search.refit import nominal_trial, refit_trial
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.simulate import simulate


def refitted(rig: Model, noise: float) -> Pool:
    """The refit of the nominal model to 60 steps of 0.1 s; `noise` in m rms."""
    rng = np.random.default_rng(8)
    voltage = np.repeat(rng.uniform(20.0, 140.0, 60), 100)
    x = simulate(rig, voltage, 1e-3) + noise * rng.standard_normal(len(voltage))
    recordings = [Recording("run", 1e-3, voltage, x)]
    evidence = Evidence.gather(recordings, [], Conditions(), nominal_model())
    before = nominal_trial(evidence, nominal_model())
    return Pool(evidence, before, refit_trial(evidence, before))
