"""Signatures of what acts on the motion: lateness, thresholds, creep, loops and play.

Each test gives one or more `Signature`s from residuals and the standard deviation of the white
noise, m; see `signatures`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.quantities import percent, quantity, span
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.residuals import Residual, gap_power
from microgripper_control.diagnosis.findings import Signature
from microgripper_control.diagnosis.signs.holds import growth_in_holds
from microgripper_control.diagnosis.signs.lateness import lateness
from microgripper_control.diagnosis.signs.onset import NoOnset, Onset, find_onset
from microgripper_control.diagnosis.signs.reversals import after_turns, widths_by_rate
from microgripper_control.diagnosis.signs.where import AFTER, recent_rate
from microgripper_control.identification.nuisance import Mask

SURE = 4.0  # standard errors
BROAD = 8.0  # highest over lowest frequency: motion that tells a delay from a loop
MOSTLY = 0.5  # of the gap: where being late explains less, a refit hides how much amplitude is lost
REAL = 0.1  # of the noise's power: a gap that can be looked at


def lateness_of(residuals: Sequence[Residual], noise: float) -> list[Signature]:
    """The residual goes with the speed; a delay keeps the amplitude, a lag loses it."""
    names = ("transport_delay", "amplifier_lag", "sensor_lag")
    late = lateness(residuals, noise)
    if late is None or gap_power(residuals, noise) <= REAL * noise**2:
        return [Signature(name, None, "Nothing moves fast enough to tell.") for name in names]
    text = (
        f"The rig is {quantity(late.delay, 's')} behind the model, which explains "
        f"{percent(late.explained)} of the gap"
    )
    if late.delay < 0.0 or late.explained < 0.01:
        # At one frequency alone a refit hides a delay in the width of the loop.
        agrees = False if late.phase < 0.02 and late.spread > BROAD else None
        return [Signature(name, agrees, text + ".") for name in names]
    if late.explained < 0.2:
        return [Signature(name, None, text + ".") for name in names]
    if late.loss == 0.0:
        text += f"; at {quantity(late.highest, 'Hz')} and below delay and lag look the same."
        return [Signature(name, True, text) for name in names]
    text += (
        f"; at {quantity(late.highest, 'Hz')} it lags {late.phase:.2g} rad and loses "
        f"{late.loss:.2g} times the amplitude that a first-order lag would."
    )
    if late.explained < MOSTLY:
        return [Signature(name, True, text) for name in names]
    delay, lag = late.loss < 0.3, late.loss > 0.1
    verdicts = (delay or (False if late.loss > 0.6 else None), *[lag or None] * 2)
    return [Signature(name, ok, text) for name, ok in zip(names, verdicts, strict=True)]


def slew_limit(residuals: Sequence[Residual], noise: float) -> list[Signature]:
    """Error after fast changes of the voltage alone."""
    rate = np.concatenate([recent_rate(r.recording)[r.counted] for r in residuals])
    power = np.concatenate([r.error[r.counted] ** 2 - noise**2 for r in residuals])
    total = float(power.sum())
    if gap_power(residuals, noise) <= REAL * noise**2 or np.ptp(rate) == 0.0:
        return [Signature("slew_limit", None, "There is no gap to look at.")]
    edges = np.quantile(rate, [0.5, 0.9])
    slow = float(power[rate <= edges[0]].sum()) / total / float(np.mean(rate <= edges[0]))
    fast, middle = rate > edges[1], (rate > edges[0]) & (rate <= edges[1])
    share = float(power[fast].sum()) / total if fast.any() else 0.0
    proportional = _per_rate(power, rate, middle) / max(_per_rate(power, rate, fast), 1e-300)
    text = (
        f"After changes faster than {quantity(edges[1], 'V/s')} lies {percent(share)} of the gap; "
        f"the slower half of the samples has {slow:.2g} times the mean power."
    )
    agrees = None
    if share > 0.6 and slow < 0.3 and proportional < 0.2:  # a delay's error goes with the rate
        agrees = True
    elif slow > 1.2 and share < 0.1:
        agrees = False
    return [Signature("slew_limit", agrees, text)]


def _per_rate(power: Array, rate: Array, chosen: Mask) -> float:
    """Mean power over mean square rate of some samples: the same everywhere for a delay."""
    return float(np.sum(power[chosen]) / max(float(np.sum(rate[chosen] ** 2)), 1e-300))


def thresholds(residuals: Sequence[Residual], noise: float) -> list[Signature]:
    """A bend of the residual over the voltage (saturation) and over the displacement (contact)."""
    level = find_onset(residuals, lambda residual: residual.recording.voltage, noise)
    place = find_onset(residuals, lambda residual: residual.position, noise)
    return [
        _bend("saturation", level, "voltage", "Above", ("V", "V", 1.0)),
        _bend("contact", place, "displacement", "Beyond", ("m", "µm", 1e-6)),
    ]


def _bend(
    effect: str, onset: Onset | NoOnset, over: str, beyond: str, units: tuple[str, str, float]
) -> Signature:
    """A bend over an axis: `beyond` is what the range above it is called.

    `units` are the axis's own, that by which a slope is told, and the latter's size in the former.
    """
    if isinstance(onset, NoOnset):
        text = f"No threshold of the residual is seen over the {over}: {onset.value}."
        return Signature(effect, None, text)
    unit, per, size = units
    side = beyond if onset.low == onset.place else "Below"
    slope = f"{quantity(size * onset.slope, 'm')} per {per}"
    text = (
        f"{side} {quantity(onset.place, unit, 3)} the residual takes another slope, by {slope}, "
        f"which explains {percent(onset.explained)} of its changes."
    )
    return Signature(effect, True, text)


def creep(residuals: Sequence[Residual], noise: float) -> list[Signature]:
    """Growth with the logarithm of time while the voltage is held, in the direction of the step."""
    growth = growth_in_holds(residuals, AFTER)
    if growth is None:
        return [Signature("creep", None, "The voltage is never held long enough after a step.")]
    text = (
        f"In {growth.holds} holds the error changes by {percent(growth.per_decade)} of the step "
        f"per decade of time, {growth.certainty:.1f} standard errors, which explains "
        f"{percent(growth.explained)} of what changes there."
    )
    if growth.per_decade > 0.0 and growth.certainty > SURE and growth.explained > 0.2:
        return [Signature("creep", True, text)]
    against = growth.per_decade < 0.0 and growth.certainty > SURE and growth.explained > 0.2
    return [Signature("creep", False if against else None, text)]


def rate_dependent_hysteresis(residuals: Sequence[Residual], noise: float) -> list[Signature]:
    """A loop in the residual that is wider the faster the voltage changes."""
    name = "rate_dependent_hysteresis"
    loops = widths_by_rate(residuals)
    gap = gap_power(residuals, noise)
    if loops is None or gap <= REAL * noise**2:
        return [Signature(name, None, "The rates of the recordings differ too little to tell.")]
    change = abs(loops.growth) * loops.decades / np.sqrt(gap)
    text = (
        f"From {span(loops.rates[0], loops.rates[-1], 'V/s')} the residual's loop changes by "
        f"{quantity(loops.growth, 'm')} per decade of rate, {loops.certainty:.1f} standard errors."
    )
    agrees = None
    wider = bool(np.all(np.diff(loops.widths) > 0.0))
    late = lateness(residuals, noise)
    if wider and loops.certainty > SURE and change > 0.5 and (late is None or late.explained < 0.2):
        agrees = True
    elif loops.growth < 0.0 and loops.certainty > 2.0 * SURE and change > 0.5:
        agrees = False
    return [Signature(name, agrees, text)]


def play(residuals: Sequence[Residual], noise: float) -> list[Signature]:
    """An error that jumps after a turn and then stays, against the direction of motion."""
    names = ("backlash", "friction")
    course = after_turns(residuals)
    if course is None or gap_power(residuals, noise) <= REAL * noise**2:
        return [Signature(name, None, "The motion turns too seldom.") for name in names]
    text = (
        f"After {course.turns} turns the error in the direction of motion goes by "
        f"{quantity(course.jump, 'm')} and then changes by {percent(course.unsteady)} of that, "
        f"which explains {percent(course.explained)} of the residual."
    )
    agrees = None
    if course.jump < 0.0 and course.explained > 0.3 and course.unsteady < 0.35:
        agrees = True
    elif course.explained < 0.01 and course.turns > 40:
        agrees = False
    return [Signature(name, agrees, text) for name in names]
