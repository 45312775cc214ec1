"""Play between actuator and finger, which may follow the flanks of the gap with a lag.

    x_f = mean of x_i,   T x_i' = dead(x - x_i, h_i),   dead(e, h) = e - min(max(e, -h), h),
    2 h_i = play (1 - spread i / (N - 1)),   i = 0 .. N - 1;        T = slowness play

At spread 0 that is one gap: the finger rests until a flank reaches it. At slowness 0 it then moves
with that flank: x_f = min(max(x_f before, x - h), x + h), the play operator, which depends on the
course of x and not on its speed. Else a contact with stiffness k pushes a finger that viscous
friction c holds, T = c / k: it trails behind the flank, and comes to rest at it some T after x has.
T is told per play, so that it goes with it: without play this is no lag of a sensor.

With spread the gap is taken up bit by bit, as where pins of a linkage are not worn alike, or the
flanks are soft.

A run begins with the finger at the flank that pushed it last, on the way that h remembers. x is
taken as straight between the internal steps, and followed exactly.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import percent, quantity
from microgripper_control.core.signals import POSITION, ROWS, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values
from microgripper_control.effects.past import ways

PINS = 6  # N
SHORTEST = 1e-12  # of a step: T that counts as none
SLOWEST = 0.3  # s, T at a play as wide as the stroke
# First guesses: how slowly the finger follows, as a share of that, and over what spread.
FOLLOWING = ((0.001, 0.0), (0.001, 0.5), (0.03, 0.0), (0.1, 0.0), (0.3, 0.0), (1.0, 0.0))
BARELY = 0.1  # a smaller spread is not spoken of, nor how much is left of the whole
SHOWN = 0.05  # of a sample period: a shorter T is not spoken of


@compiled
def _trail(e: float, way: float, rate: float, falls: float, half: float) -> float:
    """x - x_f at the end of a step on which x goes `way` >= 0, m, from e before; `rate` is step/T.

    `falls` is 1 - exp(-rate), which takes long. On the way up the finger leaves the lower flank,
    crosses the gap and meets the upper one.
    """
    left = 1.0
    if e < -half:
        behind = -half - e
        leaves = math.log1p(behind * rate / way) / rate if way > 0.0 else 1.0
        if leaves >= 1.0:
            return e + falls * (way / rate + behind)
        e, left = -half, 1.0 - leaves
    if e < half:
        if half - e >= way * left:
            return e + way * left
        e, left = half, left - (half - e) / way
    if left < 1.0:
        falls = -math.expm1(-rate * left)
    return e + falls * (way / rate - (e - half))


@compiled
def _pushed(finger: float, old: float, x: float, rate: float, falls: float, half: float) -> float:
    """Where a finger is after x has gone from old to x; at rate 0 it does not trail."""
    if rate == 0.0:
        return min(max(finger, x - half), x + half)
    if x >= old:
        return x - _trail(old - finger, x - old, rate, falls, half)
    return x + _trail(finger - old, old - x, rate, falls, half)


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: x so far, then where each pin is. A row: step/T, `falls`, then half of each play."""
    steps, row = coefficients.shape[0], 0
    pins = coefficients.shape[1] - 2
    old = state[0]
    for j in range(bus.shape[1]):
        c = coefficients[row]
        x = bus[POSITION, j]
        total = 0.0
        for i in range(1, 1 + pins):
            state[i] = _pushed(state[i], old, x, c[0], c[1], c[1 + i])
            total += state[i]
        old = x
        bus[POSITION, j] = total / pins
        row = row + 1 if row + 1 < steps else 0
    state[0] = old


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """At rest the finger is where x left it, on the way that h remembers."""
    halves, level = 0.5 * plays(values), levels[POSITION]
    lag = values["slowness"] * values["play"]
    pins = np.zeros(len(halves))
    for share, way in ways(levels, POSITION):
        pins += share * _pins(halves, way)
    levels[POSITION] = np.mean(pins)
    rates = [step / max(lag, SHORTEST * step) for step in timing.steps] if lag else [0.0]
    rows = [(rate, -math.expm1(-rate), *halves) for rate in rates]
    return Prepared(np.array(rows), np.array([level, *pins]), timing.ramped)


def _pins(halves: Array, way: Sequence[float]) -> Array:
    """Where the pins, shape (n,), end after a way of x, m, on which they do not trail."""
    bus, state = np.zeros((ROWS, len(way))), np.zeros(1 + len(halves))
    bus[POSITION] = way
    kernel(np.array([[0.0, 0.0, *halves]]), state, bus)
    return state[1:]


def played(x: Array, play: float) -> Array:
    """What is behind a play, m, of a motion, m, shape (n,), that begins in the middle of it."""
    bus = np.zeros((ROWS, len(x)))
    bus[POSITION] = x
    kernel(np.array([[0.0, 0.0, play / 2.0]]), np.array([x[0], x[0]]), bus)
    return np.asarray(bus[POSITION])


def plays(values: Values) -> Array:
    """The gap of each pin, m."""
    if values["spread"] == 0.0:
        return np.array([values["play"]])
    return np.asarray(values["play"] * (1.0 - values["spread"] * np.linspace(0.0, 1.0, PINS)))


def starts(scales: Scales) -> Sequence[Values]:
    """Small and large shares of the stroke, followed at once, bit by bit, or ever more slowly."""
    slowest = SLOWEST / scales.stroke
    return [
        {"play": share * scales.stroke, "slowness": slowness * slowest, "spread": spread}
        for share in (0.002, 0.01, 0.04)
        for slowness, spread in FOLLOWING
    ]


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """A play that trails longer would be too narrow to show: it would pass for any lag."""
    return {"slowness": (0.0, SLOWEST / scales.stroke)}


def says(values: Values, scales: Scales) -> str:
    text = f"there is play between actuator and finger: {quantity(values['play'], 'm')}"
    if values["spread"] > 1.0 - BARELY:
        text += ", taken up bit by bit"
    elif values["spread"] > BARELY:
        text += f", taken up over {percent(values['spread'])} of it"
    lag = values["slowness"] * values["play"]
    if lag < SHOWN * scales.sample_period:
        return text
    return f"{text}, which the finger follows with a time constant of {quantity(lag, 's')}"


LINK = Link(
    name="backlash",
    stage=Stage.TRANSMISSION,
    order=0,
    title="play between actuator and finger",
    source="Krasnosel'skii and Pokrovskii 1989 (play); Nordin, Galic, Gutman 1997 (trailing)",
    parameters=(
        Parameter("play", "m", 2e-7, 0.0, 1e-2, "width of the gap", 0.0),
        Parameter("spread", "1", 0.0, 0.0, 1.0, "share of the gap over which it is taken up"),
        Parameter("slowness", "s/m", 0.0, 0.0, 1e6, "time constant of following, per play"),
    ),
    prepare=prepare,
    kernel=kernel,
    follows=True,
    of_the_way=True,
    starts=starts,
    plausible=plausible,
    says=says,
)
