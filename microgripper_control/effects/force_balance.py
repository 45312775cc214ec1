"""One mass under forces that push back, solved inside each of its steps.

    m x'' + b x' + (k + k_s) x = k w + F(x, x', path)

The left side and w are taken exactly, as without forces. Over a step that is short against the
period, F runs along the parabola through its values at the beginning, in the middle and at the end.
The laws are asked twice, at places that the last step's parabola foretells: such a parabola's value
at the end hardly moves x, so that nothing is left to solve. It does change the speed: what laws
that brake give is solved for, once beside what the others are foretold to give, for these to be
asked in the right place, then beside what they give. The error falls with the fourth power of the
step.

Where a step is long against the period of the mass, which has come to rest by its end, F runs
straight and only its end value counts. What is solved for is the root of one equation,
F = law(x(F), x'(F)), found by secants inside a bracket; for a force that restores or brakes it has
one root, and a stiff contact does not chatter.

Where the mass turns within a step, the way is split there for the laws that follow its path. They
go on from where they were asked last, which is a little beside the mass.
Sources: exponential steps, Hochbruck and Ostermann 2010; Lobatto nodes and extrapolated starting
values, Hairer, Norsett, Wanner 1993, sections II.7 and II.14.
"""

import math

from microgripper_control.core.compiled import call_at, compiled, inlined
from microgripper_control.core.signals import FREE, POSITION, Array

# Coefficients: one row that says how many laws there are and how many numbers they carry, then the
# same without those that brake (see `effects.base.Force`), which come last; one row a law (address,
# how many numbers it carries, its coefficients); then one row a substep:
DURATION = 0  # s
MIDDLE, END = 1, 2  # the share of the change of w within the step of the bus that is done by then
LAST = 3  # 1 if it ends the step of the bus
SHORT = 4  # if it is short against the period one over its duration, 1 / s, else 0
TO_MIDDLE, TO_END = 5, 19  # how (x, v, w before, w after, F before, in the middle, after) give x
V_TABLE = 7  # numbers on, how they give v
TABLES_END = TO_END + 2 * V_TABLE
COLUMNS = 42  # of the longest law, the springs that slip

# State: x, v, w, F, how fast F changes, N/s, where the laws were asked last, m; beside other laws,
# what brakes of F and how fast that changes; then what the laws carry from there, and room for what
# they would carry from elsewhere.
X, V, W, F, TREND, ASKED, BRAKED, BRAKED_TREND, CARRIED = 0, 1, 2, 3, 4, 5, 6, 7, 8
NOW, TRIED = 0, 1

Pair = tuple[float, float]  # of x, m, and v, m/s, or what goes into them per N
Part = tuple[int, int, int]  # of the laws: the first, the one after the last, numbers before theirs

MOST_TRIALS = 100
CLOSE = 1e-8  # of the way: how far off an error of the force may put the mass
ROUNDING = 1e-15  # of the position


@inlined
def _rows(c: Array) -> tuple[int, int, int]:
    """The first law that brakes, the first substep, and what the laws before both carry."""
    return 1 + int(c[0, 2]), 1 + int(c[0, 0]), int(c[0, 3])


@inlined
def _push(
    c: Array, s: Array, part: Part, after: int, x0: float, x1: float, v: float, step: float
) -> float:
    """Sum of a part of the laws for a way in one direction."""
    source = s.ctypes.data + 8 * (CARRIED + part[2])
    target = source + 8 * after * int(c[0, 1])
    total = 0.0
    for i in range(part[0], part[1]):
        law = c.ctypes.data + 8 * (i * COLUMNS + 2)
        total += call_at(int(c[i, 0]), (law, source, target, x0, x1, v, step))
        source += 8 * int(c[i, 1])
        target += 8 * int(c[i, 1])
    return total


@inlined
def _turn(begin: Pair, end: Pair, step: float) -> Pair:
    """When, as a share of the step, and where, m, v passes zero on the cubic course of x.

    The speeds at its ends have opposite signs, so it does so once: where a straight course of v
    does, and a Newton step from there.
    """
    v0, v1 = step * begin[1], step * end[1]
    per = 1.0 / (v0 - v1)
    at = v0 * per
    bend = end[0] - begin[0] - 0.5 * (v0 + v1)
    v = 6.0 * bend * at * (1.0 - at)
    x = begin[0] + at * (0.5 * v0 + bend * at * (3.0 - 2.0 * at))
    return at + v * per, x + 0.5 * v * v * per


@inlined
def _move(
    c: Array, s: Array, part: Part, asked: float, begin: Pair, end: Pair, step: float
) -> float:
    """Force of a part of the laws at the end of a way that may turn once."""
    if begin[1] * end[1] < 0.0:
        at, turn = _turn(begin, end, step)
        _push(c, s, part, NOW, asked, turn, 0.0, step * at)
        return _push(c, s, part, NOW, turn, end[0], end[1], step * (1.0 - at))
    return _push(c, s, part, NOW, asked, end[0], end[1], step)


