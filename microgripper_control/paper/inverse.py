"""Section 6, equations (5), (6), Table 2, fig. 9 and 10: the inverse model as a compensator.

As the paper does, alpha, beta and gamma of the inverse model are fitted from displacement to
voltage, apart from those of the forward model; m, b, k and d stay. The inverse model is (6) solved
together with (3), which at these rates is the exact inverse of a held step.

Two compensators are compared: equation (6) stepped explicitly, with h of the step before, and the
exact discrete inverse (control/feedforward).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from microgripper_control.control.feedforward import InverseKind, make_inverse
from microgripper_control.control.identified import Identified
from microgripper_control.core.signals import Array
from microgripper_control.paper.agreement import Row, Table
from microgripper_control.paper.experiment import (
    FREQUENCY,
    SAMPLE_PERIOD,
    SHAPE,
    drive,
    record,
    with_paper_sensor,
)
from microgripper_control.paper.inverse_fit import (
    NAMES,
    InverseFit,
    fit_inverse,
    inverse_voltages,
    with_hysteresis,
)
from microgripper_control.paper.printed import TABLE_2
from microgripper_control.paper.setpoint import Tracking, approached_sine, tracking_error
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

FAST = 1000.0  # Hz, of the drive that shows where inertia and damping matter
FAST_PERIODS = tuple(float(t) for t in np.geomspace(1e-4, 1e-6, 13))  # s
SECTION = "6, Table 2"
UNAVAILABLE = "compared, not claimed: the paper's data are not available"


@dataclass(frozen=True)
class InverseResult:
    """The fits, and the errors of the compensators on the plant of Table 1."""

    exact: InverseFit
    paper: InverseFit
    triangle: InverseFit  # the paper's sensor, another course of the voltage
    forward: Mapping[str, float]
    errors: Mapping[str, tuple[Tracking, Tracking]]  # by parameters: equation (6), exact inverse
    fast_periods: tuple[float, ...]  # s
    fast_errors: Mapping[InverseKind, tuple[float, ...]]  # rms, % of peak to peak, at FAST

    @property
    def crossings(self) -> tuple[float, ...]:
        """The sample periods, s, at which the two are as good as each other at `FAST`, rising.

        Below the first equation (6) is the better one, and from each to the next the other. Read
        off between two of `fast_periods`, on logarithmic axes.
        """
        ratio = np.log(
            np.array(self.fast_errors[InverseKind.PAPER])
            / np.array(self.fast_errors[InverseKind.EXACT])
        )[::-1]
        periods = np.log(self.fast_periods[::-1])
        changes = np.flatnonzero(np.diff(ratio > 0.0))
        shares = ratio[changes] / (ratio[changes] - ratio[changes + 1])
        found = np.exp(periods[changes] + shares * (periods[changes + 1] - periods[changes]))
        first = (0.0,) if ratio[0] > 0.0 else ()
        return (*first, *found.tolist())

    @property
    def crossing(self) -> float:
        """The sample period, s, below which equation (6) is the better one throughout."""
        return self.crossings[0] if self.crossings else self.fast_periods[0]

    @property
    def _above(self) -> str:
        """Which is the better one above the first crossing."""
        if not self.crossings:
            return ""
        longest = self.fast_periods[:1] if len(self.crossings) % 2 == 0 else ()
        again = [f"{1e6 * period:.0f}" for period in (*self.crossings[1:], *longest)]
        spans = ", ".join(" to ".join(again[at : at + 2]) for at in range(0, len(again), 2))
        return f"above it the exact inverse{f' but for {spans} µs' if spans else ''}"

    def rows(self) -> list[Row]:
        """Table 2 beside fits to simulated data; and what the compensators leave."""
        rows = []
        for found in (self.exact, self.paper):
            rows += [
                Row(
                    SECTION,
                    f"{name} of the inverse, {found.sensor}",
                    "1" if name == "alpha" else "1/V",
                    found.values[name],
                    TABLE_2[name],
                    UNAVAILABLE if name == NAMES[0] else "",
                )
                for name in NAMES
            ]
        for name in ("Table 1", f"fitted, {self.paper.sensor}"):
            explicit, exact = self.errors[name]
            rows += [
                Row(
                    "6",
                    f"error of {kind}, {name}",
                    "% rms of p-p",
                    found.rms,
                    remark=f"largest {found.largest:.3f} %",
                    form=".3f",
                )
                for kind, found in (("equation (6)", explicit), ("the exact inverse", exact))
            ]
        rows.append(
            Row(
                "6",
                f"equation (6) the better one at {FAST:g} Hz for sample periods below",
                "µs",
                1e6 * self.crossing,
                remark=self._above,
                form=".1f",
            )
        )
        return rows

    def tables(self) -> list[Table]:
        """The parameters beside each other, and the errors of the compensators at 1 kHz."""
        values = {
            "Table 1, forward": self.forward,
            "Table 2, inverse, as printed": TABLE_2,
            **{
                f"inverse, {found.sensor}": found.values
                for found in (self.exact, self.paper, self.triangle)
            },
        }
        return [
            Table(
                "Parameters of forward and inverse model",
                ("", *NAMES),
                [(name, *(f"{v[key]:.4f}" for key in NAMES)) for name, v in values.items()],
                "From exact samples the inverse has the forward model's parameters but for the "
                "first turn, where the displacement does not tell the voltage (section 3). The "
                "sensor's resolution alone moves them to the same side as Table 2 stands from "
                "Table 1, and with its zero where it is assumed as far: its steps are taken for "
                "travel.",
            ),
            self._error_table(),
        ]

    def _error_table(self) -> Table:
        rows = [
            (name, *(f"{e.rms:.3f} / {e.largest:.3f}" for e in pair))
            for name, pair in self.errors.items()
        ]
        return Table(
            "Error of the inverse model as a compensator, % of peak to peak, rms / largest",
            ("parameters of the compensator", "equation (6), explicit", "exact discrete inverse"),
            rows,
            "1 Hz sine, sampled at 1 kHz, on the plant of Table 1. Equation (6) stepped explicitly "
            "uses h of the step before; the exact inverse solves for it.",
        )


def compensation_error(
    plant: Model,
    identified: Identified,
    kind: InverseKind,
    setpoint: Array,
    start: int,
    sample_period: float,
) -> Tracking:
    """How far the plant stays from a setpoint (m) with the inverse alone, from sample `start` on.

    The setpoint is known ahead: each voltage aims at the end of its own step.
    """
    inverse = make_inverse(kind, identified, identified.voltage_range, sample_period)
    voltage = inverse_voltages(inverse, setpoint)
    displacement = simulate(plant, np.append(voltage, voltage[-1]), sample_period)[1:]
    return tracking_error(setpoint[start:], displacement[start:])


def reproduce_inverse(
    plant: Model,
    reach: tuple[float, float],
    progress: Callable[[str], None] = lambda stage: None,
) -> InverseResult:
    """Fit the inverse with an exact and with the paper's sensor, and try compensators.

    `reach` (m) is where the setpoint moves.
    """
    exact, coarse, triangle = _fits(plant, progress)
    forward = {name: plant.value("bouc_wen", name) for name in NAMES}
    parameters = {
        "Table 1": forward,
        "Table 2 as printed": TABLE_2,
        **{f"fitted, {found.sensor}": found.values for found in (exact, coarse)},
    }
    errors = {name: _slow_errors(plant, values, reach) for name, values in parameters.items()}
    progress("inverse models, fast sampling")
    fast = {
        kind: tuple(_fast_error(plant, kind, reach, period) for period in FAST_PERIODS)
        for kind in InverseKind
    }
    return InverseResult(exact, coarse, triangle, forward, errors, FAST_PERIODS, fast)


def _fits(
    plant: Model, progress: Callable[[str], None]
) -> tuple[InverseFit, InverseFit, InverseFit]:
    """With exact samples, with the paper's sensor, and with that and a triangle."""

    def fitted(rig: Model, sensor: str, shape: str = SHAPE) -> InverseFit:
        progress(f"inverse model, {sensor}")
        recording = record(rig, drive(plant, shape), sensor)
        return fit_inverse(recording, Identified.of(plant), sensor)

    coarse = with_paper_sensor(plant)
    return (
        fitted(plant, "exact samples"),
        fitted(coarse, "1 µm sensor"),
        fitted(coarse, "1 µm sensor, triangle", "triangle"),
    )


def _slow_errors(
    plant: Model, values: Mapping[str, float], reach: tuple[float, float]
) -> tuple[Tracking, Tracking]:
    """Of equation (6) and of the exact inverse with these values, at 1 Hz and 1 kHz."""
    held = with_hysteresis(Identified.of(plant), values)
    setpoint, start = approached_sine(reach, FREQUENCY, 3, SAMPLE_PERIOD)
    explicit, exact = (
        compensation_error(plant, held, kind, setpoint, start, SAMPLE_PERIOD)
        for kind in (InverseKind.PAPER, InverseKind.EXACT)
    )
    return explicit, exact


def _fast_error(
    plant: Model, kind: InverseKind, reach: tuple[float, float], sample_period: float
) -> float:
    setpoint, start = approached_sine(reach, FAST, 2, sample_period)
    identified = Identified.of(plant)
    return compensation_error(plant, identified, kind, setpoint, start, sample_period).rms
