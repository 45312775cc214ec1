"""Hum: the mains frequency and its harmonics, coupled into the reading.

    y = x + sum over n = 1, 2, 3 of a_n sin(n (2 pi frequency t + phase))

The second harmonic comes from rectifiers, the third from saturated iron. Nothing fixes the phase
that a recording starts with, and it does not stay: a grid's frequency wanders by some hundredths of
a hertz, and what couples it in changes with every load switched. Predictions therefore leave the
link out, and each recording is given its own slowly changing amplitude and phase of each harmonic,

    sum over k = 0 ... K of (p_nk sin + q_nk cos)(2 pi n frequency t) cos(pi k t / T),

T long: a cosine series, whose ends lie flat, runs better past them and through a tenth that was not
fitted than a polynomial does. Only the frequency, about which it wanders, belongs to the rig.
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
HALF_WAVE = 4.0  # s, about the shortest of an envelope
UNFOLDED = 0.45  # cycles a sample: the highest harmonic that is looked for beside the fundamental
MOST_HALF_WAVES = 4  # in a recording: more run away where they are not fitted, and take longer


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


def envelopes(time: Array) -> Array:
    """How fast amplitudes and phases may change, shape (K + 1, n): half a cosine wave, two, ..."""
    last = float(time[-1]) if len(time) > 1 else 0.0
    count = min(MOST_HALF_WAVES, math.ceil(last / HALF_WAVE))
    course = math.pi * time / (last or 1.0)
    return np.array([np.cos(k * course) for k in range(count + 1)])


def courses(values: Values, time: Array) -> Array:
    """Sine and cosine of each harmonic in each envelope; their weights are amplitudes, m.

    Harmonics that the sampling folds back are left out: they would meet the lower ones there.
    """
    angle = math.tau * values["frequency"] * time
    step = float(time[1] - time[0]) if len(time) > 1 else 0.0
    harmonics = range(1, len(AMPLITUDES) + 1)
    seen = [n for n in harmonics if n == 1 or n * values["frequency"] * step < UNFOLDED]
    slow = envelopes(time)
    waves = [wave(n * angle) for n in seen for wave in (np.sin, np.cos)]
    return np.concatenate([slow * wave for wave in waves])


def observed(values: Values, weights: Array, time: Array) -> Values:
    """Amplitudes, root mean square over the recording, and the phase that the fundamental has."""
    slow = envelopes(time)
    quadratures = weights.reshape(-1, 2, len(slow))
    sizes = np.zeros(len(AMPLITUDES))
    sizes[: len(quadratures)] = np.sqrt(np.mean(np.sum((quadratures @ slow) ** 2, axis=1), axis=1))
    phase = {"phase": math.atan2(quadratures[0, 1, 0], quadratures[0, 0, 0])}
    return phase | dict(zip(AMPLITUDES, sizes.tolist(), strict=True))


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
    source="Fourier series with the period of the mains; Ott 2009, chapter 2; ENTSO-E (wander)",
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
