"""An underdamped mode of finger or mount, in modal form.

    q'' + (2 zeta w + drag |q'|) q' + w^2 (1 + hardening (q - x)^2) (q - x) = 0,

    x_f = x + share (q - x),        w = 2 pi frequency

The gain at rest stays one, so that the mode does not pass for a change of d. At share 1 all of the
motion goes through the mode (a finger on a flexible joint); a small share of either sign is a mode
seen beside the motion, with its antiresonance above or below the resonance. Joints and air damp the
more the faster they move, and a mount's spring is straight for small swings only: a strong ring
dies away faster than a weak one, and at another pitch.

Where finger and mount both ring there is a `second` mode, seen beside the first:

    x_f = x + share (q - x) + second (p - x),       p'' + 2 zeta_2 w_2 p' + w_2^2 (p - x) = 0

Without drag and hardening it is exact for straight lines between the internal steps; they are added
as a kick at the end of each, and there are several in a sample if the mode is fast. Measured
against theory for the whole chain, modes up to 0.8 of the sampling rate come out within 2 % of what
they do to the displacement.
"""

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.lag import advance_lag, follow, lag_rows
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import number, quantity
from microgripper_control.core.signals import POSITION, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values

DAMPED = 0.04  # a first guess
DRAG = 1e4  # 1/m, a first guess
TURN = 0.6  # rad of the mode between two kicks: they do what they should within 3 %


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """State: q - x, q', x so far, p - x, p'.

    A row: that of `advance_lag` for q, step drag, step w^2 hardening, share, that for p, second.
    """
    share, second = coefficients[0, 8], coefficients[0, 15]
    if not (coefficients[0, 6] or coefficients[0, 7] or second):
        follow(coefficients, state, bus[POSITION], share)
        return
    away, v, old, apart, w = state
    steps, row = coefficients.shape[0], 0
    for j in range(bus.shape[1]):
        c = coefficients[row]
        x = bus[POSITION, j]
        away, v = advance_lag(c, away, v, x - old)
        v = (v - c[7] * away * away * away) / (1.0 + c[6] * abs(v))
        apart, w = advance_lag(c[9:], apart, w, x - old)
        old = x
        bus[POSITION, j] = x + share * away + second * apart
        row = row + 1 if row + 1 < steps else 0
    state[0], state[1], state[2], state[3], state[4] = away, v, old, apart, w


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """The levels are left alone: at rest q = x."""
    omega = math.tau * values["frequency"]
    kicks = np.outer(timing.steps, (values["drag"], omega**2 * values["hardening"]))
    share, second = (np.full(len(kicks), values[name]) for name in ("share", "second"))
    first, other = (_free_mode(values, which, timing) for which in ("", "second_"))
    rows = np.column_stack([first, kicks, share, other, second])
    return Prepared(rows, np.array([0.0, 0.0, levels[POSITION], 0.0, 0.0]), timing.ramped)


def _free_mode(values: Values, which: str, timing: Timing) -> Array:
    """Rows of `advance_lag` for one of the two modes."""
    omega = math.tau * values[f"{which}frequency"]
    return lag_rows(2.0 * values[f"{which}damping"] / omega, omega**-2, timing)


def breaks(values: Values, sample_period: float) -> set[float]:
    """Equal parts for the kicks of drag and hardening.

    Their number goes by powers of two: where it changes a fit would see a step.
    """
    if not (values["drag"] or values["hardening"]):
        return set()
    turn = math.tau * values["frequency"] * sample_period
    parts = 1 << max(0, math.ceil(math.log2(turn / TURN)))
    return {part / parts for part in range(1, parts)}


def starts(scales: Scales) -> Sequence[Values]:
    """Modes all over the band that the samples show, so damped that none is missed between.

    Of every third one a second, which drags: that peak is wide.
    """
    modes = [
        {"share": 0.1, "frequency": frequency, "damping": DAMPED} for frequency in _band(scales)
    ]
    return [*modes, *(mode | {"drag": DRAG} for mode in modes[::3])]


