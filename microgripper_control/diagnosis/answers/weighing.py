"""How probable each explanation is, from what all of them leave.

An explanation is a set of effects. Its evidence is the logarithm of how far it brings the error
down, times the number of independent samples:

    E = M ln(R_refit / R) + exact ln(r_refit / r) - odds,
    R^2 = rmse^2 + (mismatch e)^2,        r^2 = rmse^2 - floor^2 + 0.1 floor^2

M counts the residual of the refit by its autocorrelation time and is capped: many samples do not
make a wrong law right. No law of the library is the rig's own, so the right one still leaves a
share `mismatch` of the gap e = sqrt(refit^2 - floor^2), and what is left below it says little. It
says something, for of two laws that close the gap the one that leaves nothing but noise is right
more often: that is the second term. Below the floor nothing counts.
Both terms are taken on the judging samples and, with a weight, on the fitted ones: an effect may
show in the one and not in the other. Flexible laws are held back by the former.
`odds` are what an explanation must gain before it is believed: one amount for an effect, a further
one for each other, a little for each parameter that is at work; less where their signatures are
there and more where they should be and are not; and more for what is left of the gap where an
effect's name leaves its law little choice.
`none` is the nominal model as it was given, `parameters` the refit, `unknown` a law that is not in
the library and leaves the share `unknown_rest` of the gap, or a gain that changes slowly and leaves
less than a drift does (`fits.gain_course`).

The constants of `Weights` were fitted to cases of two rigs that share no code with the library (one
is that of `validation/`, form a, seeds below 10000), and to the same cases with the right effect
left out of the library; `docs/calibration.md` says which.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.grid import unrounded
from microgripper_control.diagnosis.data.noise import removable
from microgripper_control.diagnosis.findings import NONE, PARAMETERS, UNKNOWN, Signature
from microgripper_control.diagnosis.fits.gain_course import DRIFT, followed
from microgripper_control.diagnosis.fits.trial import Trial, evenly
from microgripper_control.diagnosis.search.pool import Pool, is_read_off
from microgripper_control.effects.registry import registry
from microgripper_control.identification.confidence import independent_samples

Explanation = frozenset[str]
NOTHING: Explanation = frozenset([NONE])
MISTUNED: Explanation = frozenset([PARAMETERS])
OUTSIDE: Explanation = frozenset([UNKNOWN])
# What an effect's signature says for it where it is there, a natural logarithm of odds: half of how
# much oftener it was there with the effect at work than without. The fits have seen the same, so
# it does not count in full.
AGREES = {
    "mains_hum": 2.6,
    "sensor_quantization": 2.6,
    "extra_resonance": 2.3,
    "creep": 2.2,
    "rate_dependent_hysteresis": 1.8,
    "slew_limit": 1.5,
    "amplifier_lag": 1.4,
    "thermal_drift": 1.3,
    "transport_delay": 1.3,
    "sensor_lag": 1.3,  # three lags show alike: the sign must hardly decide between them
    "contact": 1.1,
    "saturation": 0.8,
    "backlash": 0.7,
    "friction": 0.6,
}
# What leaving all of the gap would cost an effect, and in proportion what it leaves of it. A drift
# has a course of its own in each recording, which leaves next to nothing of what is a drift.
# Hysteresis and friction are named by what they do: each rig has a law of its own.
LEAVING = {
    "thermal_drift": 4.0,
    "asymmetric_hysteresis": 0.0,
    "rate_dependent_hysteresis": 0.0,
    "friction": 0.0,
    "restoring_force_hysteresis": 0.0,
}
NEARLY = 0.1  # of the noise's power: what a law may leave besides and be as good as the rig's own
FAR_LESS = 0.7  # of what a drift leaves: what leaves less is spoken of
USUAL = 3  # parameters that are at work in an effect's law
TINY = 1e-30  # m^2: keeps an error of zero from being infinitely good


@dataclass(frozen=True)
class Weights:
    """What the weighing was calibrated to; all in natural logarithms of odds or shares."""

    least: float = 16.0  # independent samples that count, however few they seem,
    most: float = 24.0  # and however many
    fitted: float = 1.0  # weight of the fitted samples beside the judging ones
    mismatch: float = 1.2
    exact: float = 0.9
    unknown_rest: float = 0.14
    effect: float = 4.3
    further: float = 1.0
    unknown: float = 5.7
    none: float = 3.4  # in favour of the model as it was given
    parameter: float = 0.15  # for each parameter at work beyond the usual, in favour below
    leaving: float = 2.0  # as LEAVING, of an effect that is not there
    contradicts: float = 0.7  # against an effect whose signature should be there and is not
    unusual: float = 2.0  # against one of a size that goes by another name; not fitted to cases


CALIBRATED = Weights()


class Left(NamedTuple):
    """An error on the judging samples and on the fitted ones, m."""

    judged: float
    fitted: float

    @property
    def both(self) -> float:
        """As `Trial.both`."""
        return evenly(*self)


@dataclass(frozen=True)
class Facts:
    """What the weighing looks at: what each explanation leaves, and M."""

    nominal: Left
    refit: Left
    floor: float
    independent: float
    tried: Mapping[Explanation, Left]
    gains: Mapping[Explanation, Left] = field(default_factory=dict)  # with a gain's for a drift
    signs: Mapping[str, bool | None] = field(default_factory=dict)  # effect: does it agree?
    unusual: Mapping[Explanation, float] = field(default_factory=dict)  # `Link.unusual`, summed
    beyond: Mapping[Explanation, int] = field(default_factory=dict)  # parameters over the usual

    @property
    def slow_gain(self) -> bool:
        """Whether a gain that changes slowly leaves far less than the drift in its place."""
        lefts = ((left.both, self.tried[effects].both) for effects, left in self.gains.items())
        return any(gain < FAR_LESS * drift for gain, drift in lefts)

    @classmethod
    def of(cls, pool: Pool, signatures: Sequence[Signature] = ()) -> Facts:
        """The facts in a pool and what fit-free tests say."""
        tried = {effects: one for effects, one in pool.tried.items() if _all_act(effects, one)}
        return cls(
            nominal=explained(frozenset(), pool.nominal, pool),
            refit=explained(frozenset(), pool.refit, pool),
            floor=pool.noise_floor,
            independent=independent_samples(pool.refit.errors),
            tried={effects: explained(effects, trial, pool) for effects, trial in tried.items()},
            gains=dict(_with_gains(tried, pool)),
            signs={signature.effect: signature.agrees for signature in signatures},
            unusual={effects: _unusual(effects, trial, pool) for effects, trial in tried.items()},
            beyond={effects: _beyond(effects, trial) for effects, trial in tried.items()},
        )


def _all_act(effects: Explanation, trial: Trial) -> bool:
    """Whether none of several effects was fitted away: the others were tried without it."""
    return len(effects) == 1 or effects <= {link.name for link in trial.model.links}


def _with_gains(
    tried: Mapping[Explanation, Trial], pool: Pool
) -> Iterator[tuple[Explanation, Left]]:
    """Of the best drift by itself and beside another effect, what a gain's course would leave."""
    floor = pool.noise_floor
    for size in (1, 2):
        drifts = [effects for effects in tried if DRIFT in effects and len(effects) == size]
        if not drifts:
            continue
        best = min(drifts, key=lambda effects: tried[effects].both)
        drift, gain = (removable(left, floor) for left in followed(pool.evidence, tried[best]))
        if gain < drift:
            left = explained(best, tried[best], pool)
            rests = (gain / drift * removable(error, floor) for error in left)
            yield best, Left(*(math.hypot(floor, rest) for rest in rests))


