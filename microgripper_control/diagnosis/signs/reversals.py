"""How the residual goes on after the motion turns: in play, in friction, in a wrong loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.residuals import Residual

AT_ONE = 1e-12  # of the spread of all: what has less lies at one place
EDGES = (0.0, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64)  # of the stroke: bins of travel
PLATEAU = 3  # last bins: far behind a turn
RATES = 4  # bins


@dataclass(frozen=True)
class AfterTurns:
    """The error in the direction of motion against the distance travelled since the last turn."""

    turns: int
    jump: float  # m, from just after a turn to far behind it
    unsteady: float  # of the jump: how much the error still changes far behind
    explained: float  # of the error's squares


def after_turns(residuals: Sequence[Residual]) -> AfterTurns | None:
    """The course of the error after turns; None for too few of them."""
    bins, signed = [], []
    count = 0
    for residual in residuals:
        direction, travel, turns = residual.turning
        known = residual.counted & (direction != 0.0)
        error = residual.error - np.mean(residual.error[residual.counted])
        bins.append(np.searchsorted(EDGES, travel[known], side="right") - 1)
        signed.append((direction * error)[known])
        count += turns
    bin_of, values = np.concatenate(bins), np.concatenate(signed)
    sizes = np.bincount(bin_of, minlength=len(EDGES))[: len(EDGES) - 1]
    filled = np.flatnonzero(sizes >= 20)
    if count < 6 or len(filled) < PLATEAU + 2 or not values.any():
        return None
    sums = np.bincount(bin_of, weights=values, minlength=len(EDGES))[: len(EDGES) - 1]
    means = sums[filled] / sizes[filled]
    far = means[-PLATEAU:]
    jump = float(far.mean() - means[0])
    explained = float(sizes[filled] @ means**2) / float(values @ values)
    unsteady = float(np.ptp(far)) / max(abs(jump), 1e-300)
    return AfterTurns(count, jump, unsteady, explained)


@dataclass(frozen=True)
class Widths:
    """How wide the residual's loop is at several rates of the voltage."""

    rates: Array  # V/s
    widths: Array  # m, of the rising branch under the falling one
    growth: float  # m per decade of rate
    certainty: float  # growth over its error
    decades: float  # of rate


def widths_by_rate(residuals: Sequence[Residual]) -> Widths | None:
    """The residual's loop against the rate; None for rates less than half a decade apart."""
    rates, shapes, errors, pieces = [], [], [], []
    for number, residual in enumerate(residuals):
        direction, travel, _ = residual.turning
        voltage = residual.recording.voltage
        reach = _reach(direction)
        pace = np.abs(voltage[2 * reach :] - voltage[: -2 * reach]) / (
            2.0 * reach * residual.period
        )
        rate = np.concatenate([np.full(reach, pace[0]), pace, np.full(reach, pace[-1])])
        known = residual.counted & (direction != 0.0) & (travel > EDGES[3]) & (rate > 0.0)
        rates.append(rate[known])
        shapes.append(direction[known])
        errors.append((residual.error - np.mean(residual.error[residual.counted]))[known])
        pieces.append(number * 20 + np.arange(np.count_nonzero(known)) * 20 // max(1, known.sum()))
    rate, shape = np.concatenate(rates), np.concatenate(shapes)
    error, piece = np.concatenate(errors), np.concatenate(pieces)
    if len(rate) < 500:
        return None
    # A staircase or triangle has few rates, each many times: bins between them would be empty.
    edges = np.unique(np.quantile(rate, np.linspace(0.0, 1.0, RATES + 1), method="inverted_cdf"))
    bins = range(max(1, len(edges) - 1))
    bin_of = np.clip(np.searchsorted(edges, rate, side="right") - 1, 0, bins[-1])
    middles = np.array([float(np.median(rate[bin_of == b])) for b in bins])
    decades = float(np.log10(middles[-1] / middles[0]))
    if decades < 0.5:
        return None
    widths = np.array([-2.0 * float(np.mean((shape * error)[bin_of == b])) for b in bins])
    # Each twentieth of a recording is left out in turn: neighbours are not independent.
    slopes = -2.0 * _slopes_without(piece, np.log10(rate), shape * error)
    count = len(slopes)
    scatter = float(np.sqrt((count - 1) / count * np.sum((slopes - np.mean(slopes)) ** 2)))
    growth = float(np.mean(slopes))
    return Widths(middles, widths, growth, abs(growth) / max(scatter, 1e-300), decades)


def _slopes_without(piece: NDArray[np.int64], x: Array, y: Array) -> Array:
    """The slope of a straight line through all points but those of one piece, for each piece.

    0 where the others all lie at one x.
    """
    x, y = x - x.mean(), y - y.mean()
    _, number = np.unique(piece, return_inverse=True)
    sums = np.array([np.bincount(number, part) for part in (np.ones(len(x)), x, y, x * x, x * y)])
    n, sx, sy, sxx, sxy = sums.sum(axis=1, keepdims=True) - sums
    spread = n * sxx - sx * sx
    told = spread > AT_ONE * len(x) * float(x @ x)
    slopes: Array = np.divide(n * sxy - sx * sy, spread, out=np.zeros_like(spread), where=told)
    return slopes


def _reach(direction: Array) -> int:
    """How many samples either side of one tell its rate: few beside a quick way between turns.

    Steps within a way become a pace by that, and no loop is averaged away.
    """
    ways = np.diff(np.flatnonzero(np.diff(direction)))
    quick = int(np.quantile(ways, 0.25)) if len(ways) else len(direction)
    return max(1, min(len(direction) // 400, quick // 8))
