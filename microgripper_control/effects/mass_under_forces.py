"""Makes the solve of `force_balance` ready: how a step of the bus is divided, and the exact maps.

The division follows from the masses and springs alone. After a jump of w the mass rings, with
omega = sqrt((k + k_s + stiffness of the forces)/m), and dies away at a rate lambda.

- A mass that comes to rest within the step needs two substeps (one if w ran straight, for then it
  hardly rings): forces that know only where it stands forget the way it came.
- Forces that follow the path count every turn of the ringing: some substeps a half swing until it
  has died away, and one for the rest. That is counted from jump to jump, however finely a link
  behind wants to see the mass on its way.
- A mass that still moves at the end of the step needs FINE radians of the ringing a substep, and
  FINE_BY_PATH where forces follow the path; coarser ones do where much has died away by the end,
  or where such forces are weak beside k + k_s, and finer ones are needed where such forces damp.
  Where only a link behind wants to see the mass on its way, the end is that before the next jump.

Measured against tight integration at 200 Hz to 20 kHz, for forces that do up to 0.2 um beside the
paper's actuator and the maker's figures: 1e-9 m for a smooth voltage, 3e-9 m for jumps by 80 V at
random. Forces that do more are followed to 1 % of that where they ring, to 2e-3 where a smooth
voltage's corners are as far apart as the mass takes to come to rest, else to 1e-3. Of forces that
know only where the mass stands, a lag, a mode or a delay behind it reads the ringing to 1e-9 m rms
under jumps by up to 150 V, and a play, which keeps its peaks, to 4e-9 m.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import compress, pairwise

import numpy as np
from scipy.linalg import expm

from microgripper_control.core.compiled import address_of
from microgripper_control.core.errors import TooStiffError
from microgripper_control.core.signals import FREE, HIGH, LOW, POSITION, ROWS, Array, Timing
from microgripper_control.effects import force_balance as layout
from microgripper_control.effects.base import Load, Prepared, Values
from microgripper_control.effects.past import ways

FINE = 0.3  # rad
FINE_BY_PATH = 0.16  # rad; for weak forces that follow it, by their share in the stiffness ** -1/4
COARSER = 6.0  # times that, at most, where the ringing dies away within the step
PIECES = 4.5  # of a half swing of such a ringing, times the root of the forces' share
WEAKEST = 0.04  # share of the forces in the stiffness: weaker ones are not treated coarser
DAMPED = 4.0  # so much finer, times what those forces damp over m omega,
MOST_DAMPED = 10.0  # which is followed up to here; from 2 on nothing rings
SHORT = 3.3  # rad, up to which F runs along a parabola
AT_REST = 4.0  # time constants after which the course of a substep does not matter,
AT_REST_SMOOTHLY = 2.4  # and where w runs from corner to corner and the mass hardly rings
DIED_AWAY = 5.0  # time constants after which the rest of the ringing does not matter
RUNG = 1.25  # omega is rounded to powers of this where substeps are counted
MOST_SUBSTEPS = 1000
HARDLY = 1e-6  # of a step: no substep is shorter
FOREVER = 1e9  # s
LASTS = 3.0  # time constants a sample: what has died away before the next sample was not seen
FAST = 0.5  # rad a sample: slower ringing is drawn by the samples, and a fit finds it


def prepare(values: Values, timing: Timing, levels: Array, loads: Sequence[Load]) -> Prepared:
    """As `second_order.prepare`. At rest the mass has come slowly, as h has it.

    Raises TooStiffError where forces damp more than can be followed.
    """
    loads = sorted(loads, key=lambda load: load[0].brakes)  # those that brake come last
    laws = _laws(loads)
    ringing = _Ringing.of(values, loads)
    substeps = []
    own = (values["m"], values["b"], values["k"], values["k_s"])
    for step, spans in zip(timing.steps, ringing.divisions(timing), strict=True):
        substeps.append(_substeps(own, ringing.omega, step, tuple(spans), timing.ramped))
    state = _begun(values, loads, levels)
    still = np.array([*laws, _rest(values)])
    there_and_back = np.array([HIGH, LOW, HIGH])
    levels[there_and_back + POSITION] = _go(
        still, np.zeros_like(state), levels[there_and_back + FREE]
    )
    levels[POSITION] = _go(still, state, levels[[FREE]])[0]  # only refines
    return Prepared(np.vstack([*laws, *substeps]), state, ramped=True)


def _finer(values: Values, omega: float, loads: Sequence[Load]) -> float:
    """How much finer substeps have to be because forces damp."""
    damping, own = sum(force.damping(given) for force, given in loads), values["m"] * omega
    if damping > MOST_DAMPED * own:
        raise TooStiffError(
            f"a force damps by {damping:g} N*s/m; beside these mechanics up to "
            f"{MOST_DAMPED * own:.0f} can be followed, and far less keeps them from ringing: lower "
            "the damping of friction"
        )
    return 1.0 + DAMPED * damping / own


def _laws(loads: Sequence[Load]) -> list[Array]:
    """The rows of the laws, and the one before them."""
    gentle = [force.states for force, _ in loads if not force.brakes]
    carried = sum(force.states for force, _ in loads)
    laws = [_row([len(loads), carried, len(gentle), sum(gentle)])]
    for force, given in loads:
        address = address_of(force.law, arrays=3, numbers=4)
        laws.append(_row([address, force.states, *force.coefficients(given)]))
    return laws


def _begun(values: Values, loads: Sequence[Load], levels: Array) -> Array:
    """The state of a mass at rest, with what its forces hold of the way there.

    What has let go does not push when the run begins, so the mass has come there without it.
    """
    holding = [force.released(given) == 0.0 for force, given in loads]
    still = np.array([*_laws(list(compress(loads, holding))), _rest(values)])
    state = np.zeros(layout.CARRIED + 2 * int(still[0, 1]))
    for share, way in ways(levels, FREE):
        came = np.zeros_like(state)
        _go(still, came, np.array(way))
        state += share * came
    begun, first = [state[: layout.CARRIED]], layout.CARRIED
    for (force, _), holds in zip(loads, holding, strict=True):
        begun.append(state[first : first + force.states] if holds else np.zeros(force.states))
        first += force.states * holds
    carried = sum(force.states for force, _ in loads)
    return np.concatenate([*begun, np.zeros(carried)])


def _go(still: Array, state: Array, way: Array) -> Array:
    """Take a mass slowly along a way of the free displacement, m; where it turns and ends, m."""
    bus = np.zeros((ROWS, len(way)))
    bus[FREE] = way
    layout.kernel(still, state, bus)
    positions: Array = bus[POSITION]
    return positions


def natural_frequency(values: Values, loads: Sequence[Load] = ()) -> float:
    """Of the mass on its springs, and on forces that push back, rad/s."""
    return math.sqrt(_stiffness(values, loads) / values["m"])


def rings_on(values: Values, period: float) -> bool:
    """Whether the mass still rings after a sample period, s, which is not short for its swings."""
    omega = natural_frequency(values)
    decay = min(omega, values["b"] / (2.0 * values["m"]))
    return decay * period < LASTS and omega * period > FAST


def _stiffness(values: Values, loads: Sequence[Load]) -> float:
    return values["k"] + values["k_s"] + sum(force.stiffness(given) for force, given in loads)


def _row(numbers: Sequence[float]) -> Array:
    row = np.zeros(layout.COLUMNS)
    row[: len(numbers)] = numbers
    return row


def _rest(values: Values) -> Array:
    """A substep that is as good as endless: only the levels of w and F count."""
    row = _row([FOREVER, 1.0, 1.0, 1.0])
    row[layout.TO_END + 3] = values["k"] / (values["k"] + values["k_s"])
    row[layout.TO_END + 6] = 1.0 / (values["k"] + values["k_s"])
    return row


@dataclass(frozen=True)
class _Ringing:
    """How the mass swings on springs and forces, and how finely that is followed."""

    own: float  # rad/s, without forces
    omega: float  # rad/s, with them
    half: float  # 1/s, b / 2 m
    by_path: bool  # whether forces follow the path
    finer: float  # substeps by that factor where forces damp

    @classmethod
    def of(cls, values: Values, loads: Sequence[Load]) -> _Ringing:
        """That of a mass under forces. Raises TooStiffError as `prepare`."""
        omega = natural_frequency(values, loads)
        by_path = any(force.states and not force.fading for force, _ in loads)
        half, finer = values["b"] / (2.0 * values["m"]), _finer(values, omega, loads)
        return cls(natural_frequency(values), omega, half, by_path, finer)

    @property
    def decay(self) -> float:
        """1/s, how fast it dies away."""
        return self.half - math.sqrt(max(0.0, self.half**2 - self.own**2))

    @property
    def share(self) -> float:
        """The forces' share in the stiffness, or WEAKEST."""
        return max(WEAKEST, 1.0 - (self.own / self.omega) ** 2)

    @property
    def fine(self) -> float:
        """Radians in a substep while it rings; by place, forces may stiffen as they go."""
        return (FINE_BY_PATH / self.share**0.25 if self.by_path else FINE) / self.finer

    def divisions(self, timing: Timing) -> Iterator[list[float]]:
        """The substeps of each step of the bus, s."""
        if timing.ramped:
            for step in timing.steps:
                yield self._evenly(step, step, 1, AT_REST_SMOOTHLY)
            return
        for steps in _from_jump_to_jump(timing):
            whole = sum(steps)
            if self.by_path:
                turns = self.half < self.own
                spans = self._by_turns(whole) if turns else self._evenly(whole, whole, 2, AT_REST)
                yield from _cut(spans, steps)
            else:
                for first, step in enumerate(steps):
                    yield self._evenly(step, sum(steps[first:]), 2, AT_REST)

    def _evenly(self, step: float, left: float, count: int, rest: float) -> list[float]:
        """Substeps of a step, s: `count` if each of them lasts `rest` time constants.

        `left`, s, is how long from its begin on there is no jump.
        """
        if self.decay * step < rest * count:
            coarser = math.exp(min(self.decay * left / count, math.log(COARSER)))
            count = math.ceil(step * self.omega / (self.fine * coarser))
            count = min(MOST_SUBSTEPS, count)
        return [step / count] * count

    def _by_turns(self, step: float) -> list[float]:
        """Substeps, s, of the ringing after a jump that meet where the mass turns."""
        lasting = math.exp(-self.decay * step / 2.5)
        own_pieces = PIECES * math.sqrt(self.share) * self.finer
        pieces = lasting * math.pi / self.fine + (1.0 - lasting) * own_pieces
        pieces = max(1, round(pieces))
        span = math.pi / math.sqrt(self.omega**2 - self.half**2) / pieces
        if self.decay * step > DIED_AWAY + AT_REST:
            # A fit moves omega by a little each time: the count must not hop along with it.
            rounded = self.own * RUNG ** math.ceil(math.log(self.omega / self.own, RUNG) - 0.25)
            swings = DIED_AWAY / self.decay * math.sqrt(rounded**2 - self.half**2) / math.pi
            count = min(MOST_SUBSTEPS, math.ceil(swings * pieces))
            return [*[span] * count, step - count * span]
        count = min(MOST_SUBSTEPS, math.ceil(step / span))
        return [step / count] * count


