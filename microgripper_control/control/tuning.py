"""Default PID gains by a stated rule, and the margins that any gains leave.

The loop, sampled: PID, one tick until the answer is applied, and the mechanics under a zero-order
hold, which shows at the next tick; then the delays and lags of drive and sensor, as one dead time
of whole ticks. For a plant that settles within a sample the loop gain of pure integral action is
g / (z^(1 + N) (z - 1)) with g = K ki T and N ticks of dead time.

A mode G behind mechanics that are fast against it adds K (G - 1) to the plant. At w the
integrator's gain is ki T / |z - 1| with |z - 1| = 2 |sin(w T / 2)|, and the hold's is
|sin(w T / 2)| / (w T / 2): together ki / w, above half the sampling rate too. So L moves by at most
K ki `ringing`. In what direction is not known: within the peak the phase turns by half a circle,
and the delays are known to a tick only.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from microgripper_control.control.identified import Identified
from microgripper_control.control.pid import PidGains
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array

# Skogestad's SIMC rule (J. Process Control 13, 2003) for a static plant with dead time theta: pure
# integral action, K ki = 1 / (2 theta). A sampled integrator takes effect half a sample late and
# the answer one sample: theta = 1.5 T and the dead time.
SAMPLES_LATE = 1.5
ACTING = ("kp", "ki", "kd")  # the gains without any of which a loop does nothing
GAIN_ERROR = 1.2  # the plant's gain may be this much larger than identified
LEAST_GAIN_MARGIN = 2.0
LEAST_PHASE_MARGIN = 45.0  # degrees
MOST_REDUCTIONS = 150  # of the gain, to 1e-7 of the rule's
WHOLE = 1e-6  # of a tick: a dead time that is so little longer is none longer
FREQUENCIES = 20_000  # from zero to half the sampling rate,
FINER = 8  # or so many for each tick of dead time: the loop turns by half a circle with each


@dataclass(frozen=True)
class Margins:
    """How far a stable loop is from its limit; zero for one that is unstable."""

    gain: float  # factor
    phase: float  # degrees
    crossover: float  # rad/s: where |L| = 1 with that phase; 0 if nowhere


@lru_cache(maxsize=1)  # it takes milliseconds, in which a running loop would wait
def default_gains(identified: Identified, sample_period: float) -> PidGains:
    """Integral gain by the SIMC rule, lowered until the margins hold.

    A piezo settles within a sample, so that proportional and derivative action have nothing to
    act on and only pass noise. Where it does not settle, a resonance limits ki; where it answers
    late, its dead time does; where a mode rings behind the mechanics, its `ringing` does. The
    margins, 2 and 45 degrees, hold also for a plant whose gain is 20 % higher than identified.
    Raises MicrogripperError where nothing damps the resonance.
    """
    late = SAMPLES_LATE * sample_period + identified.dead_time
    ki = 1.0 / (2.0 * max(late, identified.ringing) * identified.gain)
    for _ in range(MOST_REDUCTIONS):
        gains = PidGains(kp=0.0, ki=ki, kd=0.0)
        raised = GAIN_ERROR * identified.gain * ki * identified.ringing
        margins = loop_margins(identified, gains, sample_period, GAIN_ERROR)
        if _enough(margins, raised):
            return gains
        ki *= 0.9
    raise MicrogripperError(
        f"identified: second_order: b = {identified.b:g} N*s/m: no integral gain keeps the "
        "margins; give gains"
    )


def gains_for(identified: Identified, sample_period: float, asked: Mapping[str, Any]) -> PidGains:
    """The gains asked for, fields of PidGains by name, and beside them what suits the plant.

    Raises MicrogripperError for a gain out of range, or where none suit and none are asked for.
    """
    try:
        suited = default_gains(identified, sample_period)
    except MicrogripperError:
        if not any(asked.get(name) for name in ACTING):
            raise
        suited = PidGains(ki=0.0)
    return replace(suited, **asked)


def _enough(margins: Margins, raised: float) -> bool:
    """Whether the margins hold where L may be off by up to `raised`, < 2, in any direction."""
    turned = math.degrees(2.0 * math.asin(0.5 * raised))
    room = 1.0 / LEAST_GAIN_MARGIN - raised  # for L on the negative real axis
    return margins.gain * room >= 1.0 and margins.phase >= LEAST_PHASE_MARGIN + turned


def loop_margins(
    identified: Identified, gains: PidGains, sample_period: float, plant_factor: float = 1.0
) -> Margins:
    """Gain and phase margin of the sampled loop; the plant's gain is K times `plant_factor`.

    The plant without hysteresis, that is with its largest gain, and without `ringing`. Infinite
    where the loop gain never crosses.
    """
    numerator, denominator = _loop(identified, gains, sample_period)
    ticks = 1 + math.ceil(identified.dead_time / sample_period - WHOLE)
    # The first lies at zero, the margins between the others.
    frequency = math.pi * np.linspace(0.0, 1.0, 1 + max(FREQUENCIES, FINER * ticks))
    z = np.exp(1j * frequency)
    above = plant_factor * np.polyval(numerator, z)
    below = np.polyval(denominator, z) * np.exp(1j * ticks * frequency)
    if not _all_inside(above + below, len(denominator) - 1 + ticks):
        return Margins(0.0, 0.0, 0.0)
    loop = above[1:] / below[1:]
    phase, crossover = _phase_margin(loop, frequency[1:] / sample_period)
    return Margins(_gain_margin(loop), phase, crossover)


def _all_inside(values: NDArray[np.complex128], degree: int) -> bool:
    """Whether all roots of a real polynomial lie inside the unit circle.

    `values` are taken along the upper half of it, from 1 to -1: they turn by half a circle for each
    root inside (the argument principle). To solve for roots takes the cube of the degree, which is
    the dead time in ticks.
    """
    turned = np.unwrap(np.angle(values))
    return bool(round((turned[-1] - turned[0]) / math.pi) == degree)


def _loop(identified: Identified, gains: PidGains, sample_period: float) -> tuple[Array, Array]:
    """Numerator and denominator of the loop in z, PID and mechanics, without what is only late."""
    plant, plant_poles = _sampled_mechanics(identified, sample_period)
    lag = gains.derivative_filter
    filtered = np.array([lag + sample_period, -lag])
    integrated = np.array([1.0, -1.0])
    if gains.ki == 0.0:  # an integrator that nothing feeds is none
        controller, poles = np.polyadd(gains.kp * filtered, gains.kd * integrated), filtered
    else:
        controller = np.polyadd(
            np.polymul([gains.kp + gains.ki * sample_period, -gains.kp], filtered),
            gains.kd * np.polymul(integrated, integrated),
        )
        poles = np.polymul(integrated, filtered)
    above = np.polymul(controller, plant)
    below = np.polymul(poles, plant_poles)
    return np.asarray(above, np.float64), np.asarray(below, np.float64)


def _sampled_mechanics(v: Identified, sample_period: float) -> tuple[Array, Array]:
    """Numerator and denominator in z from held voltage to displacement, without hysteresis.

    By the matrix exponential with time in natural periods. scipy.signal has this too, but takes
    0.4 s to import, at every start of a controller.
    """
    omega = math.sqrt((v.k + v.k_s) / v.m)
    span, gain = omega * sample_period, v.k * v.d / (v.k + v.k_s)
    system = np.zeros((3, 3))  # x, v / omega, u
    system[0, 1] = span
    system[1] = -span, -v.b / (v.m * omega) * span, gain * span
    (a, b, p), (c, d, q), _ = expm(system)
    return np.array([p, b * q - d * p]), np.array([1.0, -(a + d), a * d - b * c])


def _gain_margin(loop: NDArray[np.complex128]) -> float:
    """1/|L| where L crosses the negative real axis inside the unit circle, the smallest."""
    before, after = loop[:-1], loop[1:]
    crosses = np.signbit(before.imag) != np.signbit(after.imag)
    crosses &= before.imag != after.imag  # from -0 to 0 it is real, and crosses nothing
    share = before.imag[crosses] / (before.imag - after.imag)[crosses]
    real = before.real[crosses] + share * (after - before).real[crosses]
    real = np.append(real, loop[-1].real)  # at half the sampling rate L is real
    real = real[(real < 0.0) & (real > -1.0)]
    return float(1.0 / -real.min()) if len(real) else math.inf


def _phase_margin(loop: NDArray[np.complex128], frequency: Array) -> tuple[float, float]:
    """Angle between L and the negative real axis, degrees, where |L| = 1, the smallest; where."""
    size = np.abs(loop)
    at = np.flatnonzero((size[:-1] > 1.0) != (size[1:] > 1.0))
    if not len(at):
        return math.inf, 0.0
    share = np.log(size[at]) / np.log(size[at] / size[at + 1])
    angle = np.degrees(np.abs(np.angle(-(loop[at] + share * (loop[at + 1] - loop[at])))))
    crossing = frequency[at] + share * (frequency[at + 1] - frequency[at])
    least = int(np.argmin(angle))
    return float(angle[least]), float(crossing[least])
