"""Creep: the free displacement goes on growing after a change of voltage, about as log time.

    w_c = w + sum_i c_i s_i,    tau_i s_i' = w - s_i,    c_i = strength |log10(slowest/fastest)| / N

A row of Kelvin-Voigt elements whose time constants tau_i lie evenly in log time from `fastest` to
`slowest`. After a step each decade of time in between then adds the share `strength` of the step,
to 1 % of that; drawn together, the two leave a single time constant. Elements are advanced exactly,
w held over an internal step or running straight through it. At rest creep is complete.

Where domains have to be helped over a barrier (Eyring), they are the faster the more they lag:

    tau_i s_i' = sinh(activation (w - s_i)) / activation,

so that even one of them goes by the logarithm of time after a step, and by the same length in a
decade after a small step as after a large one. A held w is followed exactly then, too; of a
straight one half of the way comes before what an internal step relaxes, half behind.
"""

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import percent, quantity
from microgripper_control.core.signals import FREE, PLACES, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values

ELEMENTS = 8
SMALL, LITTLE = 0.25, 0.03  # up to which series have all digits
LARGE = 300.0  # far from where exp overflows
MOST = 0.2  # of a step in a decade: what is still called creep
# First guesses of activated elements: how slow, times the longest, and how activated, per stroke.
ACTIVATED = ((1.0, 5.0), (1.0, 20.0), (10.0, 40.0), (100.0, 20.0))
UNFINISHED = 3.0  # times the creep after a step over the stroke: wider ones may lie before


def time_constants(values: Values) -> Array:
    """tau_i, s, shape (ELEMENTS,), in the middle of equal parts of the log range."""
    middles = (np.arange(ELEMENTS) + 0.5) / ELEMENTS
    fastest, slowest = values["fastest"], values["slowest"]
    constants: Array = fastest * (slowest / fastest) ** middles
    return constants


@compiled
def _relaxed_by(late: float, falls: float) -> float:
    """By how much activation (w - s) shrinks in a step in which tanh(late / 2) `falls`.

    By the law for the difference of two arguments of tanh: to take the difference of what was and
    what is left would lose its digits, and cost one logarithm more.
    """
    size = abs(late)
    if size < SMALL:  # sinh(late) and cosh(late) - 1, by their series
        q = late * late
        rise = size * (1.0 + q / 6.0 * (1.0 + q / 20.0 * (1.0 + q / 42.0 * (1.0 + q / 72.0))))
        bend = 0.5 * q * (1.0 + q / 12.0 * (1.0 + q / 30.0 * (1.0 + q / 56.0)))
    else:
        grown = math.exp(min(size, LARGE))
        rise, bend = 0.5 * (grown - 1.0 / grown), 0.5 * (grown + 1.0 / grown) - 1.0
    share = 0.5 * falls * rise / (1.0 + 0.5 * falls * bend)  # tanh of half of what is gone
    if share < LITTLE:
        q = share * share
        gone = 2.0 * share * (1.0 + q * (1.0 / 3.0 + q * (0.2 + q * (1.0 / 7.0 + q / 9.0))))
    else:
        small = math.exp(-size)
        gone = size - math.log((2.0 - falls + falls * small) / (falls + (2.0 - falls) * small))
    return math.copysign(gone, late)


@compiled
def _crept(row: Array, elements: Array, old: float, new: float) -> float:
    """The sum of the s_i after a step over which w went from old to new."""
    total = 0.0
    for i in range(ELEMENTS):
        decay, before, after = row[2 + 3 * i], row[3 + 3 * i], row[4 + 3 * i]
        elements[i] = decay * elements[i] + before * old + after * new
        total += elements[i]
    return total


