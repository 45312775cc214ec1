"""Pick-up of the mains.

a: fundamental and harmonics of a grid whose frequency wanders by some hundredths of a hertz
   (ENTSO-E allows 50 mHz in ordinary operation).
b: the same fundamental modulated by a slow load, and bursts of a rectifier's doubled frequency.
Strength: the amplitude of the fundamental at the sensor, in m.
"""

from __future__ import annotations

from math import pi

import numpy as np

from microgripper_control.validation.block import Array, Block
from microgripper_control.validation.chance import slow_course
from microgripper_control.validation.effects.form import (
    Effect,
    Element,
    Form,
    Place,
    Reach,
    Shape,
    Slot,
    Surroundings,
    shape,
    strength,
)

WANDER = 0.015  # Hz, standard deviation
WANDER_CORNER = 0.05  # Hz
SWING_CORNER = 0.3  # Hz
SPACING = 0.01  # s, over which the wander is summed up to a phase


def mains(region: float) -> float:
    """50 Hz in most places, else 60."""
    return 50.0 if region < 0.7 else 60.0


def wandering_grid(size: float, given: Shape, around: Surroundings) -> Element:
    """Form a."""
    generator = around.generator()
    begin, end = -around.past - 1.0, around.duration + 1.0
    phases = generator.uniform(0.0, 2.0 * pi, 3)
    wander = slow_course(generator, begin, end, WANDER_CORNER)
    times = np.arange(begin, end, SPACING)
    slip = 2.0 * pi * WANDER * SPACING * np.cumsum(wander(times))
    frequency = mains(given["region"])

    def run(block: Block) -> None:
        t = block.times
        turn = 2.0 * pi * frequency * t + np.interp(t, times, slip)
        parts = ((1.0, 1.0), (2.0, given["second"]), (3.0, given["third"]))
        for (order, amount), phase in zip(parts, phases, strict=True):
            block.signal += size * amount * np.sin(order * turn + phase)

    return Element(Slot.READING, run)


def modulated(size: float, given: Shape, around: Surroundings) -> Element:
    """Form b."""
    generator = around.generator()
    begin, end = -around.past - 1.0, around.duration + 1.0
    phases = generator.uniform(0.0, 2.0 * pi, 2)
    swing = slow_course(generator, begin, end, SWING_CORNER)
    burst = slow_course(generator, begin, end, SWING_CORNER)
    frequency = mains(given["region"])

    def run(block: Block) -> None:
        t: Array = block.times
        load = np.maximum(1.0 + given["depth"] * swing(t), 0.0)
        block.signal += size * load * np.sin(2.0 * pi * frequency * t + phases[0])
        on = np.where(burst(t) > 0.0, given["rectifier"], 0.0)
        block.signal += size * on * np.sin(4.0 * pi * frequency * t + phases[1])

    return Element(Slot.READING, run)


def at_mains(size: float, given: Shape, reach: Reach) -> list[Place]:
    """Half a hertz around the fundamental."""
    frequency = mains(given["region"])
    return [Place("frequency_Hz", frequency - 0.5, frequency + 0.5)]


REGION = shape("region", "1", 0.0, 1.0, "below 0.7 a grid of 50 Hz, else of 60 Hz")

EFFECT = Effect(
    "mains_hum",
    "sensor",
    True,
    (
        Form(
            "a",
            "a grid whose frequency wanders, with harmonics",
            strength("m", 2.5e-8, 2e-5, "amplitude of the fundamental"),
            (
                REGION,
                shape("second", "1", 0.0, 0.2, "second harmonic over the fundamental"),
                shape("third", "1", 0.1, 0.4, "third harmonic over the fundamental"),
            ),
            wandering_grid,
            at_mains,
            repeatable=False,
        ),
        Form(
            "b",
            "modulated by a slow load, with a rectifier's bursts",
            strength("m", 2.5e-8, 2e-5, "mean amplitude of the fundamental"),
            (
                REGION,
                shape("depth", "1", 0.2, 0.6, "of the modulation"),
                shape("rectifier", "1", 0.1, 0.5, "doubled frequency over the fundamental"),
            ),
            modulated,
            at_mains,
            repeatable=False,
        ),
    ),
)
