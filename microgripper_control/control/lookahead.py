"""Where the setpoint will stand when an answer given now shows in the displacement.

A setpoint is known only up to now; without looking ahead the finger trails it by the loop's delay:
0.44 % rms of peak to peak for a 1 Hz sine at 1 kHz and two ticks. With s1, s2, s3 the last three
differences, the newest first,

    target[k] = r[k] + p median(s1, s2, s3) + (p (p + 1) / 2 + p) minmod(s1 - s2, s2 - s3)

for p ticks ahead. Smooth motion is thereby continued along Newton's backward differences to second
order, since its median is s2. What is not smooth is not continued: minmod, the smaller of two that
agree in sign and else zero (Roe 1986), drops the curvature of corners, steps and late or
repeated samples; the median drops the slope of a step and keeps a ramp's through one late sample.
A ramp that turns is overshot for two ticks.
"""

from __future__ import annotations

import math

from microgripper_control.control import LOOP_DELAY


class Lookahead:
    """Continues a setpoint (m) that arrives once a tick by `ticks` sample periods."""

    def __init__(self, ticks: int = LOOP_DELAY) -> None:
        self._slope_weight = ticks
        self._bend_weight = ticks * (ticks + 1) / 2 + ticks
        self.reset()

    def reset(self) -> None:
        """Forget the past: the next setpoint is taken as one that was held."""
        self._last = math.nan
        self._slope = 0.0
        self._bend = 0.0

    def step(self, setpoint: float) -> float:
        """The setpoint expected `ticks` from now, m; `setpoint` must be finite."""
        slope = 0.0 if math.isnan(self._last) else setpoint - self._last
        bend = slope - self._slope
        oldest = self._slope - self._bend
        middle = _median(slope, self._slope, oldest)
        steady = 0.0
        if bend * self._bend > 0.0:
            steady = bend if abs(bend) < abs(self._bend) else self._bend
        self._last, self._slope, self._bend = setpoint, slope, bend
        return setpoint + self._slope_weight * middle + self._bend_weight * steady


def _median(a: float, b: float, c: float) -> float:
    if a > b:
        a, b = b, a
    return a if c < a else b if c > b else c
