"""What belongs to a recording and not to the rig.

No input explains a recording's displacement zero, the h it starts with, the phase of a hum or the
course of a drift, so they are fitted wherever a model is compared with a recording. All but the
initial h (`initial_hysteresis.py`) enter linearly, as weights of known courses, and are solved for
exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import SHORTEST, Recording
from microgripper_control.core.signals import Array
from microgripper_control.effects.registry import registry
from microgripper_control.identification.initial_hysteresis import least_squares_h
from microgripper_control.identification.orthonormal import orthonormal
from microgripper_control.identification.reading_age import Late
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Initial, sensed, simulate

Mask = NDArray[np.bool_]

BLOCKS = 10
HARDLY_SEEN = 3e-5  # of the best seen courses: what died away before the samples gets no weight
LATELY = 4  # answers that are kept: the best was one of the last that were looked at
FORGOTTEN = 1e-4  # of the most that h changes: what changes less need not be simulated again


@dataclass(frozen=True)
class Conditions:
    """How a recording was made: the voltage between samples and the state it starts in."""

    hold: Hold = Hold.ZERO
    initial: Initial = Initial.FIRST_SAMPLE

    @property
    def knows_initial_hysteresis(self) -> bool:
        """Whether h at the first sample follows from the conditions."""
        return self.initial is not Initial.FIRST_SAMPLE

    def answered(self, recording: Recording) -> Mask:
        """The samples of a recording that the voltage in it explains, shape (n,).

        The first ones answer to what was before them, known only from rest or a period.
        """
        counted: Mask = recording.explained.copy()
        if self.initial is Initial.FIRST_SAMPLE:
            counted[: recording.unsettled()] = False
        return counted


@dataclass(frozen=True)
class Nuisance:
    """One recording's own values: its initial h, m, and the weight of each of its courses, m.

    `reading`, m, is one that lies in its middle: a grid of the sensor is counted from there, since
    where the grid lies moves with the recording's zero. `reading_age`, s, is how old the first
    reading is where the sensor converts on a clock of its own.
    """

    initial_hysteresis: float = 0.0
    weights: tuple[float, ...] = ()
    reading: float = 0.0
    reading_age: float = 0.0


def zero_of(model: Model, nuisance: Nuisance) -> float:
    """What the sensor shows at x = 0, m, beyond what the model says: the first course is that."""
    return nuisance.weights[0] if nuisance.weights and has_own_zero(model) else 0.0


def has_own_zero(model: Model) -> bool:
    """Whether each recording has a zero of its own, as it has unless the model fixes it."""
    return "sensor_zero" not in model.settings


def courses(model: Model, recording: Recording) -> Array:
    """What the weights multiply, shape (p, n): the zero, unless frozen, then each link's own."""
    rows: list[Array] = []
    if has_own_zero(model):
        rows.append(np.ones((1, len(recording))))
    rows += _by_link(model, recording).values()
    return np.concatenate([np.zeros((0, len(recording))), *rows])


def own_courses(
    model: Model, recording: Recording, nuisance: Nuisance
) -> dict[str, tuple[Array, Array]]:
    """Of each link that has courses their weights, m, shape (p,), and themselves, shape (p, n)."""
    shapes = _by_link(model, recording)
    first = len(nuisance.weights) - sum(map(len, shapes.values()))  # the zero's comes before theirs
    found = {}
    for name, rows in shapes.items():
        weights, first = nuisance.weights[first : first + len(rows)], first + len(rows)
        if weights:
            found[name] = np.array(weights), rows
    return found


def _by_link(model: Model, recording: Recording) -> dict[str, Array]:
    time = recording.elapsed
    return {name: registry()[name].courses(model.values(name), time) for name in model.settings}


