"""Hum: the mains frequency and its harmonics, coupled into the reading.

    y = x + sum over n = 1, 2, 3, 5 of a_n sin(n (2 pi frequency t + phase))

The second harmonic comes from rectifiers, the third from saturated iron, the fifth from the
three-phase rectifiers of drives. Nothing fixes the phase that a recording starts with, and it does
not stay: a grid's frequency wanders by some hundredths of a hertz, and what couples it in changes
with every load switched. Predictions therefore leave the link out, and each recording is given its
own slowly changing amplitude and phase of each harmonic,

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

HARMONICS = {"amplitude": 1, "second": 2, "third": 3, "fifth": 5}  # parameter: which it is
HALF_WAVE = 4.0  # s, about the shortest of an envelope
MOST_HALF_WAVES = 4  # in a recording: more run away where they are not fitted, and take longer
CLEAR = 2.5  # cycles in a recording between two lines that are told apart
FOLDING = 3  # the highest harmonic, of those that are not far smaller than the first
BESIDE = (-0.08, -0.04, 0.04, 0.08)  # Hz


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: samples so far."""
    cycles_per_sample, phase = coefficients[0, 0], coefficients[0, 1]
    for j in range(bus.shape[1]):
        cycles = cycles_per_sample * state[0]
        angle = math.tau * (cycles - math.floor(cycles)) + phase
        for at in range(2, coefficients.shape[1], 2):
            bus[POSITION, j] += coefficients[0, at + 1] * math.sin(coefficients[0, at] * angle)
        state[0] += 1.0


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """The levels are left alone: a hum has none."""
    row = [values["frequency"] * timing.sample_period, values["phase"]]
    for name, n in HARMONICS.items():
        row += [float(n), values[name]]
    return Prepared(np.array([row]), np.zeros(1), timing.ramped)


def envelopes(time: Array) -> Array:
    """How fast amplitudes and phases may change, shape (K + 1, n): half a cosine wave, two, ..."""
    last = float(time[-1]) if len(time) > 1 else 0.0
    count = min(MOST_HALF_WAVES, math.ceil(last / HALF_WAVE))
    course = math.pi * time / (last or 1.0)
    return np.array([np.cos(k * course) for k in range(count + 1)])


def shown(values: Values, time: Array) -> dict[str, int]:
    """The harmonics that a recording tells apart, beside the fundamental.

    The sampling folds what is above half its rate back: from 200 Hz the third harmonic of 50.00 Hz
    lies on the first, that of 50.05 Hz 0.2 Hz below it.
    """
    step = float(time[1] - time[0]) if len(time) > 1 else 1.0
    clear = CLEAR / (step * len(time))
    lines: dict[str, float] = {}
    for name, n in HARMONICS.items():
        line = folded(n * values["frequency"], step)
        if n == 1 or (
            _is_clear(line, step, clear) and all(abs(line - f) > clear for f in lines.values())
        ):
            lines[name] = line
    return {name: HARMONICS[name] for name in lines}


def folded(frequency: float, step: float) -> float:
    """Where the line of a frequency shows, Hz, if a sample is taken every `step`, s."""
    cycles = frequency * step
    return abs(cycles - round(cycles)) / step


def _is_clear(line: float, step: float, clear: float) -> bool:
    """Whether a line and its image in zero, or in half the rate, are `clear`, Hz, apart."""
    return 2.0 * min(line, 0.5 / step - line) > clear


def courses(values: Values, time: Array) -> Array:
    """Sine and cosine of each harmonic that shows in each envelope; the weights are amplitudes, m.

    Harmonics that lie on a lower one are left out: the weights would not be determined.
    """
    angle = math.tau * values["frequency"] * time
    slow = envelopes(time)
    waves = [wave(n * angle) for n in shown(values, time).values() for wave in (np.sin, np.cos)]
    return np.concatenate([slow * wave for wave in waves])


def observed(values: Values, weights: Array, time: Array) -> Values:
    """Amplitudes, root mean square over the recording, and the phase that the fundamental has."""
    slow = envelopes(time)
    quadratures = weights.reshape(-1, 2, len(slow))
    sizes = np.sqrt(np.mean(np.sum((quadratures @ slow) ** 2, axis=1), axis=1))
    phase = {"phase": math.atan2(quadratures[0, 1, 0], quadratures[0, 0, 0])}
    found = dict(zip(shown(values, time), sizes.tolist(), strict=True))
    return phase | dict.fromkeys(HARMONICS, 0.0) | found


def starts(scales: Scales) -> Sequence[Values]:
    """The mains of Europe and of America, where the sampling shows them.

    Also beside them where the sampling folds harmonics into lines all around.
    """
    step, clear = scales.sample_period, CLEAR / scales.duration
    tried = []
    for mains in (50.0, 60.0):
        highest = 0.5 / step / mains
        tried += [mains + away for away in ((0.0,) if highest > FOLDING else (0.0, *BESIDE))]
    return [{"frequency": f} for f in tried if _is_clear(folded(f, step), step, clear)]


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
        Parameter("frequency", "Hz", 50.0, 10.0, 1000.0, "frequency of the mains"),
        Parameter(
            "amplitude", "m", 5e-8, 0.0, 1e-3, "amplitude of the fundamental", 0.0, fitted=False
        ),
        Parameter(
            "second", "m", 1e-8, 0.0, 1e-3, "amplitude of the second harmonic", 0.0, fitted=False
        ),
        Parameter(
            "third", "m", 1e-8, 0.0, 1e-3, "amplitude of the third harmonic", 0.0, fitted=False
        ),
        Parameter(
            "fifth", "m", 0.0, 0.0, 1e-3, "amplitude of the fifth harmonic", 0.0, fitted=False
        ),
        Parameter(
            "phase", "rad", 0.0, -7.0, 7.0, "phase of the fundamental at the start", fitted=False
        ),
    ),
    prepare=prepare,
    kernel=kernel,
    courses=courses,
    observed=observed,
    starts=starts,
    says=says,
)
