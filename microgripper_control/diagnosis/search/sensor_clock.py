"""The clock on which a sensor converts, read off what a delay or a lag of the sensor leaves.

Readings that are held between conversions are now older, now younger than the mean. What a model
with the mean lag leaves is then the motion times a sawtooth, whose lines, folded by the sampling,
stand in the spectrum of error times motion. Which multiple and which fold a line is, and how old
the readings are, is told by what each leaves.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from microgripper_control.core.recording import same_period
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.evidence import Evidence
from microgripper_control.diagnosis.fits.trial import Trial, problem_of
from microgripper_control.identification.nuisance import late
from microgripper_control.identification.reading_age import Late

LINES = 4  # of the spectrum that are looked into
APART = 40  # of its widths: closer ones belong to one
FINER = 8  # places of the spectrum for each of its widths
MULTIPLES = 6  # of the clock's rate that may be the strongest line
PHASES = 16  # of a sawtooth, and first ages, that are tried
RATES = 2  # conversions a sample, whole ones aside, that are looked at more closely
# Of the error's power: what a sawtooth takes away of it where there is a clock. Of readings that
# show a step or not yet, and few do not, it fits the pattern badly.
SHOWN = 0.1
FASTEST, SLOWEST = 12, 60  # conversions in a sample, samples in a conversion
AHEAD = np.arange(-1.0, 1.6, 0.125)  # of the clock: what the lag may be too long by
CLEAR = 0.8  # of what is left without a clock: where one leaves more, there is none
NEARBY = 0.1  # of the clock, or a conversion in a recording: how far a closer clock is looked for
BEST = 8  # clocks that are looked for more closely,
LIKELY = 3  # and that are tried: how long a lag is without a clock misleads,
AS_LIKELY = 1.25  # if they leave no more than so many times what the best leaves


def on_its_clocks(evidence: Evidence, trial: Trial) -> list[tuple[Evidence, float]]:
    """The evidence with each likely clock of the sensor and the ages of readings.

    `trial` explains it by a mean lag; with each comes by how much that is then too long, s.
    """
    views = _views(evidence, trial)
    telling = _telling(views)
    # The same clock beats at another rate with samples of another period.
    alike = [view for view in views if same_period(view.sample_period, telling.sample_period)]
    rates = _rates(alike)
    if not rates:
        return []
    shares = [max(_share(view, rate) for rate in rates) for view in alike]
    if np.mean(shares) < SHOWN:
        return []
    return [(_timed(evidence, views, found), found.ahead) for found in _clocks(telling, rates)]


def retimed(evidence: Evidence, trial: Trial) -> tuple[Evidence, float]:
    """The evidence with a closer clock and closer ages, from an explanation that has the clock.

    With it comes by how much the lag is then too long, s: where the voltage is held, a fit finds no
    slope to tell it by.
    """
    views = _views(evidence, trial)
    telling, clock = _telling(views), evidence.scales.clock
    age, left = telling.first_age(clock)
    found = _closer(telling, Reading(left, clock, age, 0.0))
    return _timed(evidence, views, found), found.ahead


class Reading(NamedTuple):
    """What a clock leaves of a recording, m rms, and with what first age and lag, s."""

    left: float
    clock: float
    age: float
    ahead: float  # by how much the lag is too long


def _telling(views: Sequence[Late]) -> Late:
    return max(views, key=lambda view: float(np.std(view.error)))


def _timed(evidence: Evidence, views: Sequence[Late], found: Reading) -> Evidence:
    ages = [view.first_age(found.clock, found.ahead)[0] for view in views]
    return evidence.clocked(found.clock, ages)


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


def _clocks(view: Late, rates: Sequence[float]) -> list[Reading]:
    """The clocks that leave least of a recording, of those that leave clearly less than none does.

    Each rate may be its mirror image.
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
        looked.append(
            min(Reading(view.left(clock, a, ahead), clock, a, ahead) for a, ahead in tried)
        )
    closer = sorted(_closer(view, reading) for reading in sorted(looked)[:BEST])
    most = min(CLEAR * _left_without(view, closer[0]), AS_LIKELY * closer[0].left)
    return [reading for reading in closer[:LIKELY] if reading.left < most]


def _left_without(view: Late, reading: Reading) -> float:
    """What readings that are all as old as those of a clock on average leave, m rms."""
    mean = reading.ahead - 0.5 * reading.clock
    bounds = mean - reading.clock, mean + reading.clock
    return float(minimize_scalar(view.left_without, bounds=bounds, method="bounded").fun)


def _closer(view: Late, reading: Reading) -> Reading:
    """A reading near another that leaves less."""
    drift = reading.clock**2 / view.duration  # of the clock, by one conversion in the recording
    scale = np.array([drift, reading.clock, reading.clock])
    start = np.array(reading[1:])

    def left(x: Array) -> float:
        return view.left(*(start + x * scale))

    simplex = np.vstack([np.zeros(3), NEARBY * np.eye(3)])
    found = minimize(left, np.zeros(3), method="Nelder-Mead", options={"initial_simplex": simplex})
    clock, age, ahead = (start + found.x * scale).tolist()
    return Reading(float(found.fun), clock, age, ahead)
