"""New test signals for the public Bouc-Wen benchmark: two steady multisines and a sweep from rest.

    python test/diagnosis/bouc_wen_benchmark.py DIR

The equations as Noel and Schoukens (doi 10.4121/12967592) give them, without noise, marched by
Runge-Kutta of order 4 with 128 steps a sample: nothing of the package has a part in it. Writes
multisine_1.csv, multisine_2.csv and sweep.csv. What a diagnosis leaves of them: docs/diagnosis.md.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
State = tuple[float, float, float]

MASS, DAMPING, STIFFNESS = 2.0, 10.0, 5e4  # kg, N s/m, N/m
ALPHA, BETA, GAMMA, DELTA = 5e4, 1e3, 0.8, -1.1
RATE = 750.0  # Hz
STEPS = 128  # in a sample
PERIOD = 8192  # samples
LOWEST, HIGHEST = 5.0, 150.0  # Hz
SEEDS = (9601, 9602)
SWEEP_SECONDS = 180
REST: State = (0.0, 0.0, 0.0)


@numba.njit
def rates(state: State, force: float) -> State:
    """The time derivatives of y, y' and z."""
    y, v, z = state
    acceleration = (force - DAMPING * v - STIFFNESS * y - z) / MASS
    return v, acceleration, ALPHA * v - BETA * (GAMMA * abs(v) * z + DELTA * v * abs(z))


@numba.njit
def ahead(state: State, way: State, time: float) -> State:
    """A state after some time at constant rates."""
    return state[0] + way[0] * time, state[1] + way[1] * time, state[2] + way[2] * time


@numba.njit
def marched(forces: Array, state: State) -> tuple[Array, State]:
    """The displacement at each sample; the forces, N, are those at all half steps and the end."""
    step = 1.0 / (RATE * STEPS)
    y = np.empty((len(forces) - 1) // (2 * STEPS))
    for j in range(0, len(forces) - 2, 2):
        if j % (2 * STEPS) == 0:
            y[j // (2 * STEPS)] = state[0]
        a = rates(state, forces[j])
        b = rates(ahead(state, a, step / 2.0), forces[j + 1])
        c = rates(ahead(state, b, step / 2.0), forces[j + 1])
        d = rates(ahead(state, c, step), forces[j + 2])
        for way, share in ((a, 1.0), (b, 2.0), (c, 2.0), (d, 1.0)):
            state = ahead(state, way, step * share / 6.0)
    return y, state


def multisine(seed: int) -> tuple[Array, Array]:
    """One period of a force of 50 N rms, and the displacement once it repeats itself."""
    hertz = np.fft.rfftfreq(PERIOD, 1.0 / RATE)
    excited = (hertz >= LOWEST) & (hertz <= HIGHEST)
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(hertz))
    spectrum = np.where(excited, np.exp(1j * phases), 0.0)
    force = np.fft.irfft(spectrum, PERIOD)
    scale = 50.0 / np.std(force)
    fine = np.fft.irfft(spectrum, PERIOD * 2 * STEPS) * 2 * STEPS * scale
    between = np.append(fine, fine[0])
    _, state = marched(between, REST)
    before, state = marched(between, state)
    y, _ = marched(between, state)
    assert np.max(np.abs(y - before)) < 1e-12
    return scale * force, y


def sweep() -> tuple[Array, Array]:
    """40 N, from 20 to 50 Hz by 10 Hz a minute, from rest."""
    t = np.arange(int(SWEEP_SECONDS * RATE) * 2 * STEPS + 1) / (RATE * 2 * STEPS)
    force = 40.0 * np.sin(2.0 * np.pi * (20.0 * t + 0.5 * (10.0 / 60.0) * t**2))
    y, _ = marched(force, REST)
    return force[: -1 : 2 * STEPS], y


def main(folder: Path) -> None:
    """Write the three recordings."""
    folder.mkdir(parents=True, exist_ok=True)
    signals = {f"multisine_{i}": multisine(seed) for i, seed in enumerate(SEEDS, 1)}
    for name, (force, y) in {**signals, "sweep": sweep()}.items():
        rows = np.column_stack([np.arange(len(y)) / RATE, force, y])
        header = "time_s,force_N,displacement_m"
        np.savetxt(folder / f"{name}.csv", rows, "%.17g", ",", header=header, comments="")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
