"""An underdamped mode.

a: a finger on the moving mass, with its reaction on it (two degrees of freedom; Preumont, Vibration
   Control of Active Structures, 2011, ch. 3), read at a point that takes part in its motion:
       y'' + 2 z w r' + w^2 r = 0,   r = y - x,   F = mf (w^2 r + 2 z w r'),   shown x + lever r
   a longer finger is heavier: mf = mass lever m. Strength is the lever.
b: a mount that gives way to the moving mass's inertia, in two modes, the second higher and weaker:
       y / x = 1 - sum of mu s^2 / (s^2 + 2 z w s + w^2)
   Strength is mu, moving mass over mount, of the first mode.
"""

from __future__ import annotations

from math import pi

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array, Block
from microgripper_control.validation.effects.form import (
    Effect,
    Element,
    Force,
    Form,
    Place,
    Reach,
    Shape,
    Slot,
    Surroundings,
    shape,
    strength,
)
from microgripper_control.validation.effects.kinds import FINGER
from microgripper_control.validation.linear import LinearFilter, exact_step

HIGHEST = 1500.0  # Hz
SECOND = 1.7  # frequency of the mount's second mode over the first
SECOND_SHARE = 0.35  # its mass ratio over the first's


def frequency(tone: float, sample_period: float) -> float:
    """The mode's frequency, Hz: a share of half the sampling rate, as far as a finger's goes."""
    return min(tone * 0.5 / sample_period, tone * HIGHEST / 0.5)


@compiled
def finger(
    p: Array, old: Array, new: Array, x0: float, v0: float, x1: float, v1: float, step: float
) -> float:
    """p: decay (4), held (2), lever, mf w^2, mf 2 z w; state: carried, r, y'.

    Exact for an x that runs straight over the step.
    """
    speed = (x1 - x0) / step
    new[1] = p[0] * old[1] + p[1] * old[2] + p[4] * speed
    new[2] = p[2] * old[1] + p[3] * old[2] + p[5] * speed
    new[0] = p[6] * new[1]
    return float(p[7] * new[1] + p[8] * (new[2] - v1))


def heavy_finger(lever: float, given: Shape, around: Surroundings) -> Force:
    """Form a."""
    w = 2.0 * pi * frequency(given["tone"], around.sample_period)
    loss = 2.0 * given["damping"] * w
    exact = exact_step(np.array([[0.0, 1.0], [-w * w, -loss]]), np.array([-1.0, loss]), around.step)
    mass = given["mass"] * lever * around.scale.base.m
    tail = [lever, mass * w * w, mass * loss]
    return Force(FINGER, np.concatenate([exact.decay.ravel(), exact.held, tail]))


def inertial_mount(ratio: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    first = 2.0 * pi * frequency(given["tone"], around.sample_period)
    a, b, c, through = np.zeros((4, 4)), np.zeros(4), np.zeros(4), 1.0
    for i, (w, mu) in enumerate(((first, ratio), (SECOND * first, SECOND_SHARE * ratio))):
        loss = 2.0 * given["damping"] * w
        # States in units of w: position and velocity / w of the mode driven by x w^2.
        a[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[0.0, w], [-w, -loss]]
        b[2 * i + 1] = w
        c[2 * i], c[2 * i + 1] = mu, mu * loss / w
        through -= mu
    made = LinearFilter((a, b, c, through), around.step)

    def run(block: Block) -> None:
        made.run(block.signal, np.ones_like(block.signal))

    return Element(Slot.POSITION, run)


def around_mode(amount: float, given: Shape, reach: Reach) -> list[Place]:
    """The frequency of the (first) mode and its half-power band, at least 5 % to each side."""
    f = frequency(given["tone"], reach.sample_period)
    half = max(given["damping"], 0.05) * f
    return [Place("frequency_Hz", f - half, f + half)]


SHAPE = (
    shape("tone", "1", 0.1, 0.5, "frequency, of half the sampling rate, at most 1500 Hz"),
    shape("damping", "1", 0.01, 0.06, "ratio"),
)

EFFECT = Effect(
    "extra_resonance",
    "transmission",
    True,
    (
        Form(
            "a",
            "a finger that reacts on the moving mass",
            strength("1", 0.1, 5.0, "share of the finger's motion in the reading"),
            (*SHAPE, shape("mass", "1", 0.02, 0.1, "finger over moving mass at lever 1")),
            heavy_finger,
            around_mode,
        ),
        Form(
            "b",
            "a mount driven by inertia, in two modes",
            strength("1", 0.05, 2.0, "moving mass over mount"),
            SHAPE,
            inertial_mount,
            around_mode,
        ),
    ),
)