def _unusual(effects: Explanation, trial: Trial, pool: Pool) -> float:
    scales = pool.evidence.scales
    return math.fsum(registry()[name].unusual(trial.model.values(name), scales) for name in effects)


def _beyond(effects: Explanation, trial: Trial) -> int:
    """How many more parameters than usual were fitted and are not at zero, where most vanish."""
    at_work = [key for key in trial.free if key[0] in effects and trial.model.value(*key) != 0.0]
    return len(at_work) - USUAL * len(effects)


def _left(trial: Trial) -> Left:
    return Left(trial.rmse, trial.fitted_rmse)


def explained(effects: Explanation, trial: Trial, pool: Pool) -> Left:
    """What an explanation leaves.

    A grid explains readings that lie on it without predicting them better: under noise the rounded
    prediction is often worse. So it counts as taking away from what its other effects leave the
    variance of rounding, q^2 / 12 for even steps q, and that of a grid bowed as far as they are.
    One that the rig's model has does so beside whatever explains the rest.
    """
    rounding = frozenset(name for name in effects if is_read_off(name))
    if not (rounding or pool.evidence.rounded):
        return _left(trial)
    rest = _left(pool.tried.get(effects - rounding, pool.refit) if rounding else trial)
    return Left(*(unrounded(error, pool.grid) for error in rest))