def response(model: Model, recording: Recording, conditions: Conditions, h: float) -> Array:
    """The model's displacement for a recording's voltage, m, shape (n,), without its courses.

    It is not rounded to a sensor's grid either: what is rounded has no slope to fit by.
    """
    return simulate(
        model.without(model.rounding) if model.rounding else model,
        recording.voltage,
        recording.sample_period,
        hold=conditions.hold,
        initial=conditions.initial,
        initial_hysteresis=h,
        reading_age=recording.reading_age,
    )


def predict(
    model: Model, recording: Recording, conditions: Conditions, nuisance: Nuisance
) -> Array:
    """The model's prediction of a recording's displacement, m, shape (n,)."""
    recording = replace(recording, reading_age=nuisance.reading_age)
    shown = response(model, recording, conditions, nuisance.initial_hysteresis)
    if nuisance.weights:
        shown = shown + np.array(nuisance.weights) @ courses(model, recording)
    for name in model.rounding:
        from_there = shown - nuisance.reading
        shown = sensed(model, name, from_there, recording.sample_period) + nuisance.reading
    return shown


def refuse_divergence(recording: Recording, prediction: Array) -> None:
    """Raise MicrogripperError where a model's answer to a recording's voltage is not finite."""
    if not np.all(np.isfinite(prediction)):
        least, most = float(recording.voltage.min()), float(recording.voltage.max())
        raise MicrogripperError(
            f"{recording.name}: the model's answer to {least:g} .. {most:g} V is not finite; is "
            "the voltage in volts? --map voltage=NAME*SCALE"
        )


def largest_hysteresis(model: Model, recording: Recording) -> float:
    """A generous bound on |h|, m: what travel from zero to the largest voltage could build up.

    Before the recording, that is anywhere in the range of the drive: a small loop, or the first
    stretch of a recording, may begin with an h that it could not build up by itself.
    """
    d, alpha = model.value("bouc_wen", "d"), model.value("bouc_wen", "alpha")
    largest = max(float(np.max(np.abs(recording.voltage))), *map(abs, model.voltage_range))
    return 3.0 * alpha * d * largest


@dataclass(frozen=True)
class Projection:
    """Removes from a signal what its courses could explain; `basis` (n, p) is orthonormal."""

    basis: Array

    @classmethod
    def off(cls, shapes: Array) -> Projection:
        """The projection off courses, shape (p, n), all about 1 where they are seen at all.

        What they hardly show is left: of courses that are nearly one, as of creep that is slower
        than a recording is long, the rest is rounding, directions of no meaning and others after
        the smallest change.
        """
        if len(shapes) == 1:  # most often the zero alone
            return cls(shapes.T / np.linalg.norm(shapes))
        return cls(orthonormal(shapes, HARDLY_SEEN).T)

    def __call__(self, signal: Array) -> Array:
        """What is left of a signal of shape (n,), or of several, shape (n, p)."""
        # With a single column, most often the zero's, numpy's `@` takes nine times as long.
        left: Array = signal - np.dot(self.basis, np.dot(self.basis.T, signal))
        return left


def course_weights(shapes: Array, error: Array) -> tuple[float, ...]:
    """Least-squares weights, m, of courses, shape (p, n), in an error, m, shape (n,).

    What the courses hardly show gets none.
    """
    weights, *_ = np.linalg.lstsq(shapes.T, error, rcond=HARDLY_SEEN)
    return tuple(map(float, weights))


def fit_nuisance(
    model: Model, recording: Recording, conditions: Conditions, used: Mask | None = None
) -> Nuisance:
    """Least-squares nuisance values on the samples `used` (shape (n,), all if None).

    Deterministic: whoever repeats it looks at the same places and gets the same.
    """
    mask = conditions.answered(recording)
    if used is not None:
        mask &= used
    if model.clock > 0.0:
        own = fit_nuisance(model.unclocked(), recording, conditions, used)
        recording = in_time(model, recording, conditions, mask, own.initial_hysteresis)
    shapes = courses(model, recording)[:, mask]
    bound = largest_hysteresis(model, recording)
    if conditions.knows_initial_hysteresis or bound <= 0.0:
        h, error = 0.0, recording.measured - response(model, recording, conditions, 0.0)
    else:
        answer = _by_hysteresis(model, recording, conditions, bound)
        without = Projection.off(shapes)
        h = least_squares_h(lambda h: without((recording.measured - answer(h))[mask]), bound)
        error = recording.measured - answer(h)
    reading = middle_reading(recording, mask)
    return Nuisance(h, course_weights(shapes, error[mask]), reading, recording.reading_age)


