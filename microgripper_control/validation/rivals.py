"""Whether another effect could pass for the true one on the recordings of a case.

Where the best law of another effect leaves no more than the true one does, no diagnosis can tell
the two apart, and naming both as ambiguous is the right answer. The refits run on a coarser
internal grid; what that costs, the excess of the true effect itself tells.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from microgripper_control.validation.case import Case
from microgripper_control.validation.effects.form import Form
from microgripper_control.validation.effects.registry import known_effects
from microgripper_control.validation.machine import Applied, steps_a_sample
from microgripper_control.validation.oracle import Explained, explain
from microgripper_control.validation.sizing import SEARCH_RATE

STARTS = (0.3, 3.0)  # strengths to begin with, over the one that a search begins with
FIRST_ITERATIONS = 2  # from each start; the best one goes on
MORE_ITERATIONS = 12
ENOUGH = 1e-3  # fall of the sum of squares, which moves an excess by 0.03 at most


@dataclass(frozen=True)
class Rival:
    """The best that an effect's laws can do in place of the true one.

    `excess` is what it leaves beyond the true law on the held-out recordings, over the noise:
    sqrt(error^2 - oracle^2) / noise, zero where it does as well.
    """

    effect: str
    form: str
    explained: Explained
    excess: float


def rival(case: Case, effect: str) -> Rival | None:
    """Refit an effect's laws, both forms, in place of the case's own causes.

    None for an effect that chance governs (a drift, a hum, a quantiser), whose law fits nothing but
    its own data.
    """
    tried = [
        _refitted(case, effect, form) for form in known_effects()[effect].forms if form.repeatable
    ]
    return min(tried, key=lambda one: one.excess) if tried else None


def without(case: Case, effect: str) -> Explained:
    """Refit the rig's own law without one of its causes: what the others leave to it."""
    return explain(
        case.recordings,
        case.actuator.scale,
        case.noise,
        [applied for applied in case.rig.effects if applied.effect != effect],
        case.rig.base,
        _steps(case),
        MORE_ITERATIONS,
        ENOUGH,
    )


def _steps(case: Case) -> int:
    return steps_a_sample(case.recordings[0].drive.sample_period, SEARCH_RATE)


def _refitted(case: Case, effect: str, form: Form) -> Rival:
    scale = case.actuator.scale
    steps = _steps(case)
    middle = {p.name: p.nominal for p in form.shape}
    begun = []
    for factor in STARTS:
        applied = Applied(effect, form, factor * form.strength.nominal, middle)
        begun.append(
            explain(
                case.recordings,
                scale,
                case.noise,
                [applied],
                case.rig.base,
                steps,
                FIRST_ITERATIONS,
            )
        )
    best = min(begun, key=lambda one: one.errors["training"])
    best = explain(
        case.recordings,
        scale,
        case.noise,
        best.rig.effects,
        best.rig.base,
        steps,
        MORE_ITERATIONS,
        ENOUGH,
    )
    beyond = best.errors["heldout"] ** 2 - case.truth.errors_m["oracle"]["heldout"] ** 2
    return Rival(effect, form.name, best, math.sqrt(max(beyond, 0.0)) / case.noise)