def _from_jump_to_jump(timing: Timing) -> Iterator[tuple[float, ...]]:
    """Steps of the bus, s, of which the first alone begins with a jump: ringing goes on in them."""
    begin = 0
    while begin < len(timing.steps):
        end = begin + 1
        while end in timing.quiet:
            end += 1
        yield timing.steps[begin:end]
        begin = end


def _cut(spans: Sequence[float], steps: Sequence[float]) -> Iterator[list[float]]:
    """Spans that follow each other, cut where steps of the same whole length end."""
    ends = np.cumsum(spans)
    edges = np.append(0.0, np.cumsum(steps))
    for begin, end in pairwise(edges):
        close = HARDLY * (end - begin)
        inside = ends[(ends > begin + close) & (ends < end - close)]
        yield np.diff([begin, *inside, end]).tolist()


@lru_cache(maxsize=64)
def _substeps(
    own: tuple[float, float, float, float],
    omega: float,
    step: float,
    spans: tuple[float, ...],
    ramped: bool,
) -> Array:
    """Rows of a step of the bus; most chains differ from the one before in another link only."""
    rows, begin = [], 0.0
    for index, span in enumerate(spans):
        last = index == len(spans) - 1
        short = omega * span < SHORT
        row = _row([span, 1.0, 1.0, float(last), 1.0 / span if short else 0.0])
        if ramped:
            row[layout.MIDDLE] = (begin + 0.5 * span) / step
            row[layout.END] = 1.0 if last else (begin + span) / step
        row[layout.TO_MIDDLE : layout.TO_END] = _map(*own, 0.5 * span, ramped, False)
        row[layout.TO_END : layout.TABLES_END] = _map(*own, span, ramped, short)
        rows.append(row)
        begin += span
    return np.array(rows)


@lru_cache(maxsize=256)
def _map(
    m: float, b: float, k: float, k_s: float, span: float, ramped: bool, curved: bool
) -> Array:
    """The exact map over `span`, 14 numbers, for an F that runs along a parabola or straight."""
    omega = math.sqrt((k + k_s) / m)
    turned = omega * span
    # x and v / omega, driven by a constant, a straight line and a square over the span.
    system = np.zeros((5, 5))
    system[0, 1] = turned
    system[1, :3] = -turned, -b / (m * omega) * turned, turned / (k + k_s)
    system[2, 3], system[3, 4] = 1.0, 2.0
    e = expm(system)[:2] * np.array([[1.0], [omega]])
    level, line, square = e[:, 2], e[:, 3], e[:, 4]
    zero = np.zeros(2)
    of_w = (level - line, line) if ramped else (zero, level)
    bulge = 4.0 * (line - square) if curved else zero  # of height one, on the straight course
    of_f = (level - line - 0.5 * bulge, bulge, line - 0.5 * bulge)
    own = e[:, :2] / np.array([1.0, omega])
    table: Array = np.column_stack([own, k * of_w[0], k * of_w[1], *of_f])
    return table.ravel()
