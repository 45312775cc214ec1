"""Discrete PID with filtered derivative, bounded output and anti-windup.

    u[k] = kp e[k] + I[k] + D[k]
    I[k] = I[k-1] + ki T e[k]
    D[k] = (Tf D[k-1] + kd (y[k] - y[k-1])) / (Tf + T)

with T the sample period (in D the time since the last sample: longer where some were lost), Tf the
filter's time constant and y the error, or minus the measurement so that a jump of the setpoint does
not kick; all by backward differences. At ki = 0 nothing would ever take out what a take-over
without a jump has put into I: it fades.
Source: Astrom and Hagglund, Advanced PID Control, 2006, chapter on implementation.

Anti-windup is conditional integration (same, chapter 3; `conditional_integration` in ros-controls'
control_toolbox): an error that pushes the output beyond a bound is integrated up to the bound and
no further. To stop short of it would halt for good where the bound is a rate and the increment of
one sample exceeds it. I and D are bounded besides by `authority`, so that a wild sample is
forgotten soon.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from microgripper_control.control.declared import Declared, declared

FADING = 0.5  # s, time constant of I without integral action


@dataclass(frozen=True)
class PidGains(Declared):
    """Gains from displacement (m) to voltage (V); MicrogripperError names one out of range.

    The defaults are `tuning.default_gains` of the paper's actuator at 1 kHz.
    """

    kp: float = declared("V/m", 0.0, 0.0, 1e12, "proportional gain")
    ki: float = declared("V/(m*s)", 2.345e9, 0.0, 1e16, "integral gain")
    kd: float = declared("V*s/m", 0.0, 0.0, 1e9, "derivative gain")
    derivative_filter: float = declared(
        "s", 0.002, 0.0, 10.0, "time constant of the derivative's low-pass; 0 for none"
    )
    derivative_on_measurement: bool = True


class Pid:
    """One PID loop, stepped once a sample period (s). `authority` (V) bounds |I| and |D|."""

    def __init__(self, gains: PidGains, sample_period: float, authority: float = math.inf) -> None:
        self._period = sample_period
        self._authority = authority
        self._kept = math.exp(-sample_period / FADING)  # of I after a sample, if ki = 0
        self._error = 0.0
        self._signal = math.nan  # y[k-1]; none yet
        self._lost = 0  # samples since then
        self._derivative = 0.0  # D, V
        self.integral = 0.0  # I, V
        self.output = 0.0  # V, after bounding
        self.bounded = False  # whether the last output was
        self._gains = gains

    @property
    def gains(self) -> PidGains:
        """The gains at work."""
        return self._gains

    def change_gains(self, gains: PidGains) -> None:
        """Change the gains without a jump: I takes over what P and D would have jumped by.

        With ki = 0 that amount fades.
        """
        old = self._gains
        begins = gains.derivative_on_measurement != old.derivative_on_measurement or old.kd == 0.0
        derivative = 0.0 if begins else self._bound(self._derivative * gains.kd / old.kd)
        proportional = (old.kp - gains.kp) * self._error
        self.integral = self._bound(self.integral + proportional + self._derivative - derivative)
        self._derivative = derivative
        if gains.derivative_on_measurement != old.derivative_on_measurement:
            self._signal = math.nan
        self._gains = gains

    def step(
        self, error: float, measurement: float, low: float = -math.inf, high: float = math.inf
    ) -> float:
        """The output, V, within `low` .. `high`, for an error and a measurement, m.

        Where a sample is not finite, the last output is held and the state kept.
        """
        g = self._gains
        signal = -measurement if g.derivative_on_measurement else error
        derivative = self._differentiate(signal) if g.kd else 0.0
        kept = 1.0 if g.ki else self._kept
        integral = self._bound(kept * self.integral + g.ki * self._period * error)
        output = g.kp * error + integral + derivative
        if not math.isfinite(output):
            self.lose(1)
            self.bounded = not low <= self.output <= high
            self.output = min(max(self.output, low), high)
            return self.output
        above, below = output > high, output < low
        if above and integral > self.integral:
            integral = max(self.integral, integral - (output - high))
        elif below and integral < self.integral:
            integral = min(self.integral, integral + (low - output))
        self._error, self._signal, self._lost = error, signal, 0
        self._derivative, self.integral = derivative, integral
        self.bounded = above or below
        self.output = high if above else low if below else output
        return self.output

    def lose(self, samples: int) -> None:
        """Say that so many samples did not come: what moved meanwhile did so in their time, too."""
        self._lost += samples

    def join(self, output: float, error: float, measurement: float) -> float:
        """Take over from another controller: set I so that the answer to this sample is `output`.

        With finite samples the derivative starts from zero here. Returns the output, V, which
        differs from the one wanted only where the authority does not suffice.
        """
        if not (math.isfinite(error) and math.isfinite(measurement)):
            error, self._signal = 0.0, math.nan
        else:
            self._signal = -measurement if self._gains.derivative_on_measurement else error
        self._error, self._derivative, self._lost, self.bounded = error, 0.0, 0, False
        proportional = self._gains.kp * error
        self.integral = self._bound(output - proportional)
        self.output = proportional + self.integral
        return self.output

    def _differentiate(self, signal: float) -> float:
        g = self._gains
        if math.isnan(self._signal):
            return 0.0
        lag, passed = g.derivative_filter, (1 + self._lost) * self._period
        change = g.kd * (signal - self._signal)
        return self._bound((lag * self._derivative + change) / (lag + passed))

    def _bound(self, voltage: float) -> float:
        most = self._authority
        return -most if voltage < -most else most if voltage > most else voltage
