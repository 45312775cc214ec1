"""The loop over DDS in two processes, against a bare echo of the same messages."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from microgripper_control.bench.highest_rate import highest_rate
from microgripper_control.bench.loops import BARE, OURS, Trips, run_loop
from microgripper_control.bench.row import LONGER, Effort, Goal, Line, Measured, Row, at_most
from microgripper_control.bench.timing import Spread
from microgripper_control.core.realtime import refusal

CLOSE, FEW_MISSES = at_most(1.5), at_most(1e-3)
PERCENT = at_most(100.0 * FEW_MISSES.limit)
USUAL = 1000.0  # Hz
RATES = (USUAL, 1500.0, 2000.0, 2500.0, 3000.0, 4000.0, 5000.0, 6000.0)  # Hz
SOONEST = 0.5  # of the usual round trip: no answer comes sooner
REALTIME = 20  # priority
EVENTS, SINGLE = "events", "single_threaded"


@dataclass
class Runs:
    """The runs of one way of scheduling, ours and the bare ones in turns."""

    executor: str
    priority: int
    ours: list[Trips] = field(default_factory=list)
    bare: list[Trips] = field(default_factory=list)

    @property
    def name(self) -> str:
        """What tells it from the others."""
        return f"{self.executor}{', real-time priority' if self.priority else ''}"

    def add(self, effort: Effort, duration: float) -> None:
        """One more turn."""
        effort.progress(f"loop: {self.name}")
        settings = {"executor": self.executor, "realtime_priority": self.priority}
        for pair, runs in ((BARE, self.bare), (OURS, self.ours)):
            runs.append(run_loop(effort.folder, pair, duration, USUAL, settings))

    def compared(
        self, what: str, figure: Callable[[Trips], float], goal: Goal | None = None
    ) -> Line:
        """Ours against the bare echo, turn by turn."""
        ours, bare = (np.array([figure(run) for run in runs]) for runs in (self.ours, self.bare))
        return Line(
            f"{what}, {self.name}",
            "a bare rclpy echo",
            Spread.of(ours / bare),
            LONGER,
            goal if self.executor == EVENTS else None,
            float(np.median(ours)),
            float(np.median(bare)),
        )

    def share(self, what: str, figure: Callable[[Trips], float], goal: Goal | None = None) -> Line:
        """A share of our ticks, beside the bare echo's."""
        ours, bare = (np.array([figure(run) for run in runs]) for runs in (self.ours, self.bare))
        return Line(
            f"{what}, {self.name}",
            f"a bare rclpy echo: {np.median(bare):.3%}",
            Spread.of(100.0 * ours),
            "%",
            goal if self.executor == EVENTS else None,
        )


def measure(effort: Effort) -> Measured:
    """As `Row` says."""
    duration = effort.among(8.0, 3.0)
    first, refused = Runs(EVENTS, REALTIME), refusal(REALTIME)
    ways = [Runs(EVENTS, 0), *([] if refused else [first]), Runs(SINGLE, 0)]
    for _ in range(effort.among(3, 1)):
        for way in ways:
            way.add(effort, duration)
    lines = []
    for way in ways:
        lines += [
            way.compared("round trip, median", lambda run: percentile(run, 50.0), CLOSE),
            way.compared("round trip, 99th percentile", lambda run: percentile(run, 99.0), CLOSE),
            way.compared("jitter of the period, 99th percentile", jitter),
            way.share("ticks missed at 1 kHz", lambda run: run.missed, PERCENT),
            way.share("ticks without a sample", lambda run: run.unsent),
            way.share("samples without an answer in time", lambda run: run.unanswered),
        ]
    if refused:
        return Measured(tuple(lines), (_NOTE, _REFUSED.format(refused)))
    return Measured((*lines, highest(effort, first)), (_NOTE,))


def highest(effort: Effort, usual: Runs) -> Line:
    """The highest rate at which hardly a tick is missed, given the runs at the usual one."""
    soonest = SOONEST * float(np.median([percentile(run, 50.0) for run in usual.ours]))
    settings = {"executor": usual.executor, "realtime_priority": usual.priority}
    duration = effort.among(4.0, 3.0)

    def kept(rate: float) -> bool:
        if rate == USUAL:
            return hardly_missed(usual.ours)
        runs = []
        for turn in range(len(usual.ours)):
            effort.progress(f"loop at {rate:.0f} Hz, turn {turn + 1}")
            runs.append(run_loop(effort.folder, OURS, duration, rate, settings, soonest))
        return hardly_missed(runs)

    found = highest_rate(RATES, kept)
    return Line(
        f"highest rate with under 0.1 % misses, {usual.name}",
        f"tried {', '.join(f'{rate:.0f}' for rate in found.tried)} Hz",
        Spread.single(found.rate),
        "Hz",
        below=found.below,
    )


def hardly_missed(runs: Sequence[Trips]) -> bool:
    """Whether the median of the runs misses hardly a tick: a single one is often mistaken."""
    return FEW_MISSES.met(float(np.median([run.missed for run in runs])))


def percentile(run: Trips, percent: float) -> float:
    """Of the round trips, s."""
    return float(np.percentile(run.round_trips, percent))


def jitter(run: Trips) -> float:
    """How far a period is off, s, 99th percentile."""
    return float(np.percentile(np.abs(run.periods - np.median(run.periods)), 99.0))


_NOTE = (
    "Plant and controller (cascade) in two processes against two bare nodes that publish at the "
    "same pace and answer at once, in turns. A round trip runs from before joint_states is "
    "published until the voltage_command that answers it has come; the first second is left out. A "
    "tick is missed if its sample was not sent before the next was due, or no answer came before "
    "the next sample, for then the plant holds an older command. The highest rate is looked for by "
    "bisection, and of each rate the median of as many runs counts; above 1 kHz an answer within "
    "half the round trip usual there is taken for a late one to the sample before. "
    "The executor of the nodes was chosen by this row. The real-time priority is the parameter "
    "realtime_priority, which asks Linux for SCHED_FIFO; it needs the permission."
)
_REFUSED = "With real-time priority, the highest rate too: not measured: {}."

ROW = Row("loop", "loop over DDS, two processes", measure)
