"""The chain made ready to run: the links of a model on one time grid, with their states."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.signals import (
    HIGH,
    LEVELS,
    LOW,
    POSITION,
    ROWS,
    VOLTAGE,
    Array,
    Timing,
    is_flat,
)
from microgripper_control.effects import conversion_clock
from microgripper_control.effects.base import Kernel, Link, Load, Prepared, Stage, Values
from microgripper_control.plant.hold import Hold
from microgripper_control.plant.model import Model

CLOSED = 1e-10  # of the stroke: what a period may differ from the one before
MOST_PERIODS = 60
LABORIOUS = 10  # rows of coefficients a sample: it pays to see whether anything still moves
LOOK = 64  # samples in a row that show it, each time after as many again as have passed:
FLAT = 1e-10  # of the value at the end; what creeps changes by more in so many


class Chain:
    """Runs the links one after the other over a bus of internal steps.

    `levels` (shape (4,)) is where each row of the bus rests when the run begins; only voltage and
    hysteresis are read, the links fill in the rest, and the drive's ends are the model's range.
    Each step's voltage is held through it, or runs straight through it unless `hold` is zero; a
    band-limited one has no corners that count. `reading_age`, s, is how old the first reading is
    where the sensor converts on a clock of its own.
    """

    def __init__(
        self,
        model: Model,
        sample_period: float,
        levels: Array,
        *,
        hold: Hold = Hold.ZERO,
        divisions: int = 1,
        random: bool = False,
        reading_age: float = 0.0,
    ) -> None:
        links = [(link, values) for link, values in model.at_work if random or not link.random]
        clock = model.clock
        jumps, breaks = _edges(links, sample_period, hold, clocked=clock > 0.0)
        jumps |= {i / divisions for i in range(divisions)}
        self.timing = timing = Timing.divide(sample_period, jumps, breaks, hold is not Hold.ZERO)
        levels = _with_ends(levels, model.voltage_range)
        self._continuous: list[tuple[Kernel, Array, Array]] = []
        self._clock: Prepared | None = None  # of a sensor that has one
        self._sampled: list[tuple[Kernel, Array, Array]] = []
        self._lasting: list[Array] = []
        self._behind = sum(link.behind(values) for link, values in links)  # s
        loads: list[Load] = [(link.force, values) for link, values in links if link.force]
        for link, values in links:
            if link.force:
                continue
            kernel, prepared = _ready(link, values, timing, levels, loads)
            timing = timing.with_course(prepared.ramped)
            group = self._sampled if link.sampled else self._continuous
            group.append((kernel, prepared.coefficients, prepared.state))
            if link.stage in (Stage.MATERIAL, Stage.MECHANICS):
                self._lasting.append(prepared.state)
            if not link.sampled:
                self.rest_position = float(levels[POSITION])
        if clock > 0.0:
            self._clock = conversion_clock.prepare(clock, reading_age, timing, levels)

    @property
    def steps(self) -> int:
        """Internal steps in one sample period."""
        return len(self.timing.steps)

    @property
    def labour(self) -> int:
        """Rows of coefficients that a sample period takes, roughly what it costs."""
        rows = sum(len(coefficients) for _, coefficients, _ in self._continuous)
        return rows + (len(self._clock.coefficients) if self._clock else 0)

    @property
    def is_laborious(self) -> bool:
        """Whether its rests are worth to be told from the rest of a run."""
        return self.labour > LABORIOUS

    @property
    def senses(self) -> bool:
        """Whether the sensor reports anything but the true positions."""
        return bool(self._sampled)

    def advance(self, bus: Array) -> None:
        """Run the links that act between samples; `bus` holds whole sample periods."""
        _run(self._continuous, bus)
        self._convert(bus)

    def rest(self, bus: Array) -> None:
        """As `advance`, for a voltage that rests all along the bus.

        Once nothing moves any more, and what comes late has come, the positions are filled in.
        """
        # A window that averages remembers twice as long as it is behind.
        look, late = LOOK * self.steps, 2.0 * self._behind / self.timing.sample_period * self.steps
        begin, end = 0, look
        while begin < bus.shape[1]:
            piece = np.zeros_like(bus[:, begin:end])
            piece[VOLTAGE] = bus[VOLTAGE, begin:end]
            still = _run_and_see(self._continuous, piece, look)
            bus[POSITION, begin:end] = piece[POSITION]
            if still and end - look >= late:
                bus[POSITION, end:] = piece[POSITION, -1]
                break
            begin, end = end, 2 * end
        self._convert(bus)

    def _convert(self, bus: Array) -> None:
        if self._clock:
            conversion_clock.kernel(self._clock.coefficients, self._clock.state, bus)

    def settle(self, bus: Array) -> float:
        """Run the period on the bus over and over until it repeats itself; returns x[0], m.

        A sensor's own clock goes on through all periods and does not: it reads the last two, and
        x[0] is what it has read by the end of the first of them.
        """
        self._settle(bus)
        first = float(bus[POSITION, -1])
        if self._clock:
            periods = bus.shape[1] // self.steps
            conversion_clock.turn_back(self._clock, periods * self.timing.sample_period)
            before = bus.copy()
            self._convert(before)
            first = float(before[POSITION, -1])
        self._convert(bus)
        return first

    def _settle(self, bus: Array) -> None:
        """All but the sensor's clock.

        It does so if it ends where it began, in every state or at least in its positions. A small
        loop of hysteresis takes many periods for that, slow creep thousands, but each approaches
        its cycle geometrically. So every third time the states of material and mechanics are taken
        to where the last three point.
        """
        voltage, passed = bus[VOLTAGE].copy(), []
        for _ in range(MOST_PERIODS):
            begun, before = self._states(), bus[POSITION].copy()
            bus[VOLTAGE] = voltage
            _run(self._continuous, bus)
            if np.allclose(self._states(), begun, rtol=CLOSED, atol=0.0):
                return
            change = np.max(np.abs(bus[POSITION] - before))
            if not change > CLOSED * np.ptp(bus[POSITION]):
                return
            passed.append([state.copy() for state in self._lasting])
            if len(passed) == 3:
                for state, *three in zip(self._lasting, *passed, strict=True):
                    state[:] = _limit(*three)
                passed.clear()

    def _states(self) -> Array:
        """Those of all links that act between samples, one after the other."""
        return np.concatenate([state for _, _, state in self._continuous])

    def sense(self, positions: Array) -> Array:
        """What the sensor reports for true positions at the sampling instants, shape (n,)."""
        if not self.senses:
            return positions
        bus = np.zeros((ROWS, len(positions)))
        bus[POSITION] = positions
        _run(self._sampled, bus)
        sensed: Array = bus[POSITION]
        return sensed

    def sense_in_place(self, bus: Array) -> None:
        """As `sense`, on the position row of a bus of samples."""
        _run(self._sampled, bus)


def _with_ends(rows: Array, voltage_range: tuple[float, float]) -> Array:
    """Levels of which only these rows and the drive's ends are known."""
    levels = np.zeros(LEVELS)
    levels[:ROWS] = rows
    levels[LOW + VOLTAGE], levels[HIGH + VOLTAGE] = voltage_range
    return levels


