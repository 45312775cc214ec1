"""Section 9, fig. 16 and 17: the linearised model as an open-loop controller.

The voltage for a required displacement by the linearised model, that voltage on the nonlinear
plant, and the displacement that results. The paper says that its slope is one. k2 belongs to one
drive frequency, so the same is done with setpoints slower and faster than the one of the fit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microgripper_control.control.feedforward import InverseKind, make_inverse
from microgripper_control.control.identified import Identified
from microgripper_control.control.linearised import Linearised
from microgripper_control.core.signals import Array
from microgripper_control.paper import printed
from microgripper_control.paper.agreement import Row, Table
from microgripper_control.paper.behaviour import at_rest
from microgripper_control.paper.experiment import (
    FREQUENCY,
    drive,
)
from microgripper_control.paper.inverse_fit import inverse_voltages
from microgripper_control.paper.linearised import SAMPLES_PER_CYCLE
from microgripper_control.paper.setpoint import Tracking, approached_sine, tracking_error
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

FREQUENCIES = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)  # Hz, of the setpoint
SECTION = "9, fig. 17"
LINEARISED, EXACT, LINE = "linearised model", "exact inverse", "straight line, no compensation"


@dataclass(frozen=True)
class Steering:
    """One way to find the voltage, tried at one frequency; arrays are from the sine on."""

    frequency: float  # Hz
    required: Array  # m
    voltage: Array  # V
    resulting: Array  # m
    error: Tracking  # % of peak to peak

    @property
    def slope(self) -> float:
        """Of the least-squares line of the resulting over the required displacement."""
        return float(np.polyfit(self.required, self.resulting, 1)[0])


@dataclass(frozen=True)
class OpenLoopResult:
    """Ways by name at the frequency of the fit, and the linearised one at all frequencies."""

    ways: dict[str, Steering]
    sweep: tuple[Steering, ...]

    def rows(self) -> list[Row]:
        """Slope and largest deviation."""
        found = self.ways[LINEARISED]
        worst = max(self.sweep, key=lambda steering: steering.error.largest)
        return [
            Row(
                SECTION,
                "slope, resulting over required displacement",
                "1",
                found.slope,
                printed.SLOPE,
                f"k1, k2 fitted at the setpoint's own frequency, {found.frequency:g} Hz",
            ),
            Row(
                SECTION,
                "largest deviation",
                "% of p-p",
                found.error.largest,
                remark="the paper: slight deviations only",
                form=".2f",
            ),
            Row(
                SECTION,
                f"largest deviation at {worst.frequency:g} Hz",
                "% of p-p",
                worst.error.largest,
                remark=f"k1, k2 still those of {found.frequency:g} Hz; slope {worst.slope:.3f}",
                form=".2f",
            ),
            Row(
                SECTION,
                "largest deviation without any compensation",
                "% of p-p",
                self.ways[LINE].error.largest,
                form=".2f",
            ),
        ]

    def table(self) -> Table:
        """Slope and deviation of each way and frequency."""
        rows = [
            (
                name,
                f"{s.frequency:g}",
                f"{s.slope:.4f}",
                f"{s.error.rms:.2f}",
                f"{s.error.largest:.2f}",
            )
            for name, s in [*self.ways.items(), *((LINEARISED, s) for s in self.sweep)]
        ]
        return Table(
            "Open loop",
            ("voltage from", "setpoint, Hz", "slope", "deviation, % rms of p-p", "largest, %"),
            rows,
        )


def calibrated_gain(plant: Model) -> float:
    """m/V: the straight line x = gain u through zero that fits the experiment of section 5 best.

    What steers an actuator whose hysteresis is not compensated.
    """
    voltage = drive(plant)
    return float(voltage @ at_rest(plant, voltage) / (voltage @ voltage))


def steer(
    plant: Model, name: str, linear: Linearised, reach: tuple[float, float], frequency: float
) -> Steering:
    """Find the voltage for a sine (Hz) between two displacements (m) and apply it to the plant.

    `name` says how: (4) with (7) inverted, (4) with (3) inverted, or x = gain u.
    """
    period = 1.0 / (frequency * SAMPLES_PER_CYCLE)
    setpoint, start = approached_sine(reach, frequency, 3, period)
    identified = Identified.of(plant)
    if name == LINEARISED:
        voltage = linear.voltage(identified, setpoint, period)
    elif name == EXACT:
        limits = identified.voltage_range
        inverse = make_inverse(InverseKind.EXACT, identified, limits, period)
        voltage = inverse_voltages(inverse, setpoint)
    else:
        voltage = setpoint / calibrated_gain(plant)
    voltage = np.clip(voltage, *plant.voltage_range)
    resulting = simulate(plant, np.append(voltage, voltage[-1]), period)[1:]
    required, voltage, resulting = setpoint[start:], voltage[start:], resulting[start:]
    error = tracking_error(required, resulting)
    return Steering(frequency, required, voltage, resulting, error)


def reproduce_open_loop(
    plant: Model, linear: Linearised, reach: tuple[float, float]
) -> OpenLoopResult:
    """Steer by the linearised model, by the exact inverse and by a straight line."""
    ways = {
        name: steer(plant, name, linear, reach, FREQUENCY) for name in (LINEARISED, EXACT, LINE)
    }
    sweep = tuple(steer(plant, LINEARISED, linear, reach, f) for f in FREQUENCIES)
    return OpenLoopResult(ways, sweep)
