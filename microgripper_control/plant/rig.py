"""A rig: the plant behind a DAC and an ADC that share one clock."""

from __future__ import annotations

import math

from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Plant


class Rig:
    """Takes commands whenever they come and samples once a tick; begins at a voltage, V, at rest.

    At tick k it reads `position` x[k] (m) and `velocity` (x[k] - x[k-1])/T (m/s), latches the
    newest command as `voltage` u[k] (V) and holds it until the next tick. The DAC's range is that
    of the model: commands beyond it are clipped and counted in `clipped`; those that are not finite
    are ignored and counted in `refused`.
    """

    def __init__(self, model: Model, sample_period: float, initial_voltage: float = 0.0) -> None:
        self._low, self._high = model.voltage_range
        self._period = sample_period
        self._command = min(max(initial_voltage, self._low), self._high)
        self._plant = Plant(model, sample_period, self._command)
        self._before = math.nan
        self.position = self.velocity = 0.0
        self.voltage = self._command
        self.clipped = self.refused = 0

    def command(self, voltage: float) -> None:
        """Take a voltage command, V, for the next tick; the newest one counts."""
        if not math.isfinite(voltage):
            self.refused += 1
            return
        if self._low <= voltage <= self._high:
            self._command = voltage
        else:
            self._command = self._low if voltage < self._low else self._high
            self.clipped += 1

    def tick(self) -> None:
        """Sample, and let one sample period pass."""
        x = self._plant.read()
        self.velocity = 0.0 if math.isnan(self._before) else (x - self._before) / self._period
        self.position = self._before = x
        self.voltage = self._command
        self._plant.write(self.voltage)

    def miss(self) -> None:
        """Let a tick pass that was slept through: the held voltage stays on.

        A command that came meanwhile waits for the next tick: whoever fills in the missing samples
        can only know the voltage of the last one.
        """
        self._before = self._plant.read()
        self._plant.write(self.voltage)
