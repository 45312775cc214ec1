"""What belongs to a recording and not to the rig: its displacement zero and its initial hysteresis.

No input explains them, so they are fitted wherever a model is compared with a recording. The zero
enters linearly and is solved for exactly; the initial h is found by a few Gauss-Newton steps.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Hold, Initial, simulate

Mask = NDArray[np.bool_]

BLOCKS = 10
GAUSS_NEWTON_STEPS = 4
PROBE = 1e-3  # of the largest h: the finite difference for its influence


@dataclass(frozen=True)
class Conditions:
    """How a recording was made: the voltage between samples and the state it starts in."""

    hold: Hold = Hold.ZERO
    initial: Initial = Initial.FIRST_SAMPLE

    @property
    def knows_initial_hysteresis(self) -> bool:
        """Whether h at the first sample follows from the conditions."""
        return self.initial is not Initial.FIRST_SAMPLE

    @property
    def unanswered(self) -> int:
        """How many first samples answer to a voltage from before the recording.

        Under a zero-order hold x[0] answers to u[-1], which is known only from rest or a period.
        """
        return int(self.hold is Hold.ZERO and self.initial is Initial.FIRST_SAMPLE)


@dataclass(frozen=True)
class Nuisance:
    """One recording's own values, m."""

    offset: float = 0.0
    initial_hysteresis: float = 0.0


def response(model: Model, recording: Recording, conditions: Conditions, h: float) -> Array:
    """The model's displacement for a recording's voltage, m, shape (n,), before the offset."""
    return simulate(
        model,
        recording.voltage,
        recording.sample_period,
        hold=conditions.hold,
        initial=conditions.initial,
        initial_hysteresis=h,
    )


def predict(
    model: Model, recording: Recording, conditions: Conditions, nuisance: Nuisance
) -> Array:
    """The model's prediction of a recording's displacement, m, shape (n,)."""
    free = response(model, recording, conditions, nuisance.initial_hysteresis)
    return free + nuisance.offset


def largest_hysteresis(model: Model, recording: Recording) -> float:
    """A generous bound on |h|, m: what the recording's travel from zero could build up."""
    d, alpha = model.value("bouc_wen", "d"), model.value("bouc_wen", "alpha")
    return 3.0 * alpha * d * float(np.max(np.abs(recording.voltage)))


def fit_nuisance(
    model: Model,
    recording: Recording,
    conditions: Conditions,
    used: Mask | None = None,
    start: Nuisance | None = None,
) -> Nuisance:
    """Least-squares nuisance values on the samples `used` (shape (n,), all if None).

    Deterministic: a fixed number of steps from a fixed start, so whoever repeats it gets the same.
    """
    measured = recording.measured
    mask = np.ones(len(recording), bool) if used is None else used.copy()
    mask[: conditions.unanswered] = False
    found = start or Nuisance()
    offset_frozen = "sensor_zero" in model.settings
    bound = largest_hysteresis(model, recording)
    if not conditions.knows_initial_hysteresis and bound > 0.0:
        for _ in range(GAUSS_NEWTON_STEPS):
            h = found.initial_hysteresis
            base = response(model, recording, conditions, h)
            probe = PROBE * bound
            slope = (response(model, recording, conditions, h + probe) - base)[mask] / probe
            error = (measured - base)[mask]
            if not offset_frozen:
                slope, error = slope - slope.mean(), error - error.mean()
            power = float(slope @ slope)
            step = float(slope @ error) / power if power > 0.0 else 0.0
            h = min(bound, max(-bound, h + step))
            found = replace(found, initial_hysteresis=h)
    if offset_frozen:
        return found
    base = response(model, recording, conditions, found.initial_hysteresis)
    return replace(found, offset=float(np.mean((measured - base)[mask])))


def blocks(length: int, odd: bool) -> Mask:
    """Samples in blocks 1, 3, 5, 7, 9 (`odd`) or 2, 4, 6, 8, 10 of ten equal ones."""
    number = np.arange(length) * BLOCKS // length
    chosen: Mask = number % 2 == (0 if odd else 1)
    return chosen


def heldout_prediction(
    model: Model, recording: Recording, conditions: Conditions
) -> tuple[Array, Mask]:
    """Prediction of a held-out recording and the samples on which its error counts.

    Only the nuisance values are fitted, on the odd blocks; errors are taken on the even ones.
    """
    nuisance = fit_nuisance(model, recording, conditions, blocks(len(recording), odd=True))
    prediction = predict(model, recording, conditions, nuisance)
    return prediction, blocks(len(recording), odd=False)
