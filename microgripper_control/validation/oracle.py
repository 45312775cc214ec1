"""What the rig's own law can explain of its recordings, refitted by least squares.

Without an effect, the residual that stays is the effect's gap; with it, what a perfect diagnosis
would reach; with another effect's law in its place, whether the two can be told apart on these
recordings at all. Base parameters stay within half of their nominal values, as a laboratory knows
its parts. Offset and initial hysteresis belong to each recording and are fitted on each, the
held-out ones included; all else is fitted on the training recordings alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from microgripper_control.validation.base import FITTED, Base, Scale
from microgripper_control.validation.block import Array
from microgripper_control.validation.law import Law, Taken
from microgripper_control.validation.least_squares import minimise
from microgripper_control.validation.machine import Applied, Rig

FINITE_STEP = 1e-4  # of a number near one
WIDEST_SHIFT = 30.0  # hundredths of the stroke
MOST_ITERATIONS = 25
ENOUGH = 1e-5


@dataclass(frozen=True)
class Explained:
    """A law refitted: its rms residuals (m) on "training", "heldout" and "all", and its numbers."""

    errors: dict[str, float]
    rig: Rig


def explain(
    recordings: Sequence[Taken],
    scale: Scale,
    noise: float,
    effects: Sequence[Applied] = (),
    base: Base | None = None,
    steps: int | None = None,
    iterations: int = MOST_ITERATIONS,
    enough: float = ENOUGH,
) -> Explained:
    """Refit a law, beginning with the given effects' numbers and `base` (else the nominal one).

    `noise` is the sensor's standard deviation, m. `steps` internal steps a sample; None suits a law
    without effects, which is exact at any. It stops after `iterations`, or where the sum of squares
    falls by less than the share `enough`; with no iterations only what belongs to each recording is
    fitted.
    """
    law = Law(scale, effects, steps, noise)
    vector = law.vector(base or scale.base)
    if iterations:
        training = [taken for taken in recordings if not taken.heldout]
        vector = _fit_law(law, vector, training, noise, iterations, enough)
    left = [
        law.residual(vector, taken, _fit_shift(law, vector, taken, noise)) for taken in recordings
    ]
    return Explained(errors_of(recordings, left), law.rig(vector))


def errors_of(recordings: Sequence[Taken], residuals: Sequence[Array]) -> dict[str, float]:
    """The rms of residuals (m) on the training recordings, the held-out ones, and all."""
    heldout = [taken.heldout for taken in recordings]
    squares = [residual**2 for residual in residuals]
    parts = {
        "training": [s for s, out in zip(squares, heldout, strict=True) if not out],
        "heldout": [s for s, out in zip(squares, heldout, strict=True) if out],
        "all": squares,
    }
    return {name: float(np.sqrt(np.concatenate(part).mean())) for name, part in parts.items()}


def errors_known(
    recordings: Sequence[Taken], rig: Rig, noise: float, steps: int
) -> dict[str, float]:
    """Errors of the rig's own law with its true numbers; only the offsets are fitted.

    They are the sensor's noise, and more where a converter rounds it (see `Truth`).

    On ten thousand samples a refit of a dozen numbers would change them by less than 0.1 %.
    """
    law = Law(rig.scale, rig.effects, steps, noise)
    return errors_of(recordings, [law.deviation(rig, taken, 0.0) for taken in recordings])


def _fit_law(
    law: Law,
    begin: Array,
    training: Sequence[Taken],
    noise: float,
    iterations: int,
    enough: float,
) -> Array:
    """The law's vector that fits best, with a shift of its own for each recording.

    How the base's numbers and the shifts move the readings is taken from the base alone, which an
    effect changes little and which costs a hundredth.
    """
    count = len(begin)
    ends = np.cumsum([0, *(len(taken.measured) for taken in training)])
    low, high = law.bounds
    wide = np.full(len(training), WIDEST_SHIFT)
    bare = law.bare

    def residual(z: Array) -> Array:
        pairs = zip(training, z[count:], strict=True)
        return np.concatenate([law.residual(z[:count], *pair) for pair in pairs]) / noise

    def jacobian(z: Array, middle: Array) -> Array:
        columns = np.zeros((len(middle), len(z)))
        for j, taken in enumerate(training):
            part = slice(ends[j], ends[j + 1])
            here = bare.residual(z[:count], taken, z[count + j]) / noise
            for i in [*range(count), count + j]:
                moved = z.copy()
                # Back from an upper bound, beyond which the law may not exist.
                over = i < count and z[i] + FINITE_STEP > high[i]
                moved[i] += -FINITE_STEP if over else FINITE_STEP
                own = len(FITTED) <= i < count
                new = (law if own else bare).residual(moved[:count], taken, moved[count + j])
                old = middle[part] if own else here
                columns[part, i] = (new / noise - old) / (moved[i] - z[i])
        return columns

    return minimise(
        residual,
        jacobian,
        np.concatenate([begin, 0.0 * wide]),
        np.concatenate([low, -wide]),
        np.concatenate([high, wide]),
        iterations,
        enough,
    )[:count]


def _fit_shift(law: Law, vector: Array, taken: Taken, noise: float) -> float:
    def residual(z: Array) -> Array:
        return law.residual(vector, taken, float(z[0])) / noise

    def jacobian(z: Array, middle: Array) -> Array:
        return (residual(z + FINITE_STEP) - middle)[:, None] / FINITE_STEP

    wide = np.full(1, WIDEST_SHIFT)
    found = minimise(residual, jacobian, np.zeros(1), -wide, wide, MOST_ITERATIONS, ENOUGH)
    return float(found[0])
