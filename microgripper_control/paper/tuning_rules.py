"""Ziegler and Nichols' rules and stability margins on the linear plant, by python-control.

Two loops: the continuous plant alone, and the one that runs: sampled, held, and with one tick until
an answer is applied. Source of the rules: Ziegler and Nichols, Trans. ASME 64 (1942) 759.
"""

from __future__ import annotations

import math

import control
import numpy as np

from microgripper_control.control.identified import Identified
from microgripper_control.control.linearised import Linearised
from microgripper_control.control.pid import PidGains
from microgripper_control.control.tuning import Margins
from microgripper_control.core.signals import Array
from microgripper_control.paper.linear_plant import state_space

UNSTABLE = Margins(0.0, 0.0, 0.0)
GRID = 600  # frequencies up to half the sampling rate
LOWEST = 1e-2  # rad/s


def ideal_gains(kp: float, ki: float, kd: float) -> PidGains:
    """Equation (16) in V/m, V/(m s), V s/m: an unfiltered derivative, of the error."""
    return PidGains(kp, ki, kd, derivative_filter=0.0, derivative_on_measurement=False)


def sampled_loop(
    identified: Identified, linear: Linearised, sample_period: float
) -> control.StateSpace:
    """The linear plant, V to m, under a zero-order hold, its input applied one tick later."""
    plant = control.sample_system(
        state_space(identified, linear, flexure=True), sample_period, "zoh"
    )
    late = control.ss([[0.0]], [[1.0]], [[1.0]], [[0.0]], sample_period)
    return control.series(late, plant)


def controller_in_z(gains: PidGains, sample_period: float) -> control.StateSpace:
    """Equation (16) as `control.pid` runs it, m to V: backward differences, filtered derivative."""
    lag = gains.derivative_filter
    filtered = [lag + sample_period, -lag]
    summed = [1.0, -1.0]
    above = np.polyadd(
        np.polymul([gains.kp + gains.ki * sample_period, -gains.kp], filtered),
        gains.kd * np.polymul(summed, summed),
    )
    return control.ss(control.tf(above, np.polymul(summed, filtered), sample_period))


def sampled_margins(loop: control.StateSpace, gains: PidGains) -> Margins:
    """Gain (factor) and phase (degrees) margin of PID and `sampled_loop`; zeros if unstable."""
    period = float(loop.dt)
    opened = control.series(controller_in_z(gains, period), loop)
    if np.any(np.abs(control.feedback(opened, 1).poles()) >= 1.0):
        return UNSTABLE
    return _margins(*control.stability_margins(_response(opened)))


def continuous_margins(plant: control.StateSpace, gains: PidGains) -> Margins:
    """The same for the ideal PID (16) on a continuous plant, no delay; zeros if unstable."""
    pid = control.tf([gains.kd, gains.kp, gains.ki], [1.0, 0.0])
    opened = pid * control.tf(plant)
    if np.any(control.feedback(opened, 1).poles().real >= 0.0):
        return UNSTABLE
    return _margins(*control.stability_margins(opened))


def _margins(gain: float, phase: float, *others: float) -> Margins:
    """Of what python-control tells: NaN is a frequency that there is not."""
    _, _, crossover, _ = others
    return Margins(float(gain), float(phase), float(np.nan_to_num(crossover)))


def reaction_curve_gains(time: Array, response: Array) -> PidGains:
    """From the unit step response (m/V) at times (s).

    With R the steepest slope and L where its tangent meets zero: Kp = 1.2/(R L), Ti = 2 L,
    Td = L/2.
    """
    slope = np.diff(response) / np.diff(time)
    steepest = int(np.argmax(slope))
    rate = float(slope[steepest])
    lag = float(time[steepest] - response[steepest] / rate)
    kp = 1.2 / (rate * lag)
    return ideal_gains(kp, kp / (2.0 * lag), kp * lag / 2.0)


def ultimate_gains(loop: control.StateSpace, *, derivative: bool = True) -> PidGains:
    """From the gain Ku and the period Tu at which P alone oscillates.

    PID: Kp = 0.6 Ku, Ti = Tu/2, Td = Tu/8; PI: Kp = 0.45 Ku, Ti = Tu/1.2.
    """
    ultimate, _, _, at, *_ = control.stability_margins(_response(loop))
    period = 2.0 * math.pi / float(at)
    if derivative:
        kp = 0.6 * float(ultimate)
        return ideal_gains(kp, kp / (period / 2.0), kp * period / 8.0)
    kp = 0.45 * float(ultimate)
    return ideal_gains(kp, kp / (period / 1.2), 0.0)


def _response(sampled: control.StateSpace) -> control.FrequencyResponseData:
    """L over frequencies up to half the sampling rate.

    From its polynomials margins would be ill-conditioned: the mechanics settles to nine digits
    within a sample.
    """
    return control.frd(sampled, np.geomspace(LOWEST, math.pi / float(sampled.dt), GRID))