def _run(links: list[tuple[Kernel, Array, Array]], bus: Array) -> None:
    """Run links, with what they have prepared, one after the other."""
    for kernel, coefficients, state in links:
        kernel(coefficients, state, bus)


def _run_and_see(links: list[tuple[Kernel, Array, Array]], bus: Array, look: int) -> bool:
    """Run links on a bus of zeros but for the voltage; whether behind each of them all is still.

    Its last `look` steps tell. What moves within a play does not show at the end.
    """
    still = True
    for kernel, coefficients, state in links:
        kernel(coefficients, state, bus)
        still = still and is_flat(bus[:, -look:], FLAT)
    return still


def _limit(first: Array, second: Array, third: Array) -> Array:
    """Where sequences that approach geometrically end (Aitken 1926); the others' last values."""
    step = third - second
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = step / (second - first)
        limit = third + step * ratio / (1.0 - ratio)
    return np.where((ratio > 0.0) & (ratio < 1.0), limit, third)


def _ready(
    link: Link, values: Values, timing: Timing, levels: Array, loads: list[Load]
) -> tuple[Kernel, Prepared]:
    """The link's kernel and what it needs; forces go into the solve of the link that has one."""
    if loads and link.solver:
        return link.solver.kernel, link.solver.prepare(values, timing, levels, loads)
    return link.kernel, link.prepare(values, timing, levels)


def _edges(
    links: Sequence[tuple[Link, Values]], sample_period: float, hold: Hold, *, clocked: bool
) -> tuple[set[float], set[float]]:
    """Where in a sample period a held voltage jumps, and where links want it divided, as shares."""
    jumps, breaks = {0.0}, {0.0}
    followed = hold is Hold.ZERO and (clocked or any(link.follows for link, _ in links))
    for link, values in links:
        jumps |= link.jumps(values, sample_period)
        breaks |= link.breaks(values, sample_period)
        if hold is not Hold.BANDLIMITED:
            breaks |= link.bends(values, sample_period)
        if followed:
            breaks |= link.settling(values, sample_period)
    return jumps, {(jump + wanted) % 1.0 for jump in jumps for wanted in breaks}