@compiled
def _balance(
    c: Array,
    s: Array,
    first: int,
    skipped: int,
    keep: bool,
    begin: float,
    asked: float,
    free: Pair,
    gain: Pair,
    step: float,
    guess: float,
) -> float:
    """The F for which the laws from `first` on, at free + gain F, give F.

    `begin` is where x was at the sample. What those before them carry, so many numbers, is skipped;
    what they would carry themselves is kept or not.
    """
    low, high = -math.inf, math.inf
    f, last, last_excess = guess, 0.0, 0.0
    law = f
    for trial in range(MOST_TRIALS):
        x = free[0] + gain[0] * f
        law = _push(
            c, s, (first, 1 + int(c[0, 0]), skipped), TRIED, asked, x, free[1] + gain[1] * f, step
        )
        excess = f - law
        if not abs(gain[0] * excess) > max(CLOSE * abs(x - begin), ROUNDING * abs(x)):
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
    if keep:
        carried = int(c[0, 1])
        for n in range(CARRIED + skipped, CARRIED + carried):
            s[n] = s[n + TRIED * carried]
    return law


@compiled
def _ask(
    c: Array,
    s: Array,
    begin: float,
    asked: float,
    start: Pair,
    free: Pair,
    gain: Pair,
    step: float,
    f: float,
    q: float,
) -> tuple[Pair, float, float]:
    """Where the laws that do not brake are asked, F, and its part q by those that do.

    F and q are given as foretold, `free` is without F.
    """
    braking, _, skipped = _rows(c)
    p = f - q
    if braking > 1:
        q = _balance(
            c, s, braking, skipped, False, begin, asked, _add(free, gain, p), gain, step, q
        )
    there = _add(free, gain, p + q)
    p = _move(c, s, (1, braking, 0), asked, start, there, step)
    q = _balance(c, s, braking, skipped, True, begin, asked, _add(free, gain, p), gain, step, q)
    return there, p + q, q


@inlined
def _carry(c: Array, i: int, to: int, begin: Pair, w0: float, w1: float, f: float) -> Pair:
    """Where a table of row i takes x and v if F were zero but at the beginning."""
    x, v = begin
    k = to + V_TABLE
    # What is known first comes first: x and v wait for no more than two products.
    fx = c[i, to + 4] * f + (c[i, to + 2] * w0 + c[i, to + 3] * w1)
    fv = c[i, k + 4] * f + (c[i, k + 2] * w0 + c[i, k + 3] * w1)
    return (
        c[i, to] * x + (c[i, to + 1] * v + fx),
        c[i, k] * x + (c[i, k + 1] * v + fv),
    )


@inlined
def _gain(c: Array, i: int, column: int) -> Pair:
    return c[i, column], c[i, column + V_TABLE]


@inlined
def _add(free: Pair, gain: Pair, f: float) -> Pair:
    return free[0] + gain[0] * f, free[1] + gain[1] * f


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    """As `effects.base.Kernel`; the rows of both arrays are told above."""
    c, s = coefficients, state
    braking, first, skipped = _rows(c)
    x, v, w, f, trend, asked = s[X], s[V], s[W], s[F], s[TREND], s[ASKED]
    following, solved, qm = (1, braking, 0), braking < first, 0.0
    i = first
    for j in range(bus.shape[1]):
        rise, old, begin = bus[FREE, j] - w, w, x
        while True:
            step, new = c[i, DURATION], w + c[i, END] * rise
            often = c[i, SHORT]
            free, gain = _carry(c, i, TO_END, (x, v), old, new, f), _gain(c, i, TO_END + 6)
            if often > 0.0:
                half, wm = 0.5 * step, w + c[i, MIDDLE] * rise
                middle = _carry(c, i, TO_MIDDLE, (x, v), old, wm, f)
                by_middle = _gain(c, i, TO_MIDDLE + 6)
                guess = f + half * trend
                if solved:
                    qm = s[BRAKED] + half * s[BRAKED_TREND]
                    there, fm, qm = _ask(
                        c, s, begin, asked, (x, v), middle, by_middle, half, guess, qm
                    )
                else:
                    there = _add(middle, by_middle, guess)
                    fm = _move(c, s, following, asked, (x, v), there, half)
                free = _add(free, _gain(c, i, TO_END + 5), fm)
                guess = 4.0 * fm - (3.0 * f + step * trend)
                if solved:
                    qe = 4.0 * qm - (3.0 * s[BRAKED] + step * s[BRAKED_TREND])
                    end, fe, qe = _ask(c, s, begin, there[0], there, free, gain, half, guess, qe)
                    s[BRAKED_TREND] = (3.0 * qe + (s[BRAKED] - 4.0 * qm)) * often
                    s[BRAKED] = qe
                else:
                    end = _add(free, gain, guess)
                    fe = _move(c, s, following, there[0], there, end, half)
                trend, asked = (3.0 * fe + (f - 4.0 * fm)) * often, end[0]
                f = fe
                x, v = _add(free, gain, f)
            else:
                f = _balance(c, s, 1, 0, True, begin, asked, free, gain, step, f)
                x, v = _add(free, gain, f)
                trend, asked = 0.0, x
                if 1 < braking < first:
                    s[BRAKED] = _push(c, s, (braking, first, skipped), TRIED, x, x, v, 0.0)
                    s[BRAKED_TREND] = 0.0
            old = new
            ends = c[i, LAST] > 0.0
            i = i + 1 if i + 1 < len(c) else first
            if ends:
                break
        w = bus[FREE, j]
        bus[POSITION, j] = x
    s[X], s[V], s[W], s[F], s[TREND], s[ASKED] = x, v, w, f, trend, asked