@compiled
def _crept_activated(row: Array, elements: Array, old: float, new: float) -> float:
    """The same of elements that are activated: they relax at a w between the two."""
    activation, total = row[1], 0.0
    for i in range(ELEMENTS):
        falls, before, after = row[2 + 3 * i], row[3 + 3 * i], row[4 + 3 * i]
        w = before * old + after * new
        elements[i] += _relaxed_by(activation * (w - elements[i]), falls) / activation
        total += elements[i]
    return total


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: w so far, then the s_i.

    A row: c, activation, then of each element (decay, share of the old w, of the new); of those
    that are activated the first is what falls away.
    """
    elements = state[1:]
    steps, step = coefficients.shape[0], 0
    for j in range(bus.shape[1]):
        row = coefficients[step]
        old, new = state[0], bus[FREE, j]
        if row[1] == 0.0:
            total = _crept(row, elements, old, new)
        else:
            total = _crept_activated(row, elements, old, new)
        state[0] = new
        bus[FREE, j] = new + row[0] * total
        step = step + 1 if step + 1 < steps else 0


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """What leaves is of the course that came: within a step creep is slow."""
    decades = abs(np.log10(values["slowest"] / values["fastest"]))
    share, activation = values["strength"] * decades / ELEMENTS, values["activation"]
    rows = []
    for step in timing.steps:
        y = step / time_constants(values)
        decay, falls = np.exp(-y), -np.expm1(-y)
        if activation:
            before = np.full(ELEMENTS, 0.5 if timing.ramped else 0.0)
            elements = [falls, before, 1.0 - before]
        else:
            before = falls / y - decay if timing.ramped else np.zeros(ELEMENTS)
            elements = [decay, before, falls - before]
        rows.append([share, activation, *np.column_stack(elements).flat])
    state = np.full(1 + ELEMENTS, levels[FREE])
    levels[PLACES + FREE] *= 1.0 + share * ELEMENTS
    return Prepared(np.array(rows), state, timing.ramped)


def courses(values: Values, time: Array) -> Array:
    """Creep that was not complete when the recording began dies away element by element."""
    decays: Array = np.exp(-time[None, :] / time_constants(values)[:, None])
    return decays


def credible(values: Values, course: Array, scales: Scales) -> bool:
    """What was not complete in the beginning is no more than some steps can have left."""
    decades = abs(math.log10(values["slowest"] / values["fastest"]))
    return bool(np.ptp(course) <= UNFINISHED * values["strength"] * decades * scales.stroke)


def idle(values: Values) -> Collection[str]:
    """Elements that are as slow at any lag stay so: the two kinds are told apart by shape."""
    return ("activation",) if values["activation"] == 0.0 else ()


def starts(scales: Scales) -> Sequence[Values]:
    """Creep over all times that the recording shows, over the short ones and over the long.

    And activated, with elements that are slow by themselves.
    """
    shortest, longest = 3.0 * scales.sample_period, 3.0 * scales.duration
    middle = math.sqrt(shortest * longest)
    spans = ((shortest, longest), (shortest, middle), (middle, longest))
    activated = [
        {
            "fastest": 0.1 * slow * longest,
            "slowest": slow * longest,
            "activation": activation / scales.stroke,
        }
        for slow, activation in ACTIVATED
    ]
    return [*({"fastest": fastest, "slowest": slowest} for fastest, slowest in spans), *activated]


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """A ceramic goes on by a few per cent a decade; glue and polymers by several times that."""
    return {"strength": (0.0, MOST)}


def says(values: Values, scales: Scales) -> str:
    strength, decades = values["strength"], abs(math.log10(values["slowest"] / values["fastest"]))
    if values["activation"]:
        total = percent(strength * decades)
        return f"the rig creeps, the faster the further behind: in the end by {total} of a step"
    if decades < 1.0:
        middle = math.sqrt(values["slowest"] * values["fastest"])
        way = f"{percent(strength * decades)} of the step within some {quantity(middle, 's', 1)}"
    else:
        way = f"{percent(strength)} of the step per decade of time"
    return f"the rig creeps: after a step it goes on moving by {way}"


LINK = Link(
    name="creep",
    stage=Stage.MATERIAL,
    order=30,
    title="creep",
    source="Croft, Shed, Devasia 2001 (elements); Jung and Gweon 2000 (log time); Eyring 1936",
    parameters=(
        Parameter("strength", "1", 0.01, 0.0, 1.0, "share of a step added in a decade", 0.0),
        Parameter(
            "fastest",
            "s",
            0.01,
            1e-4,
            1e4,
            "time from which on creep goes by the logarithm of time",
        ),
        Parameter(
            "slowest", "s", 1e3, 1e-4, 1e6, "time up to which creep goes by the logarithm of time"
        ),
        Parameter("activation", "1/m", 0.0, 0.0, 1e8, "how much faster the more it lags"),
    ),
    prepare=prepare,
    kernel=kernel,
    courses=courses,
    credible=credible,
    idle=idle,
    starts=starts,
    plausible=plausible,
    says=says,
)
