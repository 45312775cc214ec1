"""Section 7, equations (7)-(9), fig. 12 to 14: the equivalent linear hysteresis.

k1 and k2 are fitted by simplex, as in the paper, so that the linear h follows the recorded one. The
recorded h does not depend on the rate: k1 comes out the same at every drive frequency, k2 in
proportion to it. The paper does not give its frequency, so neither k2 nor what follows from it can
be had again; the frequency at which the printed k2 would come out is computed instead.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from microgripper_control.control.identified import Identified
from microgripper_control.control.linearised import Linearised
from microgripper_control.core.signals import Array
from microgripper_control.paper.agreement import Row, Table
from microgripper_control.paper.behaviour import at_rest
from microgripper_control.paper.experiment import (
    CYCLES,
    FREQUENCY,
    SAMPLE_PERIOD,
    drive,
    hysteresis,
)
from microgripper_control.paper.printed import K1, K2
from microgripper_control.plant.model import Model

SAMPLES_PER_CYCLE = round(1.0 / (FREQUENCY * SAMPLE_PERIOD))
FREQUENCIES = (0.1, 0.3, 1.0, 3.0, 10.0)  # Hz
COURSES = tuple((shape, cycles) for shape in ("sine", "triangle") for cycles in (1, 2, CYCLES, 10))
SECTION = "7, (9)"


@dataclass(frozen=True)
class LinearFit:
    """k1 and k2 for one course of the voltage."""

    shape: str
    cycles: int
    frequency: float  # Hz
    found: Linearised
    rmse: float  # of h, share of its peak to peak

    @property
    def frequency_of_printed_k2(self) -> float:
        """The drive frequency, Hz, at which the printed k2 would come out: k2 is in proportion."""
        return self.frequency * K2 / self.found.k2


@dataclass(frozen=True)
class LinearisedResult:
    """The fit to the experiment, and its dependence on what the paper leaves open."""

    voltage: Array  # V
    hysteresis: Array  # m, of equations (2), (3)
    linear_hysteresis: Array  # m, of (7) with the fitted coefficients
    displacement: Array  # m, of the nonlinear model
    linear_displacement: Array  # m
    fit: LinearFit
    sweep: tuple[LinearFit, ...]  # sines of all frequencies
    courses: tuple[LinearFit, ...]  # shapes and numbers of cycles, at 1 Hz
    by_equation_error: Linearised  # the experiment again, with the error of equation (8)

    @property
    def frequency_range(self) -> tuple[float, float]:
        """The drive frequencies, Hz, at which the printed k2 would come out, over the courses."""
        found = [course.frequency_of_printed_k2 for course in self.courses]
        return min(found), max(found)

    def rows(self) -> list[Row]:
        """k1 and k2 against the printed ones."""
        low, high = self.frequency_range
        k1 = [course.found.k1 for course in self.courses]
        return [
            Row(
                SECTION,
                "k1",
                "m/V",
                self.fit.found.k1,
                K1,
                f"{min(k1):.3g} .. {max(k1):.3g} over shapes and numbers of cycles; "
                "independent of the frequency",
            ),
            Row(
                SECTION,
                f"k2 at {FREQUENCY:g} Hz",
                "1/s",
                self.fit.found.k2,
                K2,
                "in proportion to the drive's frequency, which the paper does not give: "
                "not reproducible",
            ),
            Row(
                SECTION,
                "drive frequency that would give the printed k2",
                "Hz",
                self.fit.frequency_of_printed_k2,
                remark=f"{low:.2f} .. {high:.2f} over shapes and numbers of cycles",
                form=".3f",
            ),
            Row(
                "7, fig. 12",
                "error of the linear h",
                "% of p-p, rms",
                100.0 * self.fit.rmse,
                form=".2f",
            ),
        ]

    def tables(self) -> list[Table]:
        """Dependence on the frequency, and on the course of the voltage."""
        return [
            Table(
                "Dependence on the drive's frequency (sine)",
                ("frequency, Hz", "k1, m/V", "k2, 1/s", "k2 / frequency"),
                [
                    (
                        f"{fit.frequency:g}",
                        f"{fit.found.k1:.4g}",
                        f"{fit.found.k2:.4g}",
                        f"{fit.found.k2 / fit.frequency:.4g}",
                    )
                    for fit in self.sweep
                ],
            ),
            Table(
                f"Dependence on the course of the voltage, at {FREQUENCY:g} Hz",
                ("course", "k1, m/V", "k2, 1/s", "frequency for the printed k2, Hz"),
                [
                    (
                        f"{fit.shape}, {fit.cycles} cycle{'s' * (fit.cycles > 1)}",
                        f"{fit.found.k1:.4g}",
                        f"{fit.found.k2:.4g}",
                        f"{fit.frequency_of_printed_k2:.3f}",
                    )
                    for fit in self.courses
                ],
                "The fits above are of h, as the paper's. Least squares on the error of equation "
                f"(8), of h', instead gives {self.by_equation_error.k1:.4g} m/V and "
                f"{self.by_equation_error.k2:.4g} 1/s for the experiment.",
            ),
        ]


def fit_linearised(
    voltage: Array, recorded: Array, sample_period: float, start: Linearised
) -> Linearised:
    """k1 (m/V) and k2 (1/s) of (7) by simplex: least squares on h.

    `voltage` (V) and `recorded` h (m) have shape (n,), held over steps of `sample_period` (s) from
    rest. `start` gives the sizes to begin with.
    """
    power = float(recorded @ recorded)

    def squares(point: Array) -> float:
        candidate = Linearised(float(point[0]) * start.k1, float(point[1]) * start.k2)
        error = candidate.hysteresis(voltage, sample_period) - recorded
        return float(error @ error) / power

    best = minimize(
        squares, np.ones(2), method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-14}
    )
    return Linearised(float(best.x[0]) * start.k1, float(best.x[1]) * start.k2)


def fit_equation_error(voltage: Array, recorded: Array, sample_period: float) -> Linearised:
    """k1 (m/V) and k2 (1/s) by least squares on the error (8), h' - (k1 u' + k2 h).

    Integrated over each step: the change of h (m) against that of u (V) and the mean h times T.
    """
    basis = np.stack(
        [np.diff(voltage), 0.5 * sample_period * (recorded[1:] + recorded[:-1])], axis=1
    )
    sizes = np.linalg.norm(basis, axis=0)
    (k1, k2), *_ = np.linalg.lstsq(basis / sizes, np.diff(recorded), rcond=None)
    return Linearised(float(k1 / sizes[0]), float(k2 / sizes[1]))


def fit_course(plant: Model, shape: str, cycles: int, frequency: float) -> LinearFit:
    """Drive the plant's h, (2), over its voltage range at a frequency, Hz; fit k1 and k2 of (7)."""
    period = 1.0 / (frequency * SAMPLES_PER_CYCLE)
    voltage = drive(plant, shape, cycles, frequency, period)
    recorded = hysteresis(plant, voltage)
    v = plant.values("bouc_wen")
    # h grows with alpha d u' from zero and is forgotten within about a cycle.
    start = Linearised(v["alpha"] * v["d"], -frequency)
    found = fit_linearised(voltage, recorded, period, start)
    error = found.hysteresis(voltage, period) - recorded
    rmse = float(np.sqrt(np.mean(error**2)) / np.ptp(recorded))
    return LinearFit(shape, cycles, frequency, found, rmse)


def reproduce_linearised(plant: Model) -> LinearisedResult:
    """Fit the experiment, a sweep of its frequency, and other courses."""
    voltage = drive(plant)
    recorded = hysteresis(plant, voltage)
    fit = fit_course(plant, "sine", CYCLES, FREQUENCY)
    return LinearisedResult(
        voltage=voltage,
        hysteresis=recorded,
        linear_hysteresis=fit.found.hysteresis(voltage, SAMPLE_PERIOD),
        displacement=at_rest(plant, voltage),
        linear_displacement=fit.found.displacement(Identified.of(plant), voltage, SAMPLE_PERIOD),
        fit=fit,
        sweep=tuple(fit_course(plant, "sine", CYCLES, f) for f in FREQUENCIES),
        courses=tuple(fit_course(plant, *course, FREQUENCY) for course in COURSES),
        by_equation_error=fit_equation_error(voltage, recorded, SAMPLE_PERIOD),
    )
