"""How old readings are, where the sensor converts on a clock of its own.

With conversions every `clock`, sample k shows the position (age + k T) mod clock before it, where
`age` is that of the first reading. What would be read at any age is put together from responses
that are late by parts of a sample and by whole ones.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.signals import Array
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Model

DELAY = "transport_delay"
PARTS = 64  # of a sample, by which responses are late: a stiff rig jumps from one to the next
TELLING = 2000  # samples that are compared, those of the fastest motion
AGES, ROUNDS = 32, 4  # first ages that are tried, and how often closer ones around the best
CLOSER = 4.0

Indices = NDArray[np.intp]


def can_be_late(model: Model, sample_period: float) -> bool:
    """Whether a model's response may come up to another sample later: a delay has a range."""
    return _delay(model) + sample_period <= registry()[DELAY].parameter("delay").high


def _delay(model: Model) -> float:
    return model.value(DELAY, "delay") if DELAY in model.settings else 0.0


@dataclass(frozen=True)
class Late:
    """Responses of a model to one voltage, m, shape (PARTS, n), each later by a part of a sample.

    `measured`, m, shape (n,), is what was read, `counted` which of the samples count.
    """

    rows: Array
    sample_period: float
    measured: Array
    counted: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        model: Model,
        respond: Callable[[Model], Array],
        sample_period: float,
        measured: Array,
        counted: NDArray[np.bool_],
    ) -> Late:
        """`respond` simulates a model, m, shape (n,); the sensor's clock is left out."""
        model = model.unclocked()
        delays = [_delay(model) + part * sample_period / PARTS for part in range(PARTS)]
        rows = [respond(model.with_link(DELAY, delay=one)) for one in delays]
        return cls(np.array(rows), sample_period, measured, counted)

    @property
    def duration(self) -> float:
        """Of the recording, s."""
        return len(self.measured) * self.sample_period

    @cached_property
    def error(self) -> Array:
        """What is read beside a response that is not late, m, shape (n,); 0 if not counted."""
        error = np.where(self.counted, self.measured - self.rows[0], 0.0)
        return np.asarray(error - self.counted * np.mean(error[self.counted]))

    @cached_property
    def motion(self) -> Array:
        """How far a response that is not late goes in a sample period, m, shape (n,)."""
        motion: Array = np.gradient(self.rows[0])
        return motion

    @cached_property
    def telling(self) -> Indices:
        """The samples, of those that count, at which the age of a reading shows most."""
        counted = np.flatnonzero(self.counted)
        slowest_last = np.argsort(-np.abs(self.motion[counted]), kind="stable")
        return np.sort(counted[slowest_last[:TELLING]])

    def left(self, clock: float, age: float, ahead: float = 0.0) -> float:
        """What ages leave of the telling samples, m rms, if the response came `ahead` s earlier."""
        ages = np.mod(age + self.telling * self.sample_period, clock) - ahead
        return self._left(ages)

    def left_without(self, ahead: float) -> float:
        """The same, m rms, of readings that are all of one age."""
        return self._left(np.full(len(self.telling), -ahead))

    def first_age(self, clock: float, ahead: float = 0.0) -> tuple[float, float]:
        """The age of the first reading, s, that leaves the least, and what it leaves, m rms."""
        spacing = clock / AGES
        tried = spacing * np.arange(AGES)
        for _ in range(ROUNDS):
            left, age = min((self.left(clock, age, ahead), age) for age in tried.tolist())
            spacing /= CLOSER
            tried = np.mod(age + spacing * np.arange(-CLOSER, CLOSER + 1.0), clock)
        return age, left

    def _left(self, ages: Array) -> float:
        samples = self.telling
        return float(np.std(self.measured[samples] - self._at(samples, ages)))

    def _at(self, samples: Indices, ages: Array) -> Array:
        """The response some ages, s, before some samples, m; straight between what is known."""
        parts = ages * (PARTS / self.sample_period)
        whole = np.floor(parts)
        share, number = parts - whole, whole.astype(np.intp)
        return (1.0 - share) * self._row(samples, number) + share * self._row(samples, number + 1)

    def _row(self, samples: Indices, number: Indices) -> Array:
        """The response so many parts of a sample before some samples, m."""
        at = np.clip(samples - number // PARTS, 0, self.rows.shape[1] - 1)
        found: Array = self.rows[number % PARTS, at]
        return found
