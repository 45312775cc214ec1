"""Sparse regression of what the refit leaves, on a library of terms that each stand for an effect.

Sequentially thresholded least squares (Brunton, Proctor and Kutz 2016), the algorithm of pysindy,
used as a discrepancy model (Kaheman et al. 2019). The terms are courses of the voltage u, of the
predicted displacement x and of time; what they are multiplied by is found, how they look inside (a
threshold, a time constant) is given.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.findings import PARAMETERS
from microgripper_control.effects.registry import registry
from microgripper_control.effects.transmission.backlash import played
from microgripper_control.examination.beside.evidence import Begun, Rest, rmse_without

THRESHOLD = 0.1  # of the residual: a term that contributes less goes (pysindy's bounds a weight)
ROUNDS = 20
MAINS = (50.0, 60.0)  # Hz


@dataclass(frozen=True)
class Frame:
    """The middle and half the span of voltage (V) and prediction (m) in training."""

    voltage: tuple[float, float]
    position: tuple[float, float]

    @classmethod
    def around(cls, training: Sequence[Rest]) -> Frame:
        """The frame of the recordings that are fitted."""
        return cls(
            _middle_and_half([rest.recording.voltage for rest in training]),
            _middle_and_half([rest.predicted for rest in training]),
        )


@dataclass(frozen=True)
class Signals:
    """What terms are made of: u and x between about -1 and 1, time in s, rates in 1/s."""

    u: Array
    x: Array
    time: Array
    period: float

    @classmethod
    def of(cls, rest: Rest, frame: Frame) -> Signals:
        """Of one recording."""
        recording = rest.recording
        time = recording.elapsed
        u = (recording.voltage - frame.voltage[0]) / frame.voltage[1]
        x = (rest.predicted - frame.position[0]) / frame.position[1]
        return cls(u, x, time, recording.sample_period)

    def rate(self, signal: Array) -> Array:
        """How fast a signal changes."""
        return np.gradient(signal) / self.period


Term = Callable[[Signals], Array]


def _ahead(constant: float) -> Term:
    """What u is ahead of its own past, seen through a time constant, s."""

    def term(s: Signals) -> Array:
        keep = float(np.exp(-s.period / constant))
        start = np.array([keep * s.u[0]])
        smooth: Array = lfilter([1.0 - keep], [1.0, -keep], s.u, zi=start)[0]
        return s.u - smooth

    return term


def _beyond(bend: float) -> Term:
    return lambda s: np.maximum(s.x - bend, 0.0)


def _hum(frequency: float, shift: float) -> Term:
    return lambda s: np.sin(2.0 * np.pi * (frequency * s.time + shift))


def _play(s: Signals, width: float = 0.04) -> Array:
    """x less x behind a play."""
    return s.x - played(s.x, width)


# Each effect's terms; a mean and a slope over u stay out: the refit has had those. transport_delay
# has none, for its first order is the lags' u' and x', nor has sensor_quantization.
TERMS: dict[str, tuple[Term, ...]] = {
    "amplifier_lag": (lambda s: s.rate(s.u), lambda s: s.rate(s.rate(s.u))),
    "slew_limit": (lambda s: s.rate(s.u) * np.abs(s.rate(s.u)),),
    "saturation": (lambda s: np.maximum(s.u - 0.8, 0.0), lambda s: np.minimum(s.u + 0.8, 0.0)),
    "creep": tuple(_ahead(constant) for constant in (0.1, 1.0, 10.0)),
    "rate_dependent_hysteresis": (
        lambda s: np.sign(s.rate(s.u)) * np.log1p(np.abs(s.rate(s.u))),
        lambda s: s.u * np.log1p(np.abs(s.rate(s.u))),
    ),
    "asymmetric_hysteresis": (lambda s: s.u * np.tanh(10.0 * s.rate(s.u)), lambda s: s.u**2),
    "nonlinear_stiffness": (lambda s: s.x**2, lambda s: s.x**3),
    "contact": tuple(_beyond(bend) for bend in (0.0, 0.4, 0.8)),
    "friction": (lambda s: np.tanh(10.0 * s.rate(s.x)),),
    "restoring_force_hysteresis": (lambda s: s.x * np.tanh(10.0 * s.rate(s.x)),),
    "backlash": (_play,),
    "extra_resonance": (lambda s: s.rate(s.rate(s.x)),),
    "sensor_lag": (lambda s: s.rate(s.x),),
    "thermal_drift": (lambda s: s.time, lambda s: s.time**2),
    "mains_hum": tuple(_hum(f, shift) for f in MAINS for shift in (0.0, 0.25)),
}


def regress(begun: Begun, withheld: Sequence[str] = ()) -> tuple[str, str | None, float]:
    """The effect whose terms carry most, its stage, and the error on the held-out samples, m."""
    owners = [name for name, terms in TERMS.items() if name not in withheld for _ in terms]
    training, judging = begun.training(), begun.judging()
    frame = Frame.around(training)
    matrix = np.concatenate([_centred(rest, frame, withheld) for rest in training])
    target = np.concatenate([rest.left[rest.counted] for rest in training])
    weights = stlsq(matrix, target)
    said = [_matrix(rest, frame, withheld) @ weights for rest in judging]
    rmse = rmse_without(judging, said)
    shares: dict[str, float] = {}
    for name, column, weight in zip(owners, matrix.T, weights, strict=True):
        if weight:
            shares[name] = shares.get(name, 0.0) + float(weight**2 * (column @ column))
    if not shares:
        return PARAMETERS, None, rmse
    first = max(shares, key=lambda name: shares[name])
    return first, registry()[first].stage.value, rmse


def stlsq(matrix: Array, target: Array, threshold: float = THRESHOLD) -> Array:
    """Least squares; terms that contribute less than `threshold` of the target go, and again."""
    sizes = np.linalg.norm(matrix, axis=0)
    kept = sizes > 0.0
    least = threshold * float(np.linalg.norm(target))
    weights = np.zeros(len(sizes))
    for _ in range(ROUNDS):
        weights[:] = 0.0
        if not kept.any():
            break
        scaled = matrix[:, kept] / sizes[kept]
        weights[kept] = np.linalg.lstsq(scaled, target, rcond=1e-9)[0] / sizes[kept]
        small = kept & (np.abs(weights) * sizes < least)
        if not small.any():
            break
        kept &= ~small
    return weights


def _matrix(rest: Rest, frame: Frame, withheld: Sequence[str]) -> Array:
    signals = Signals.of(rest, frame)
    named = (terms for name, terms in TERMS.items() if name not in withheld)
    return np.stack([term(signals) for terms in named for term in terms], axis=1)


def _centred(rest: Rest, frame: Frame, withheld: Sequence[str]) -> Array:
    """The counted samples less their mean, as in what is left: a recording's zero is its own."""
    counted = _matrix(rest, frame, withheld)[rest.counted]
    return np.asarray(counted - counted.mean(axis=0))


def _middle_and_half(signals: Sequence[Array]) -> tuple[float, float]:
    low = min(float(np.min(signal)) for signal in signals)
    high = max(float(np.max(signal)) for signal in signals)
    return (low + high) / 2.0, (high - low) / 2.0 or 1.0
