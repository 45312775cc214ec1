"""Courses of a voltage, or of a setpoint, as a laboratory would use them.

Each is a share of the range, from 0 to 1, as a function of the time in s from the recording's
start, where it rests for a moment. What is `smooth` has no jumps or kinks that its samples
would miss.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from microgripper_control.validation.block import Array

REST = 0.5  # s, before it moves
LOWEST = 0.2  # Hz, of multisines and chirps
HIGHEST = 120.0  # Hz
EDGE = 30.0  # samples that a smooth step takes, and at least
SHORTEST_EDGE = 0.03  # s


@dataclass(frozen=True)
class Wave:
    """A course over `duration` seconds; `hold` is how long it stays after its steps, if any."""

    duration: float
    share: Callable[[Array], Array]
    hold: float = 0.0  # s
    highest: float = 0.0  # Hz, zero where it is slow


@dataclass(frozen=True)
class Wish:
    """What a wave must fit: its duration, s, the sampling period, s, and whether it is smooth.

    `fastest` is the highest frequency over the sampling rate.
    """

    duration: float
    sample_period: float
    smooth: bool
    fastest: float

    @property
    def highest(self) -> float:
        """The highest frequency worth exciting, Hz."""
        return min(HIGHEST, self.fastest / self.sample_period)


Maker = Callable[[np.random.Generator, Wish], Wave]


def eased(share: Array) -> Array:
    """From 0 to 1 along half a cosine, and held outside."""
    return 0.5 - 0.5 * np.cos(np.pi * np.clip(share, 0.0, 1.0))


def keyframes(times: Array, values: Array, edge: float) -> Callable[[Array], Array]:
    """`values[i]` until `times[i]`, then over to the next within `edge` seconds (0: a jump)."""
    steps = np.diff(values)

    def share(t: Array) -> Array:
        total = np.full_like(t, values[0])
        for begin, step in zip(times, steps, strict=True):
            total += step * (eased((t - begin) / edge) if edge else (t >= begin - 1e-9))
        return total

    return share


def _moving(t: Array) -> Array:
    return np.maximum(t - REST, 0.0)


def _faded(t: Array, duration: float) -> Array:
    """From 0 up to 1 after the rest, and down to 0 at the end, so that it ends where it began."""
    return eased(_moving(t) / REST) * eased((duration - t) / REST)


def loops(generator: np.random.Generator, wish: Wish) -> Wave:
    """Slow loops from the bottom, a sine or a triangle."""
    slowest = max(0.1, 3.0 / (wish.duration - REST))
    frequency = float(np.exp(generator.uniform(np.log(slowest), np.log(2.0))))
    depth = generator.uniform(0.9, 1.0)
    triangle = generator.uniform() < 0.4 and not wish.smooth

    def share(t: Array) -> Array:
        turns = frequency * _moving(t)
        sine: Array = 0.5 - 0.5 * np.cos(2.0 * np.pi * turns)
        return depth * (1.0 - abs(2.0 * (turns % 1.0) - 1.0) if triangle else sine)

    return Wave(wish.duration, share)


def decaying(generator: np.random.Generator, wish: Wish) -> Wave:
    """Loops that shrink towards the middle, by equal steps or by equal factors."""
    slowest = max(0.3, 6.0 / (wish.duration - REST))
    frequency = float(np.exp(generator.uniform(np.log(slowest), np.log(2.0))))
    depth = generator.uniform(0.9, 1.0)
    straight = generator.uniform() < 0.5

    def share(t: Array) -> Array:
        way = np.minimum(_moving(t) / (wish.duration - REST), 1.0)
        size = 1.0 - 0.95 * way if straight else np.exp(-3.0 * way)
        loop: Array = 0.5 - 0.5 * size * np.cos(2.0 * np.pi * frequency * _moving(t))
        return depth * loop

    return Wave(wish.duration, share)


def staircase(generator: np.random.Generator, wish: Wish) -> Wave:
    """Levels, each held: up and down in order, or at random."""
    shortest, longest = wish.duration / 16.0, wish.duration / 6.0
    hold = generator.uniform(max(1.0, shortest), max(1.2, min(6.0, longest)))
    count = int(wish.duration / hold) + 1
    if generator.uniform() < 0.5:
        steps = generator.integers(3, 7)
        order = np.arange(count) % (2 * steps)
        levels = np.minimum(order, 2 * steps - order) / steps * generator.uniform(0.9, 1.0)
    else:
        levels = np.concatenate([[0.0], generator.uniform(0.0, 1.0, count - 1)])
        levels[1 + generator.integers(0, 2)] = 1.0
    times: Array = REST + hold * np.arange(count - 1.0)
    edge = max(EDGE * wish.sample_period, SHORTEST_EDGE) if wish.smooth else 0.0
    return Wave(wish.duration, keyframes(times, levels, edge), hold)


def multisine(generator: np.random.Generator, wish: Wish) -> Wave:
    """Lines of random phase from slow to fast, weaker where fast, around the middle."""
    count = int(generator.integers(10, 31))
    lines = np.geomspace(LOWEST, wish.highest, count) * generator.uniform(0.95, 1.0, count)
    phases = generator.uniform(0.0, 2.0 * np.pi, count)
    sizes = lines**-0.5
    size = generator.uniform(0.35, 0.48)

    def raw(t: Array) -> Array:
        total = np.zeros_like(t)
        for line, phase, part in zip(lines, phases, sizes, strict=True):
            total += part * np.sin(2.0 * np.pi * line * t + phase)
        return total

    peak = abs(raw(np.arange(0.0, wish.duration, 0.1 / wish.highest))).max()

    def share(t: Array) -> Array:
        course: Array = np.clip(raw(t) / peak, -1.04, 1.04)  # between the points of `peak`
        return 0.5 + size * _faded(t, wish.duration) * course

    return Wave(wish.duration, share, highest=wish.highest)


def chirp(generator: np.random.Generator, wish: Wish) -> Wave:
    """A sine whose frequency rises exponentially, weaker where fast, around the middle."""
    size = generator.uniform(0.35, 0.48)
    run = wish.duration - REST
    growth = float(np.log(wish.highest / LOWEST)) / run
    knee = 20.0  # Hz

    def share(t: Array) -> Array:
        frequency = LOWEST * np.exp(growth * np.minimum(_moving(t), run))
        turns = (frequency - LOWEST) / growth
        sine: Array = np.sin(2.0 * np.pi * turns)
        return 0.5 + size / (1.0 + frequency / knee) * _faded(t, wish.duration) * sine

    return Wave(wish.duration, share, highest=wish.highest)


def poor(generator: np.random.Generator, wish: Wish) -> Wave:
    """Once up and down, slowly: all that someone in a hurry records."""
    depth = generator.uniform(0.9, 1.0)
    run = wish.duration - 2.0 * REST
    triangle = generator.uniform() < 0.5 and not wish.smooth

    def share(t: Array) -> Array:
        way = np.minimum(_moving(t) / run, 1.0)
        bump = 1.0 - abs(2.0 * way - 1.0) if triangle else 0.5 - 0.5 * np.cos(2.0 * np.pi * way)
        return depth * bump

    return Wave(wish.duration, share)


def setpoints(generator: np.random.Generator, wish: Wish) -> Wave:
    """For a closed loop: steps with rounded edges, and a sine over them for the second half."""
    hold = generator.uniform(1.0, 3.0)
    count = max(int(wish.duration / hold) + 1, 3)
    levels = np.concatenate([[0.2], generator.uniform(0.15, 0.8, count - 1)])
    levels[1 + generator.integers(0, 2)] = 0.85
    times: Array = REST + hold * np.arange(count - 1.0)
    steps = keyframes(times, levels, generator.uniform(0.1, 0.4))
    frequency = generator.uniform(0.2, 1.5)
    size = generator.uniform(0.03, 0.1)

    def share(t: Array) -> Array:
        late = eased((t - 0.5 * wish.duration) / 1.0)
        return steps(t) + size * late * np.sin(2.0 * np.pi * frequency * t)

    return Wave(wish.duration, share, hold)
