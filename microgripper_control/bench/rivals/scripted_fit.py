"""The identification as one would script it: least squares with differences, or evolution.

Fitted are d, alpha, beta and gamma, each in units of its start, and the displacement's zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import differential_evolution, least_squares

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.plant.model import Key, Model
from microgripper_control.plant.simulate import Initial, simulate

KEYS: tuple[Key, ...] = tuple(("bouc_wen", name) for name in ("d", "alpha", "beta", "gamma"))
AROUND = 0.5  # evolution looks so far around the start, in units of it

Simulator = Callable[[Model], Array]


@dataclass(frozen=True)
class Scripted:
    """What a script found, and how often it asked for a simulation."""

    model: Model
    simulations: int


def compiled_model(recording: Recording) -> Simulator:
    """Our simulation of the recording's voltage from rest."""
    return lambda model: simulate(
        model, recording.voltage, recording.sample_period, initial=Initial.REST
    )


def least_squares_script(start: Model, recording: Recording, simulator: Simulator) -> Scripted:
    """`scipy.optimize.least_squares` with its own finite differences."""
    asked = _Asked(start, recording, simulator)
    best = least_squares(asked.residual, np.append(np.ones(len(KEYS)), 0.0), x_scale="jac")
    return Scripted(asked.model(best.x), asked.count)


def evolution_script(start: Model, recording: Recording, simulator: Simulator) -> Scripted:
    """`scipy.optimize.differential_evolution`, its zero taken as the residual's mean."""
    asked = _Asked(start, recording, simulator)

    def squares(z: Array) -> float:
        residual = asked.residual(np.append(z, 0.0))
        return float(np.var(residual)) if np.all(np.isfinite(residual)) else np.inf

    bounds = [(1.0 - AROUND, 1.0 + AROUND)] * len(KEYS)
    best = differential_evolution(squares, bounds, seed=1)
    return Scripted(asked.model(best.x), asked.count)


class _Asked:
    """Residuals at a point, in um, counted."""

    def __init__(self, start: Model, recording: Recording, simulator: Simulator) -> None:
        self._start, self._recording, self._simulator = start, recording, simulator
        self.count = 0

    def model(self, z: Array) -> Model:
        return self._start.with_values(
            {key: float(size) * self._start.value(*key) for key, size in zip(KEYS, z, strict=False)}
        )

    def residual(self, z: Array) -> Array:
        self.count += 1
        predicted = self._simulator(self.model(z))
        error: Array = 1e6 * (self._recording.measured - predicted) - z[-1]
        return error
