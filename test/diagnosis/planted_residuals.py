"""Residuals whose cause is known: a recording, what a model says of it, and what is added."""

from __future__ import annotations

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.residuals import Residual
from microgripper_control.identification.nuisance import blocks

PERIOD = 1e-3  # s
NOISE = 15e-9  # m
GAIN = 1.2e-7  # m/V


def loops(count: int = 20000, frequency: float = 0.7) -> Array:
    """Decaying loops between 0 and 150 V."""
    time = PERIOD * np.arange(count)
    share = np.linspace(1.0, 0.3, count)
    turns = np.cos(2.0 * np.pi * frequency * time)
    return np.asarray(75.0 * (1.0 - share * turns), dtype=np.float64)


def staircase(count: int = 30000, seed: int = 3) -> Array:
    """Random levels held for 1.5 s."""
    levels = np.random.default_rng(seed).uniform(0.0, 150.0, count // 1500 + 1)
    return np.repeat(levels, 1500)[:count]


def multisine(count: int = 20000, seed: int = 4) -> Array:
    """Lines from 0.7 to 61 Hz, rich in slow parts."""
    time = PERIOD * np.arange(count)
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, 7)
    lines = (0.7, 1.9, 4.3, 9.1, 17.0, 31.0, 61.0)
    parts = [
        np.sin(2.0 * np.pi * f * time + p) / f**0.3 for f, p in zip(lines, phases, strict=True)
    ]
    return np.asarray(75.0 + 22.0 * np.sum(parts, axis=0), dtype=np.float64)


def motion(voltage: Array) -> Array:
    """A displacement, m, that follows with a little loop: one sample late, and behind a play."""
    late = np.concatenate([voltage[:1], voltage[:-1]])
    finger, played = late[0], []
    for u in late.tolist():
        finger = min(max(finger, u - 4.0), u + 4.0)
        played.append(0.8 * u + 0.2 * finger)
    return GAIN * np.array(played)


def planted(
    voltage: Array,
    added: Array | float,
    seed: int = 0,
    odd: bool = False,
    predicted: Array | None = None,
) -> Residual:
    """A residual of white noise and what is `added`, m, judged on the even blocks, or the odd."""
    predicted = motion(voltage) if predicted is None else predicted
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(voltage))
    error = np.asarray(noise + added, dtype=np.float64)
    error = error - error[blocks(len(voltage), odd=True)].mean()
    recording = Recording("planted", PERIOD, voltage, predicted + error)
    return Residual(recording, error, blocks(len(voltage), odd=odd))
