"""One mass under forces that push back, solved inside each of its steps.

    m x'' + b x' + (k + k_s) x = k w + F(x, x', path)

The left side and w are taken exactly, as without forces. F runs over a step along the parabola
through its values at the beginning, in the middle and at the end. The value at the end is the root
of one equation, F = law(x(F), x'(F)), found by secants inside a bracket; for a force that restores
or brakes it has one root. The middle value is the law's on the way so found, and enters by one
deferred correction. So the step is implicit where it must be (a stiff contact does not chatter) and
its error falls with the fourth power of its length. Where a step is long against the period of the
mass, which has come to rest by its end, F runs straight and only its end value counts.

Where the mass turns within a step, the way is split there for the laws that follow its path.
Sources: exponential steps, Hochbruck and Ostermann 2010; Lobatto nodes, Hairer, Norsett, Wanner
1993, section II.7; deferred correction, Dutt, Greengard, Rokhlin 2000.
"""

import math

from microgripper_control.core.compiled import call_at, compiled
from microgripper_control.core.signals import FREE, POSITION, Array

# Coefficients: one row that says how many laws there are and how many numbers they carry, one row a
# law (address, how many numbers it carries, its coefficients), then one row a substep:
DURATION = 0  # s
MIDDLE, END = 1, 2  # the share of the change of w within the step of the bus that is done by then
LAST = 3  # 1 if it ends the step of the bus
SHORT = 4  # 1 if it is short against the period
TO_END, TO_MIDDLE = 5, 17  # how (x, v, w before, w after, F before, F after) give x, then v
BULGE = 29  # what a parabola of height one on the straight course of F adds to x, v
COLUMNS = 31

# State: x, v, w, F, then what the laws carry at the beginning, in the middle and at the end.
X, V, W, F, CARRIED = 0, 1, 2, 3, 4
AT_BEGIN, AT_MIDDLE, AT_END = 0, 1, 2

Pair = tuple[float, float]  # of x, m, and v, m/s, or what goes into them per N

MOST_TRIALS = 100
CLOSE = 1e-8  # of the way: how far off an error of the force may put the mass
ROUNDING = 1e-15  # of the position


@compiled
def _push(
    c: Array, s: Array, before: int, after: int, x0: float, x1: float, v: float, step: float
) -> float:
    """Sum of the laws for a way in one direction."""
    carried = int(c[0, 1])
    source = s.ctypes.data + 8 * (CARRIED + before * carried)
    target = s.ctypes.data + 8 * (CARRIED + after * carried)
    total = 0.0
    for i in range(1, 1 + int(c[0, 0])):
        law = c.ctypes.data + 8 * (i * COLUMNS + 2)
        total += call_at(int(c[i, 0]), (law, source, target, x0, x1, v, step))
        source += 8 * int(c[i, 1])
        target += 8 * int(c[i, 1])
    return total


@compiled
def _turn(way: float, v0: float, v1: float) -> float:
    """When v passes zero, as a share of the step, on the cubic course with these ends.

    `way` is the mean speed; `v0` and `v1` have opposite signs, so there is one such instant.
    """
    b = 6.0 * way - 4.0 * v0 - 2.0 * v1
    a = 3.0 * (v0 + v1 - 2.0 * way)
    q = -0.5 * (b + math.copysign(math.sqrt(max(0.0, b * b - 4.0 * a * v0)), b))
    early = v0 / q
    return early if 0.0 <= early <= 1.0 else q / a


@compiled
def _move(
    c: Array, s: Array, before: int, after: int, begin: Pair, end: Pair, step: float, short: bool
) -> float:
    """Force at the end of a way from x, v to x, v that may turn once."""
    x0, v0 = begin
    x1, v1 = end
    if short and v0 * v1 < 0.0:
        way = (x1 - x0) / step
        at = _turn(way, v0, v1)
        b, a = 3.0 * way - 2.0 * v0 - v1, v0 + v1 - 2.0 * way
        turn = x0 + step * at * (v0 + at * (b + at * a))
        _push(c, s, before, after, x0, turn, 0.0, step * at)
        return _push(c, s, after, after, turn, x1, v1, step * (1.0 - at))
    return _push(c, s, before, after, x0, x1, v1, step)


@compiled
def _balance(
    c: Array,
    s: Array,
    before: int,
    begin: Pair,
    free: Pair,
    gain: Pair,
    step: float,
    short: bool,
    guess: float,
) -> float:
    """The F for which the laws, at free + gain F, give F."""
    low, high = -math.inf, math.inf
    f, last, last_excess = guess, 0.0, 0.0
    law = f
    for trial in range(MOST_TRIALS):
        x = free[0] + gain[0] * f
        law = _move(c, s, before, AT_END, begin, (x, free[1] + gain[1] * f), step, short)
        excess = f - law
        if not abs(gain[0] * excess) > max(CLOSE * abs(x - begin[0]), ROUNDING * abs(x)):
            break  # also where it is not a number
        if excess > 0.0:
            high = f
        else:
            low = f
        new = law
        if trial > 0 and excess != last_excess:
            new = f - excess * (f - last) / (excess - last_excess)
        if not low < new < high:
            new = 0.5 * (low + high) if high - low < math.inf else f - 2.0 * excess
        last, last_excess, f = f, excess, new
    return law


@compiled
def _carry(table: Array, x: float, v: float, w0: float, w1: float, f: float) -> Pair:
    """Where the table of a substep takes x and v while F runs straight from f to zero."""
    return (
        table[0] * x + table[1] * v + table[2] * w0 + table[3] * w1 + table[4] * f,
        table[6] * x + table[7] * v + table[8] * w0 + table[9] * w1 + table[10] * f,
    )


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """As `effects.base.Kernel`; the rows of both arrays are told above."""
    c, s = coefficients, state
    first, carried = 1 + int(c[0, 0]), int(c[0, 1])
    x, v, w, f = s[X], s[V], s[W], s[F]
    i = first
    for j in range(bus.shape[1]):
        rise, old = bus[FREE, j] - w, w
        while True:
            r = c[i]
            step, new, short = r[DURATION], w + r[END] * rise, r[SHORT] > 0.0
            free, gain = _carry(r[TO_END:], x, v, old, new, f), (r[TO_END + 5], r[TO_END + 11])
            if short:
                g = f
                for _ in range(2):  # near enough to find the middle value
                    end = (free[0] + gain[0] * g, free[1] + gain[1] * g)
                    g = _move(c, s, AT_BEGIN, AT_END, (x, v), end, step, True)
                mean = 0.5 * (f + g)
                xm, vm = _carry(r[TO_MIDDLE:], x, v, old, w + r[MIDDLE] * rise, f)
                half = (xm + r[TO_MIDDLE + 5] * mean, vm + r[TO_MIDDLE + 11] * mean)
                bulge = _move(c, s, AT_BEGIN, AT_MIDDLE, (x, v), half, 0.5 * step, True) - mean
                free = (free[0] + r[BULGE] * bulge, free[1] + r[BULGE + 1] * bulge)
                f = _balance(c, s, AT_MIDDLE, half, free, gain, 0.5 * step, True, g)
            else:
                f = _balance(c, s, AT_BEGIN, (x, v), free, gain, step, False, f)
            x, v, old = free[0] + gain[0] * f, free[1] + gain[1] * f, new
            for n in range(CARRIED, CARRIED + carried):
                s[n] = s[n + AT_END * carried]
            i = i + 1 if i + 1 < len(c) else first
            if r[LAST] > 0.0:
                break
        w = bus[FREE, j]
        bus[POSITION, j] = x
    s[X], s[V], s[W], s[F] = x, v, w, f
