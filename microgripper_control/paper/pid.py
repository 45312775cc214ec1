"""Section 8, equation (16), fig. 15: PID by Ziegler-Nichols, then optimised on the nonlinear plant.

The paper takes "Ziegler-Nichols' open loop" of MATLAB on its linear model and prints no gains. Here
that rule is applied to the continuous model, as the paper may have done, and to the loop as it
runs: sampled, held, and with one tick until the answer is applied. Ziegler and Nichols' other rule,
from the ultimate gain, is applied to the same loop. Then the gains are optimised by simplex for the
least tracking error of the nonlinear plant, once without further condition and once with margins.

Margins are of the linear model, by python-control.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import control
import numpy as np
from scipy.optimize import minimize

from microgripper_control.control.controller import Mode
from microgripper_control.control.identified import Identified
from microgripper_control.control.linearised import Linearised
from microgripper_control.control.pid import PidGains
from microgripper_control.control.setpoints import Ramp, Sequence, Sine, Staircase, Triangle
from microgripper_control.control.tuning import (
    LEAST_GAIN_MARGIN,
    LEAST_PHASE_MARGIN,
    Margins,
)
from microgripper_control.core.signals import Array
from microgripper_control.paper.agreement import Row, Table
from microgripper_control.paper.closed_loop import track
from microgripper_control.paper.experiment import SAMPLE_PERIOD
from microgripper_control.paper.linear_plant import state_space
from microgripper_control.paper.setpoint import Tracking, tracking_error
from microgripper_control.paper.tuning_rules import (
    continuous_margins,
    ideal_gains,
    reaction_curve_gains,
    sampled_loop,
    sampled_margins,
    ultimate_gains,
)
from microgripper_control.plant.model import Model

REACTION_STEP = 1e-7  # s
REACTION_POINTS = 3001  # until the continuous model has settled
SIMPLEX_EVALUATIONS = 120
SIMPLEX_RUNS = 2  # the first may collapse onto a bound
PENALTY = 100.0  # %, of the tracking error, for margins all gone
SECTION = "8"
REACTION, REACTION_SAMPLED = "Z-N reaction curve, continuous", "Z-N reaction curve, sampled"
ULTIMATE, ULTIMATE_PI = "Z-N ultimate gain", "Z-N ultimate gain, PI"
OPTIMISED, ROBUST = "least error", "least error with margins"


@dataclass(frozen=True)
class GainSet:
    """Gains, the margins they leave, and how the nonlinear plant follows with them."""

    name: str
    gains: PidGains
    continuous: Margins | None  # without sampling and delay, where the rule assumes that
    sampled: Margins
    tracking: Tracking | None  # None where the loop is unstable
    displacement: Array | None  # m


@dataclass(frozen=True)
class PidResult:
    """All sets of gains, and the setpoint they were tried on."""

    time: Array  # s
    setpoint: Array  # m
    start: int  # the sample from which errors count
    sets: Mapping[str, GainSet]

    def rows(self) -> list[Row]:
        """The two sets asked for, Ziegler-Nichols and optimised, with their margins."""
        rows = []
        for name in (ULTIMATE_PI, OPTIMISED, ROBUST):
            found = self.sets[name]
            assert found.tracking is not None
            values = (
                ("gain margin", "1", found.sampled.gain),
                ("phase margin", "deg", found.sampled.phase),
                ("tracking error", "% rms of p-p", found.tracking.rms),
            )
            rows += [
                Row(SECTION, f"{what}, {name}", unit, value, form=".3g")
                for what, unit, value in values
            ]
        return rows

    def table(self) -> Table:
        """All sets."""
        rows = []
        for found in self.sets.values():
            g = found.gains
            tracking = found.tracking
            rows.append(
                (
                    found.name,
                    f"{1e-6 * g.kp:.3f}",
                    f"{1e-6 * g.ki:.0f}",
                    f"{1e-6 * g.kd:.6f}",
                    "-" if found.continuous is None else _text(found.continuous),
                    _text(found.sampled),
                    "-" if tracking is None else f"{tracking.rms:.2f}",
                )
            )
        return Table(
            "PID gains and what they leave",
            (
                "rule",
                "Kp, V/µm",
                "Ki, V/(µm s)",
                "Kd, V s/µm",
                "margins, continuous",
                "margins, sampled",
                "error, % rms of p-p",
            ),
            rows,
            "Margins: gain factor and phase. Sampled: at 1 kHz, held, the answer applied one tick "
            "later. Z-N: Ziegler and Nichols. Their rules for PID expect a plant with a lag; a "
            "piezo sampled at 1 kHz is dead time alone, on which they are unstable, and only the "
            "rule for PI works. The error is of the nonlinear plant over a staircase, a triangle "
            "and a sine, most of it from the steps, which no loop can answer before its delay.",
        )


def reproduce_pid(
    plant: Model,
    linear: Linearised,
    reach: tuple[float, float],
    progress: Callable[[str], None] = lambda stage: None,
) -> PidResult:
    """Tune by every rule and try each set that is stable on the nonlinear plant.

    `linear` is the linearisation of section 7, `reach` (m) where the setpoint moves.
    """
    identified = Identified.of(plant)
    continuous = state_space(identified, linear, flexure=True)
    loop = sampled_loop(identified, linear, SAMPLE_PERIOD)
    setpoint, start = mixed_setpoint(reach)

    def follow(gains: PidGains) -> Array:
        return track(plant, identified, Mode.PID, setpoint, gains)

    def gain_set(name: str, gains: PidGains, assumed: bool = False) -> GainSet:
        margins = sampled_margins(loop, gains)
        stable = margins.gain > 0.0
        moved = follow(gains) if stable else None
        error = None if moved is None else tracking_error(setpoint[start:], moved[start:])
        before = continuous_margins(continuous, gains) if assumed else None
        return GainSet(name, gains, before, margins, error, moved)

    time = REACTION_STEP * np.arange(REACTION_POINTS, dtype=np.float64)
    _, response = control.step_response(continuous, time)
    ticks = SAMPLE_PERIOD * np.arange(10, dtype=np.float64)
    _, sampled_response = control.step_response(loop, ticks)
    sets = [
        gain_set(REACTION, reaction_curve_gains(time, response), assumed=True),
        gain_set(REACTION_SAMPLED, reaction_curve_gains(ticks, sampled_response)),
        gain_set(ULTIMATE, ultimate_gains(loop)),
        gain_set(ULTIMATE_PI, ultimate_gains(loop, derivative=False)),
    ]
    begin = 0.5 * np.array([sets[2].gains.kp, sets[2].gains.ki, sets[2].gains.kd])
    for name, least_gain, least_phase in (
        (OPTIMISED, 0.0, 0.0),
        (ROBUST, LEAST_GAIN_MARGIN, LEAST_PHASE_MARGIN),
    ):
        progress(f"PID, {name}")
        sets.append(
            gain_set(
                name, _optimised(begin, follow, loop, setpoint, start, least_gain, least_phase)
            )
        )
    return PidResult(
        SAMPLE_PERIOD * np.arange(len(setpoint), dtype=np.float64),
        setpoint,
        start,
        {found.name: found for found in sets},
    )


def _text(margins: Margins) -> str:
    """As people read it."""
    if margins.gain == 0.0:
        return "unstable"
    return f"{margins.gain:.2f}, {margins.phase:.0f} deg"


def mixed_setpoint(reach: tuple[float, float]) -> tuple[Array, int]:
    """A staircase, a triangle and a sine between two displacements, m, and where they begin."""
    low, high = reach
    both = {"low": low, "high": high}
    sequence = Sequence(
        (
            (Ramp(low=0.0, high=low, duration=0.05), 0.1),
            (Staircase(**both, steps=5, hold=0.05), 0.5),
            (Triangle(**both, frequency=2.0), 0.5),
            (Sine(**both, frequency=2.0), 1.0),
        )
    )
    _, start, *_, end = sequence.boundaries(SAMPLE_PERIOD)
    return sequence.samples(end, SAMPLE_PERIOD), start


def _optimised(
    begin: Array,
    follow: Callable[[PidGains], Array],
    loop: control.StateSpace,
    setpoint: Array,
    start: int,
    least_gain: float,
    least_phase: float,
) -> PidGains:
    """Simplex over the gains in units of `begin`; what margins are short of counts as error."""

    def cost(point: Array) -> float:
        gains = ideal_gains(*map(float, point * begin))
        error = tracking_error(setpoint[start:], follow(gains)[start:]).rms
        if least_gain == 0.0:
            return error
        margins = sampled_margins(loop, gains)
        short = max(0.0, 1.0 - margins.gain / least_gain, 1.0 - margins.phase / least_phase)
        return error + PENALTY * short

    best = np.ones(3)
    for _ in range(SIMPLEX_RUNS):
        best = minimize(
            cost,
            best,
            method="Nelder-Mead",
            bounds=[(0.0, None)] * 3,
            options={"maxfev": SIMPLEX_EVALUATIONS, "xatol": 1e-4, "fatol": 1e-5},
        ).x
    return ideal_gains(*map(float, best * begin))
