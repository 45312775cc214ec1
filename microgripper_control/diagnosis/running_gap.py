"""The gap between a rig and its model while the rig works, over a sliding window.

The model runs beside the rig, one sample at a time. What belongs to a recording and not to the rig
is taken off each window, as `identification.nuisance` takes it off a whole recording: the zero, and
the courses of links. For the hysteresis from before the comparison began, the model runs twice,
from none and from a large one. How far the two are apart is what it can do: it is taken off as
well, and vanishes as the rig moves.

So a window does not show what is slower than itself, a drift or creep over minutes. A diagnosis of
a longer recording does. Nor does it show what the sensor could make of a right model: rounding, and
an age of the readings that is not known where the sensor converts on a clock of its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.core.sliding import Sliding
from microgripper_control.diagnosis.data.noise import ORDER, usual_innovation
from microgripper_control.effects.registry import registry
from microgripper_control.identification.nuisance import Projection, has_own_zero
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Plant

FEWEST = 4 * ORDER  # samples in a window
UNANSWERED = 0.5  # s, at least 10 samples: they answer to a voltage from before the beginning
FARTHEST = 1.0  # m: an error beyond it is a model that has run away, or no reading at all
FORGOTTEN = 1e-4  # of the large hysteresis: less of it is not looked for
BENT = 0.1  # of what the hysteresis before can do: what is left of it, as it is not linear
MOVING = 0.01  # of the voltage range: below it there is nothing that a model could be wrong about
CLEARED = 0.8  # of the gap that is too large: where the model holds again


@dataclass(frozen=True)
class Reading:
    """One window: root mean squares, m."""

    gap: float  # measured minus simulated
    noise_floor: float  # what of it nothing could predict
    doubt: float  # what the hysteresis from before the beginning may still add to the gap
    moving: bool  # whether the voltage moved

    @property
    def ratio(self) -> float:
        """The gap in noise floors."""
        return self.gap / self.noise_floor if self.noise_floor > 0.0 else math.inf


class RunningGap:
    """Compares a model with a rig; `sample_period` and `window` in s."""

    def __init__(self, model: Model, sample_period: float, window: float) -> None:
        low, high = model.voltage_range
        self._span = high - low
        self._large = model.value("bouc_wen", "alpha") * model.value("bouc_wen", "d") * self._span
        self._model = model
        # Predictions leave out what is random, and rounding: nobody foretells either.
        random = [link.name for link in model.links if link.random]
        self._predicting = model.without([*random, *model.rounding])
        self._rounding = max(
            (model.value(name, "resolution") for name in model.rounding), default=0.0
        ) / math.sqrt(12.0)
        self._period = sample_period
        self._unanswered = max(10, math.ceil(UNANSWERED / sample_period))
        # By sample: tick, voltage, place, error, and what the hysteresis before can do.
        self._window = Sliding(max(FEWEST, round(window / sample_period)), 5)
        self._plants: tuple[Plant, Plant] | None = None
        self._first = self._newest = 0  # ticks
        self._voltage = 0.0

    def restart(self) -> None:
        """Begin again with the next sample."""
        self._plants = None
        self._window.clear()

    def sample(self, tick: int, voltage: float, displacement: float) -> None:
        """Take a sample of the rig: its number, u[k] in V, x[k] in m, all finite.

        Through samples that are missing the voltage is taken as held. One that does not come after
        those before it is ignored.
        """
        if self._plants is None:
            self._begin(tick, voltage)
        elif tick <= self._newest:
            return
        for _ in range(self._newest + 1, tick):
            self._step(self._voltage)
        self._newest = tick
        simulated, otherwise = self._step(voltage)
        error, apart = displacement - simulated, otherwise - simulated
        if not (abs(error) < FARTHEST and abs(apart) < FARTHEST):
            self.restart()
        elif tick - self._first >= self._unanswered:
            self._window.append((tick, voltage, simulated, error, apart))

    def reading(self) -> Reading | None:
        """The newest window; None until it is full."""
        if not self._window.is_full:
            return None
        tick, voltage, place, error, remembered = self._window.columns
        before = float(np.ptp(remembered))
        shapes = self._courses((tick - tick[0]) * self._period)
        if before > FORGOTTEN * self._large:
            shapes.append(remembered[None] / before)
        left = Projection.off(np.concatenate(shapes))(error)
        gap = float(np.sqrt(np.mean(left**2)))
        return Reading(
            gap=gap,
            # A sample that is missing here and there makes the next one little harder to predict.
            noise_floor=min(gap, max(usual_innovation(left), self._rounding, self._aged(place))),
            doubt=BENT * before,
            moving=bool(np.ptp(voltage) >= MOVING * self._span),
        )

    def _aged(self, place: Array) -> float:
        """What the age of a reading makes of places, m: when a sensor converts, nobody knows."""
        return self._model.clock / self._period * float(np.sqrt(np.mean(np.diff(place) ** 2)))

    def _begin(self, tick: int, voltage: float) -> None:
        self._plants = (
            Plant(self._predicting, self._period, voltage),
            Plant(self._predicting, self._period, voltage, self._large),
        )
        self._first = tick
        self._newest = tick - 1

    def _step(self, voltage: float) -> tuple[float, float]:
        """What the model reads at the next tick from either beginning, m."""
        assert self._plants is not None
        one, other = self._plants
        readings = one.read(), other.read()
        one.write(voltage)
        other.write(voltage)
        self._voltage = voltage
        return readings

    def _courses(self, time: Array) -> list[Array]:
        settings = self._model.settings
        zero = [np.ones((1, len(time)))] if has_own_zero(self._model) else []
        links = [registry()[name].courses(self._model.values(name), time) for name in settings]
        return [*zero, *links]


class Watch:
    """Says whether a model still holds, and does not waver where the gap is about at its limit."""

    def __init__(self) -> None:
        self.holds = True
        self.judged: Reading | None = None  # the newest window that could tell

    def judge(self, reading: Reading, ratio: float, least: float) -> None:
        """Take a window into account, if it can tell.

        The gap is too large above `ratio` noise floors, unless it is smaller than `least`, m.
        """
        if not reading.moving or reading.doubt > max(reading.noise_floor, least):
            return
        limit = max(ratio * reading.noise_floor, least)
        self.holds = reading.gap <= (limit if self.holds else CLEARED * limit)
        self.judged = reading
