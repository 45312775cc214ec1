"""Whether what is given with 0.8 is right eight times in ten."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from microgripper_control.examination.marking import Marked
from microgripper_control.examination.plan import PAIRS
from microgripper_control.examination.shares import Share

BINS = 10
DRAWS, BY_CHANCE = 1000, (0.025, 0.975)  # and the quantiles of what they show
CLAIMED = 0.05  # `present` from which an effect counts as being talked about

Claim = tuple[float, bool]  # a probability, and whether it came true


@dataclass(frozen=True)
class Bin:
    """Claims of about the same probability."""

    low: float
    high: float
    mean: float  # of the probabilities
    share: Share  # that came true


@dataclass(frozen=True)
class Reliability:
    """Claims by their probability, and the expected calibration error.

    The error is the mean over the claims of |share that came true - mean probability| of their bin
    (Naeini, Cooper and Hauskrecht 2015). It is never zero of few claims: `by_chance` are the bounds
    within which 95 % of its values lie if each claim comes true with just its probability. NaN
    without claims.
    """

    bins: tuple[Bin, ...]
    error: float
    by_chance: tuple[float, float]
    of: int


def reliability(claims: Sequence[Claim]) -> Reliability:
    """Sort claims into BINS bins of equal width; empty bins are left out."""
    if not claims:
        return Reliability((), float("nan"), (float("nan"), float("nan")), 0)
    probability = np.array([claim[0] for claim in claims])
    true = np.array([claim[1] for claim in claims])
    number = np.clip((probability * BINS).astype(int), 0, BINS - 1)
    drawn = np.random.default_rng(0).random((DRAWS, len(claims))) < probability
    bins, error, by_chance = [], 0.0, np.zeros(DRAWS)
    for index in np.unique(number).tolist():
        inside = number == index
        share = Share(int(true[inside].sum()), int(inside.sum()))
        mean = float(probability[inside].mean())
        bins.append(Bin(index / BINS, (index + 1) / BINS, mean, share))
        error += share.of / len(claims) * abs(share.value - mean)
        by_chance += share.of / len(claims) * np.abs(drawn[:, inside].mean(axis=1) - mean)
    low, high = np.quantile(by_chance, BY_CHANCE).tolist()
    return Reliability(tuple(bins), error, (low, high), len(claims))


def answers(cases: Iterable[Marked]) -> list[Claim]:
    """The most probable entry of each case whose right answer is known, and whether it is that.

    Of two at once the right entry is the stronger one, as `probability` says of itself. Members of
    a group whose oracles agree stand for each other.
    """
    claims = []
    for case in cases:
        if case.diagnosis is None or case.asked is None:
            continue
        top = max(case.diagnosis["candidates"], key=lambda entry: entry["probability"])
        name, probability = top["effect"], float(top["probability"])
        if case.sealed.question == PAIRS:
            true = name == case.sealed.seen[0].effect
        else:
            true = name == case.asked or (bool(case.right) and name == case.said)
        claims.append((probability, true))
    return claims


def presences(cases: Iterable[Marked], least: float = 0.0) -> list[Claim]:
    """`present` of each effect in each case, and whether it is at work.

    Effects at work that cannot be seen are left out, and so are claims below `least`: most entries
    are a well-founded zero, beside which the others would not count.
    """
    claims = []
    for case in cases:
        if case.diagnosis is None:
            continue
        seen = {cause.effect for cause in case.sealed.seen}
        hidden = {cause.effect for cause in case.sealed.causes} - seen
        claims += [
            (float(entry["present"]), entry["effect"] in seen)
            for entry in case.diagnosis["candidates"]
            if entry["stage"] is not None
            and entry["effect"] not in hidden
            and entry["present"] >= least
        ]
    return claims
