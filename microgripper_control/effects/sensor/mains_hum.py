"""Hum: the mains frequency and its harmonics, coupled into the reading.

    y = x + sum over n = 1, 2, 3 of a_n sin(n (2 pi frequency t + phase))

The second harmonic comes from rectifiers, the third from saturated iron. Nothing fixes the phase
that a recording starts with. Predictions therefore leave the link out, and each recording is given
a sine and a cosine of each harmonic; only the frequency belongs to the rig.
"""

import math
from collections.abc import Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import quantity
from microgripper_control.core.signals import POSITION, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values

AMPLITUDES = ("amplitude", "second", "third")  # of the harmonics 1, 2, 3


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: samples so far."""
    cycles_per_sample, phase = coefficients[0, 0], coefficients[0, 1]
    for j in range(bus.shape[1]):
        cycles = cycles_per_sample * state[0]
        angle = math.tau * (cycles - math.floor(cycles)) + phase
        for n in range(1, coefficients.shape[1] - 1):
            bus[POSITION, j] += coefficients[0, n + 1] * math.sin(n * angle)
        state[0] += 1.0


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """The levels are left alone: a hum has none."""
    row = [values["frequency"] * timing.sample_period, values["phase"]]
    row += [values[name] for name in AMPLITUDES]
    return Prepared(np.array([row]), np.zeros(1), timing.ramped)


def courses(values: Values, time: Array) -> Array:
    """Sine and cosine of each harmonic, shape (6, n); their weights are amplitudes, m."""
    angle = math.tau * values["frequency"] * time
    harmonics = range(1, len(AMPLITUDES) + 1)
    return np.array([wave(n * angle) for n in harmonics for wave in (np.sin, np.cos)])


def observed(values: Values, weights: Array, time: Array) -> Values:
    """Amplitudes, and the phase of the fundamental, from the weights of sines and cosines."""
    sines, cosines = weights[0::2], weights[1::2]
    phase = {"phase": math.atan2(cosines[0], sines[0])}
    return phase | dict(zip(AMPLITUDES, np.hypot(sines, cosines).tolist(), strict=True))


def starts(scales: Scales) -> Sequence[Values]:
    """The mains of Europe and of America, where the sampling shows them."""
    return [{"frequency": line} for line in (50.0, 60.0) if line < 0.5 / scales.sample_period]


def says(values: Values, scales: Scales) -> str:
    return f"the mains hums in the reading, at {quantity(values['frequency'], 'Hz', 3)}"


LINK = Link(
    name="mains_hum",
    stage=Stage.SENSOR,
    order=40,
    title="mains hum",
    source="Fourier series of a signal with the period of the mains; Ott 2009, chapter 2",
    sampled=True,
    random=True,
    parameters=(
        Parameter("frequency", "Hz", 50.0, 10.0, 1000.0, "of the mains"),
        Parameter("amplitude", "m", 5e-8, 0.0, 1e-3, "of the fundamental", 0.0, fitted=False),
        Parameter("second", "m", 1e-8, 0.0, 1e-3, "of the second harmonic", 0.0, fitted=False),
        Parameter("third", "m", 1e-8, 0.0, 1e-3, "of the third harmonic", 0.0, fitted=False),
        Parameter("phase", "rad", 0.0, -7.0, 7.0, "of the fundamental at the start", fitted=False),
    ),
    prepare=prepare,
    kernel=kernel,
    courses=courses,
    observed=observed,
    starts=starts,
    says=says,
)