def late(model: Model, recording: Recording, conditions: Conditions, used: Mask, h: float) -> Late:
    """A recording beside a model's responses that come later by parts of a sample."""
    return Late.of(
        model,
        lambda other: response(other, recording, conditions, h),
        recording.sample_period,
        recording.measured,
        used,
    )


def in_time(
    model: Model, recording: Recording, conditions: Conditions, used: Mask, h: float
) -> Recording:
    """A recording with the age of its first reading after a model whose sensor has a clock."""
    age, _ = late(model, recording, conditions, used, h).first_age(model.clock)
    return replace(recording, reading_age=age)


def all_in_time(
    model: Model, recordings: Sequence[Recording], conditions: Conditions
) -> tuple[Recording, ...]:
    """The same of all recordings; they are left as they are if the sensor has no clock."""
    if model.clock == 0.0:
        return tuple(recordings)
    return tuple(
        replace(one, reading_age=fit_nuisance(model, one, conditions).reading_age)
        for one in recordings
    )


def middle_reading(recording: Recording, used: Mask) -> float:
    """The reading in the middle of some samples (shape (n,)) of a recording, m."""
    return float(np.percentile(recording.measured[used], 50.0, method="nearest"))


def _by_hysteresis(
    model: Model, recording: Recording, conditions: Conditions, bound: float
) -> Callable[[float], Array]:
    """The response as a function of an initial h within +-bound, m.

    A recording forgets sooner or later what it began with: only until then is each h simulated.
    """
    anew = lru_cache(LATELY)(partial(response, model, recording, conditions))
    if conditions.hold is Hold.BANDLIMITED:  # the beginning knows of what comes after it
        return anew
    low, high = anew(-bound), anew(bound)
    apart = np.abs(high - low)
    remembered = np.flatnonzero(apart > FORGOTTEN * np.max(apart))
    if not len(remembered):
        return anew
    until = max(SHORTEST, int(remembered[-1]) + 1)
    voltage = recording.voltage[:until]
    beginning = Recording(
        recording.name, recording.sample_period, voltage, reading_age=recording.reading_age
    )
    ends = {-bound: low, bound: high}

    @lru_cache(LATELY)
    def answer(h: float) -> Array:
        if h in ends:
            return ends[h]
        return np.append(response(model, beginning, conditions, h), high[until:])

    return answer


def blocks(length: int, odd: bool) -> Mask:
    """Samples in blocks 1, 3, 5, 7, 9 (`odd`) or 2, 4, 6, 8, 10 of ten equal ones."""
    number = np.arange(length) * BLOCKS // length
    chosen: Mask = number % 2 == (0 if odd else 1)
    return chosen


class Heldout(NamedTuple):
    """What a model says of a held-out recording, m, shape (n,), and where its error counts.

    `zero`, m, is what the sensor shows at x = 0.
    """

    prediction: Array
    counted: Mask
    zero: float


def heldout_prediction(model: Model, recording: Recording, conditions: Conditions) -> Heldout:
    """Predict a held-out recording.

    Only the nuisance values are fitted, on the odd blocks; errors are taken on the even ones.
    """
    nuisance = fit_nuisance(model, recording, conditions, blocks(len(recording), odd=True))
    prediction = predict(model, recording, conditions, nuisance)
    counted = blocks(len(recording), odd=False) & conditions.answered(recording)
    return Heldout(prediction, counted, zero_of(model, nuisance))
