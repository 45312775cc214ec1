"""Mass, damper and stiffness with the flexure in parallel, the paper's equation (4).

    m x'' + b x' + k x = k w - k_s x,        w = d u - h

Linear, so each internal step is taken exactly: the matrix exponential of the system augmented by
its input, which is held over the step or runs straight through it (Van Loan 1978). Where all steps
are alike and long, position follows position without the velocity: the same map as a difference
equation, which waits for half as much from one step to the next.
"""

import math
from collections.abc import Mapping
from functools import lru_cache

import numpy as np
from scipy.linalg import expm

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.signals import FREE, PLACES, POSITION, Array, Timing
from microgripper_control.effects import force_balance, mass_under_forces
from microgripper_control.effects.base import Link, Prepared, Scales, Solver, Stage, Values

# How finely the ringing after a jump is drawn with straight lines. Measured: a sensor that averages
# the course then reads as if 1 to 3 us late, for the paper's actuator and for the maker's figures.
DECAYS = 7.0  # time constants until it counts as died away
MOST_CORNERS = 6  # in half a period
FEWEST_PIECES = 12  # in a sample period, unless that takes more corners
MOST_PIECES = 64

FAR_OFF = 30.0  # times the model's mass
LONG = 1.0  # of the natural period over 2 pi: a shorter step's difference equation loses digits


@lru_cache(maxsize=256)
def _transition(m: float, b: float, k: float, k_s: float, step: float, ramped: bool) -> Array:
    """Exact step of (x, v): row [a11 a12 a21 a22, x and v from the old w, from the new w]."""
    if step == 0.0:
        return np.array([1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    # Time in units of the natural period keeps the exponential well scaled at any rate.
    omega = np.sqrt((k + k_s) / m)
    damping = b / (m * omega)
    gain = k / (k + k_s)
    span = omega * step
    system = np.zeros((4, 4))  # x, v / omega, w, slope of w per step
    system[0, 1] = span
    system[1, :3] = -span, -damping * span, gain * span
    system[2, 3] = 1.0
    e = expm(system)
    x_slope, v_slope = (e[0, 3], e[1, 3]) if ramped else (e[0, 2], e[1, 2])
    x_level, v_level = (e[0, 2] - x_slope, e[1, 2] - v_slope)
    return np.array(
        [
            *(e[0, 0], e[0, 1] / omega, e[1, 0] * omega, e[1, 1]),
            *(x_level, v_level * omega, x_slope, v_slope * omega),
        ]
    )


@lru_cache(maxsize=256)
def _difference(m: float, b: float, k: float, k_s: float, period: float, ramped: bool) -> Array:
    """The map of a step, as `_transition` gives it, without the velocity (Cayley-Hamilton).

    Row: x from the last x, from the one before, and from the new w, the old and the one before.
    """
    step = _transition(m, b, k, k_s, period, ramped)
    one, old, new = step[:4].reshape(2, 2), step[4:6], step[6:8]
    trace, determinant = one[0, 0] + one[1, 1], one[0, 0] * one[1, 1] - one[0, 1] * one[1, 0]
    rest = one - trace * np.eye(2)
    return np.array([trace, -determinant, new[0], (old + rest @ new)[0], (rest @ old)[0]])


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    if coefficients.shape[1] == 8:
        _map(coefficients, state, bus)
    else:
        _differ(coefficients[0], state, bus)


@compiled
def _differ(c: Array, state: Array, bus: Array) -> None:
    x, x_before, w, w_before = state[0], state[1], state[2], state[3]
    for j in range(bus.shape[1]):
        new = bus[FREE, j]
        # What is new and what is old first: the next step waits for no more than one product.
        x, x_before = c[0] * x + (c[1] * x_before + (c[2] * new + (c[3] * w + c[4] * w_before))), x
        w, w_before = new, w
        bus[POSITION, j] = x
    state[0], state[1], state[2], state[3] = x, x_before, w, w_before


@compiled
def _map(coefficients: Array, state: Array, bus: Array) -> None:
    x, v, w = state[0], state[1], state[2]
    steps = coefficients.shape[0]
    row = 0
    for j in range(bus.shape[1]):
        c = coefficients[row]
        new = bus[FREE, j]
        # What is new first, x and v last: the next step waits for no more than two products.
        x, v = (
            c[0] * x + (c[1] * v + (c[4] * w + c[6] * new)),
            c[2] * x + (c[3] * v + (c[5] * w + c[7] * new)),
        )
        w = new
        bus[POSITION, j] = x
        row = row + 1 if row + 1 < steps else 0
    state[0], state[1], state[2] = x, v, w


def settling(values: Values, sample_period: float) -> set[float]:
    """The turns of the ringing after a jump until it has died away, and corners between them."""
    omega = mass_under_forces.natural_frequency(values)
    damping = values["b"] / (2.0 * values["m"] * omega)
    pace = omega * math.sqrt(max(0.25, 1.0 - damping**2))
    decay = omega * (damping - math.sqrt(max(0.0, damping**2 - 1.0)))
    half = math.pi / pace  # from turn to turn
    corners = min(MOST_CORNERS, max(1, math.ceil(FEWEST_PIECES * half / sample_period)))
    end = min(sample_period, DECAYS / decay) if decay > 0.0 else sample_period
    step = max(half / corners, end / MOST_PIECES)
    return {i * step / sample_period for i in range(1, math.ceil(end / step))}


def static_gain(values: Values) -> float:
    """k / (k + k_s): displacement per free displacement at rest."""
    return values["k"] / (values["k"] + values["k_s"])


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """State: position, velocity and free displacement so far, or the last two of both positions."""
    m, b, k, k_s = (values[name] for name in ("m", "b", "k", "k_s"))
    levels[PLACES + POSITION] = static_gain(values) * levels[PLACES + FREE]
    x, w, first = levels[POSITION], levels[FREE], timing.steps[0]
    if len(timing.steps) == 1 and mass_under_forces.natural_frequency(values) * first > LONG:
        row = _difference(m, b, k, k_s, first, timing.ramped)
        return Prepared(np.array([row]), np.array([x, x, w, w]), ramped=True)
    rows = [_transition(m, b, k, k_s, step, timing.ramped) for step in timing.steps]
    return Prepared(np.array(rows), np.array([x, 0.0, w]), ramped=True)


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """A rig is its model's, mistuned. A mass lighter still rings too fast to be followed."""
    return {"m": (scales.mass / FAR_OFF, scales.mass * FAR_OFF)}


LINK = Link(
    name="second_order",
    stage=Stage.MECHANICS,
    order=0,
    title="mass, damper and flexure",
    source="paper, equation (4), Table 1 and section 4",
    nominal=True,
    parameters=(
        Parameter("m", "kg", 0.0038, 1e-9, 1e3, "effective mass"),
        Parameter("b", "N*s/m", 150.0, 0.0, 1e9, "effective damping"),
        Parameter("k", "N/m", 5e7, 1e-3, 1e12, "stiffness of the stack", fitted=False),
        Parameter("k_s", "N/m", 8.2e5, 0.0, 1e12, "stiffness of the flexure", fitted=False),
    ),
    prepare=prepare,
    kernel=kernel,
    solver=Solver(mass_under_forces.prepare, force_balance.kernel),
    settling=settling,
    plausible=plausible,
)