def more(values: Values, scales: Scales) -> Sequence[Values]:
    """A second mode all over the band, a tenth of the first."""
    if values["second"] != 0.0:
        return []
    mode = {"second": 0.1 * values["share"], "second_damping": DAMPED}
    return [{**mode, "second_frequency": frequency} for frequency in _band(scales)]


def _band(scales: Scales) -> Sequence[float]:
    """Frequencies all over the band that the samples show, Hz.

    None if they are too slow, or too few.
    """
    highest = 0.5 / scales.sample_period
    lowest = max(1.0, 5.0 / scales.duration, 2e-3 * highest)
    return [float(f) for f in np.geomspace(lowest, highest, 70)] if highest > lowest else []


def idle(values: Values) -> Collection[str]:
    """A fit of small swings tells nothing of large ones, so what does not drag stays straight.

    And one mode stays one.
    """
    straight = ("drag", "hardening") if values["drag"] == 0.0 else ()
    alone = ("second", "second_frequency", "second_damping") if values["second"] == 0.0 else ()
    return (*straight, *alone)


def plausible(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """A mode has a peak, in the band that the samples show; else it would pass for any lag."""
    damping, frequency = (1e-4, 0.15), (1.0, 0.5 / scales.sample_period)
    return {
        "damping": damping,
        "frequency": frequency,
        "second_damping": damping,
        "second_frequency": frequency,
    }


def ringing(values: Values) -> float:
    """Of a small swing: drag and hardening do not change it, and no other has a higher peak.

    G - 1 = share (Q - 1), Q = w^2 / (s^2 + 2 zeta w s + w^2): for zeta up to 0.7 |Q - 1| is nowhere
    above 1 + 1 / (2 zeta) times the frequency over w. Two modes add up at most.
    """
    modes = (("share", ""), ("second", "second_"))
    return math.fsum(
        abs(values[share])
        * (1.0 + 0.5 / values[f"{which}damping"])
        / (math.tau * values[f"{which}frequency"])
        for share, which in modes
    )


def says(values: Values, scales: Scales) -> str:
    frequency, damping = quantity(values["frequency"], "Hz", 3), number(values["damping"])
    other = f", and at {quantity(values['second_frequency'], 'Hz', 3)}" if values["second"] else ""
    return f"finger or mount rings at {frequency} (damping ratio {damping}){other}"


LINK = Link(
    name="extra_resonance",
    stage=Stage.TRANSMISSION,
    order=20,
    title="resonance of finger or mount",
    source="modal superposition: Meirovitch 1986; Gawronski 2004; drag, Duffing: Nayfeh, Mook 1979",
    parameters=(
        Parameter("share", "1", 0.2, -5.0, 5.0, "part of the motion that passes the mode", 0.0),
        Parameter("frequency", "Hz", 200.0, 1.0, 1e5, "natural frequency"),
        Parameter("damping", "1", 0.02, 1e-4, 0.7, "damping ratio"),
        Parameter("drag", "1/m", 0.0, 0.0, 1e6, "damping, as a multiple of the speed", 0.0),
        Parameter(
            "hardening",
            "1/m^2",
            0.0,
            -1e12,
            1e12,
            "of its spring, with the square of the swing",
            0.0,
        ),
        Parameter("second", "1", 0.0, -5.0, 5.0, "part of the motion that passes another", 0.0),
        Parameter("second_frequency", "Hz", 200.0, 1.0, 1e5, "its natural frequency"),
        Parameter("second_damping", "1", 0.02, 1e-4, 0.7, "its damping ratio"),
    ),
    prepare=prepare,
    kernel=kernel,
    breaks=breaks,
    follows=True,
    starts=starts,
    more=more,
    idle=idle,
    plausible=plausible,
    ringing=ringing,
    says=says,
)
