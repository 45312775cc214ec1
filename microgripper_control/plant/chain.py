"""The chain made ready to run: the links of a model on one time grid, with their states."""

from __future__ import annotations

import numpy as np

from microgripper_control.core.signals import POSITION, ROWS, Array, Timing
from microgripper_control.effects.base import Kernel
from microgripper_control.plant.model import Model


class Chain:
    """Runs the links one after the other over a bus of internal steps.

    `levels` (shape (4,)) is where each row of the bus rests when the run begins; only voltage and
    hysteresis are read, the links fill in the rest.
    """

    def __init__(
        self,
        model: Model,
        sample_period: float,
        levels: Array,
        *,
        ramped: bool = False,
        divisions: int = 1,
        random: bool = False,
    ) -> None:
        links = [link for link in model.links if random or not link.random]
        breaks = {i / divisions for i in range(divisions)}
        for link in links:
            breaks |= link.breaks(model.values(link.name), sample_period)
        self.timing = timing = Timing.divide(sample_period, breaks, ramped)
        levels = levels.copy()
        self._continuous: list[tuple[Kernel, Array, Array]] = []
        self._sampled: list[tuple[Kernel, Array, Array]] = []
        for link in links:
            if not link.sampled:
                self.rest_position = float(levels[POSITION])
            prepared = link.prepare(model.values(link.name), timing, levels)
            timing = timing.with_course(prepared.ramped)
            group = self._sampled if link.sampled else self._continuous
            group.append((link.kernel, prepared.coefficients, prepared.state))
            if not link.sampled:
                self.rest_position = float(levels[POSITION])

    @property
    def steps(self) -> int:
        """Internal steps in one sample period."""
        return len(self.timing.steps)

    def advance(self, bus: Array) -> None:
        """Run the links that act between samples; `bus` holds whole sample periods."""
        for kernel, coefficients, state in self._continuous:
            kernel(coefficients, state, bus)

    def sense(self, positions: Array) -> Array:
        """What the sensor reports for true positions at the sampling instants, shape (n,)."""
        if not self._sampled:
            return positions
        bus = np.zeros((ROWS, len(positions)))
        bus[POSITION] = positions
        for kernel, coefficients, state in self._sampled:
            kernel(coefficients, state, bus)
        sensed: Array = bus[POSITION]
        return sensed

    def sense_in_place(self, bus: Array) -> None:
        """As `sense`, on the position row of a bus of samples."""
        for kernel, coefficients, state in self._sampled:
            kernel(coefficients, state, bus)
