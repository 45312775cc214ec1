"""The rig and the recordings that the rows share."""

from __future__ import annotations

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import LEVELS, Array, Timing
from microgripper_control.effects.mechanics import second_order
from microgripper_control.plant.model import Key, Model, nominal_model
from microgripper_control.plant.simulate import simulate

SAMPLE_PERIOD = 1e-3  # s
SAMPLES = 44_000  # 44 s
NOISE = 15e-9  # m
MISTUNED: dict[Key, float] = {  # what a fit starts from, in proportion to the truth
    ("bouc_wen", "d"): 0.9,
    ("bouc_wen", "alpha"): 1.1,
    ("bouc_wen", "beta"): 0.9,
    ("bouc_wen", "gamma"): 1.1,
}


def voltage(samples: int = SAMPLES, pace: float = 1.0) -> Array:
    """0 to 150 V, from 0 V on, shape (samples,): a slow sine, waxing and waning, `pace` as fast."""
    time = pace * SAMPLE_PERIOD * np.arange(samples)
    amplitude = 75.0 * (0.6 + 0.4 * np.cos(2.0 * np.pi * 0.11 * time))
    wave: Array = amplitude * (1.0 - np.cos(2.0 * np.pi * 1.3 * time))
    return wave


def recording(model: Model, samples: int = SAMPLES, seed: int = 1, pace: float = 1.0) -> Recording:
    """What the rig shows for `voltage`, with the sensor's noise."""
    driven = voltage(samples, pace)
    noisy = model.with_link("sensor_noise", std=NOISE, seed=float(seed))
    shown = simulate(noisy, driven, SAMPLE_PERIOD, random=True)
    return Recording(f"run {seed}", SAMPLE_PERIOD, driven, shown)


def mistuned(model: Model) -> Model:
    """The model that a fit starts from."""
    return model.with_values({key: model.value(*key) * f for key, f in MISTUNED.items()})


def nominal_values() -> dict[str, float]:
    """The nominal chain's parameters, by their names alone."""
    model = nominal_model()
    return {**model.values("bouc_wen"), **model.values("second_order")}


def mechanics_step() -> Array:
    """The nominal mechanics' difference equation at a held voltage, exact, shape (5,)."""
    timing = Timing.divide(SAMPLE_PERIOD, {0.0}, set(), ramped=False)
    values = nominal_model().values("second_order")
    row: Array = second_order.prepare(values, timing, np.zeros(LEVELS)).coefficients[0]
    return row
