"""The resonance, looked for far from where the model has it.

A fit finds the frequency of a resonance from some tenths away; from further off the derivatives by
mass and damping are those of another rig, and both seem not to be seen at all.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.effects.mass_under_forces import natural_frequency
from microgripper_control.effects.registry import registry
from microgripper_control.identification.determined import DYNAMIC
from microgripper_control.identification.problem import Problem
from microgripper_control.plant.model import Key, Model

BAND = 30.0  # times the model's frequency, up and down
GRID = 101  # frequencies in it
FASTEST = 0.9  # of half the sampling rate: what rings faster was hardly sampled
DAMPING = 0.1  # damping ratio that is tried: so light that nothing but a resonance looks like it
LITTLE = 3e-3  # of peak to peak: what leaves less lacks no resonance
FEWER = 0.5  # of the squares: what leaves more is no resonance
GAIN: Key = ("bouc_wen", "d")


@np.errstate(all="ignore")  # what diverges is none
def near_the_resonance(problem: Problem, z: Array, nominal: Model) -> tuple[Problem, Array]:
    """Where a fit begins that ends at the resonance which the recordings show.

    The same problem and point, fitted without it, where they show none or the model has it. What
    was fitted without it is no model to look for it with: that is the nominal one, with any gain.
    """
    left = problem.residuals(z)
    stroke = max(float(np.ptp(recording.measured)) for recording in problem.recordings)
    if GAIN not in problem.free or float(np.std(left)) < LITTLE * stroke:
        return problem, z
    measured = np.concatenate(
        [
            recording.measured[mask] - recording.measured[mask].mean()
            for recording, mask in zip(problem.recordings, problem.masks, strict=True)
        ]
    )
    initial = problem.initial_hysteresis(z)
    least, found = FEWER * float(left @ left), (problem, z)
    for model in _ringing(nominal, problem.longest_period):
        other = replace(problem, model=model)
        said = measured - other.residuals(other.point(model, initial))
        gain = float(said @ measured) / float(said @ said)
        rest = measured - gain * said
        squares = float(rest @ rest)
        if gain > 0.0 and squares < least:
            d = registry()[GAIN[0]].parameter(GAIN[1]).nearest(gain * model.value(*GAIN))
            least, found = squares, (other, other.point(model.with_values({GAIN: d}), initial))
    return found


def _ringing(nominal: Model, sample_period: float) -> Iterator[Model]:
    """Models that ring, each at another frequency, all of which the samples would show."""
    values = nominal.values("second_order")
    own = natural_frequency(values)
    for omega in own * np.geomspace(1.0 / BAND, BAND, GRID):
        if omega > FASTEST * math.pi / sample_period:
            return
        m = values["m"] * (own / float(omega)) ** 2
        b = 2.0 * DAMPING * m * float(omega)
        inside = zip(DYNAMIC, (m, b), strict=True)
        yield nominal.with_values(
            {key: registry()[key[0]].parameter(key[1]).nearest(value) for key, value in inside}
        )