def _unclosed(left: Left, gap: Left, floor: float) -> float:
    """What is left of the gap, from 0 to 1; of one that is not there nothing."""
    shares = (
        min(1.0, removable(error, floor) / whole) if whole > 0.0 else 0.0
        for error, whole in zip(left, gap, strict=True)
    )
    return Left(*shares).both


@dataclass(frozen=True)
class _Scale:
    """Facts and the weights that they are given."""

    facts: Facts
    weights: Weights

    @cached_property
    def gap(self) -> Left:
        """What of the refit's errors could be removed, m."""
        return Left(*(removable(error, self.facts.floor) for error in self.facts.refit))

    def evidence(self, left: Left) -> float:
        """For what leaves so much: both terms of E."""
        weights, count = self.weights, self.facts.independent
        mismatched = (weights.mismatch * np.array(self.gap)) ** 2 + TINY
        nearly_exact = np.full(2, (NEARLY - 1.0) * self.facts.floor**2 + TINY)
        counted = min(max(count, weights.least), weights.most) * self._gain(left, mismatched)
        return counted + weights.exact * self._gain(left, nearly_exact)

    def _gain(self, left: Left, slack: Array) -> float:
        floor = self.facts.floor
        before, rest = (np.square(np.maximum(one, floor)) for one in (self.facts.refit, left))
        shrunk = 0.5 * np.log((before + slack) / (rest + slack))
        return float(shrunk @ (1.0, self.weights.fitted))

    def odds(self, effects: Explanation, left: Left) -> float:
        """What is held against an explanation by effects that leaves so much."""
        facts, weights = self.facts, self.weights
        odds = weights.effect + (len(effects) - 1) * weights.further
        odds += weights.unusual * facts.unusual.get(effects, 0.0)
        odds += weights.parameter * facts.beyond.get(effects, 0)
        unclosed = _unclosed(left, self.gap, facts.floor)
        for name in sorted(effects):
            odds += unclosed * LEAVING.get(name, weights.leaving)
            if facts.signs.get(name) is not None:
                odds += -AGREES.get(name, 0.0) if facts.signs[name] else weights.contradicts
        return odds

    @property
    def outside(self) -> float:
        """Log-odds of a cause that is not in the library."""
        weights, floor = self.weights, self.facts.floor
        # A refit to what its parameters cannot do may foretell worse than the model as given.
        least = np.minimum(self.gap, [removable(error, floor) for error in self.facts.nominal])
        rest = Left(*np.hypot(floor, weights.unknown_rest * least))
        found = [self.evidence(rest) - weights.unknown]
        for effects, left in self.facts.gains.items():  # as likely as it, were it a drift
            odds = self.odds(effects, left) + weights.unknown - weights.effect
            found.append(self.evidence(left) - odds)
        return float(np.logaddexp.reduce(found))


def weigh(facts: Facts, weights: Weights = CALIBRATED) -> dict[Explanation, float]:
    """The probability of each explanation; they sum to one."""
    scale = _Scale(facts, weights)
    logs = {
        NOTHING: scale.evidence(facts.nominal) + weights.none,
        MISTUNED: 0.0,
        OUTSIDE: scale.outside,
    }
    for effects, left in facts.tried.items():
        logs[effects] = scale.evidence(left) - scale.odds(effects, left)
    largest = max(logs.values())
    parts = {explanation: float(np.exp(log - largest)) for explanation, log in logs.items()}
    total = math.fsum(parts.values())  # in whatever order they were tried
    return {explanation: part / total for explanation, part in parts.items()}
