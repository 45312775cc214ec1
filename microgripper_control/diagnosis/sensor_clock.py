"""The clock on which a sensor converts, read off what a delay or a lag of the sensor leaves.

Readings that are held between conversions are now older, now younger than the mean. What a model
with the mean lag leaves is then the motion times a sawtooth, whose lines, folded by the sampling,
stand in the spectrum of error times motion. Which multiple and which fold a line is, and how old
the readings are, is told by what each leaves.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.evidence import Evidence
from microgripper_control.diagnosis.trial import Trial, problem_of
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import late
from microgripper_control.identification.reading_age import Late

LINES = 4  # of the spectrum that are looked into
APART = 40  # of its widths: closer ones belong to one
FINER = 8  # places of the spectrum for each of its widths
MULTIPLES = 6  # of the clock's rate that may be the strongest line
PHASES = 16  # of a sawtooth, and first ages, that are tried
RATES = 2  # conversions a sample, whole ones aside, that are looked at more closely
SHOWN = 0.35  # of the error's power: what a sawtooth takes away of it where there is a clock
FASTEST, SLOWEST = 12, 60  # conversions in a sample, samples in a conversion
AHEAD = np.arange(-1.0, 1.6, 0.125)  # of the clock: what the lag may be too long by
CLEAR = 0.8  # of what is left without a clock: where one leaves more, there is none
BEST = 8  # clocks whose first age is looked for more closely


def has_clock(trial: Trial) -> bool:
    """Whether an explanation has a link that may read on a clock of the sensor's own."""
    return any(registry()[name].clocked for name in trial.effects)


def on_its_clock(evidence: Evidence, trial: Trial) -> Evidence:
    """The evidence with the sensor's clock and the ages of readings; as it is if there is none.

    `trial` explains it by a mean lag.
    """
    views = _views(evidence, trial)
    rates = _rates(views)
    if not rates:
        return evidence
    shares = [max(_share(view, rate) for rate in rates) for view in views]
    if np.mean(shares) < SHOWN:
        return evidence
    telling = max(views, key=lambda view: float(np.std(view.error)))
    clock, ahead = _clock(telling, rates)
    if clock == 0.0:
        return evidence
    ages = [view.first_age(clock, ahead)[0] for view in views]
    return evidence.clocked(clock, ages)


def _views(evidence: Evidence, trial: Trial) -> list[Late]:
    """Of each fitted recording the responses that are late by parts of a sample."""
    problem = problem_of(evidence, trial.model, trial.free)
    initial = problem.initial_hysteresis(problem.point(trial.model, trial.initial_hysteresis))
    return [
        late(trial.model, recording, evidence.conditions, mask, h)
        for recording, mask, h in zip(evidence.fitted, problem.masks, initial, strict=True)
    ]


def _lines(views: Sequence[Late]) -> list[float]:
    """The strongest lines in error times motion, cycles a sample, those of all recordings added."""
    longest = max(len(view.error) for view in views)
    size = 1 << int(FINER * longest).bit_length()
    power: Array = np.zeros(size // 2 + 1)
    for view in views:
        beat = view.error * view.motion
        power += np.abs(np.fft.rfft(beat, size)) ** 2 / max(float(beat @ beat), 1e-300)
    width = APART * size // longest
    power[:width] = 0.0  # the mean lag is not right
    found = []
    for _ in range(LINES):
        at = int(np.argmax(power))
        if power[at] == 0.0:  # a short recording has room for few
            break
        found.append(at / size)
        power[max(0, at - width) : at + width] = 0.0
    return found


def _rates(views: Sequence[Late]) -> list[float]:
    """The likeliest conversions a sample, whole ones aside; a mirror image explains as much."""
    width = 1.0 / max(len(view.error) for view in views)
    rates = [
        (fold + line) / multiple
        for line in _lines(views)
        for multiple in range(1, MULTIPLES + 1)
        for fold in range(multiple)
    ]
    rates.sort(key=lambda rate: -sum(_explained(view, rate) for view in views))
    found: list[float] = []
    for rate in rates:
        if len(found) < RATES and all(_apart(rate, other) > width for other in found):
            found.append(rate)
    return found


def _apart(rate: float, other: float) -> float:
    """How far two rates are from each other, or from each other's mirror image, at the least."""
    return min(abs(rate - other), abs(rate + other - 1.0))


def _explained(view: Late, rate: float) -> float:
    """What power of a recording's error, m^2, its motion times a sawtooth takes away."""
    samples = view.telling
    motion, error = view.motion[samples], view.error[samples]
    best = 0.0
    for phase in np.arange(PHASES) / PHASES:  # rising or, as its mirror image, falling
        beat = motion * (np.mod(phase + rate * samples, 1.0) - 0.5)
        best = max(best, float(beat @ error) ** 2 / max(float(beat @ beat), 1e-300))
    return best


def _share(view: Late, rate: float) -> float:
    """The same, of the error's power where the age of a reading shows most."""
    error = view.error[view.telling]
    return _explained(view, rate) / max(float(error @ error), 1e-300)


def _clock(view: Late, rates: Sequence[float]) -> tuple[float, float]:
    """The clock that leaves least of a recording, and by how much the lag is then too long, s.

    Each rate may be its mirror image. Zeros if none leaves clearly less than there is.
    """
    images = [image for rate in rates for image in (rate, 1.0 - rate)]
    clocks = [
        view.sample_period / (image + whole)
        for image, whole in product(images, range(FASTEST))
        if image + whole > 1.0 / SLOWEST
    ]
    looked = []
    for clock in clocks:
        tried = product(np.arange(PHASES) * clock / PHASES, AHEAD * clock)
        looked.append((*min((view.left(clock, a, ahead), ahead) for a, ahead in tried), clock))
    closer = [
        (view.first_age(clock, ahead)[1], ahead, clock) for _, ahead, clock in sorted(looked)[:BEST]
    ]
    left, ahead, clock = min(closer)
    without = min(view.left_without((share - 0.5) * clock) for share in AHEAD.tolist())
    return (clock, ahead) if left < CLEAR * without else (0.0, 0.0)
