"""Less to look at where each sample is dear.

A force in the mechanics that remembers the way is balanced several times a sample. It knows the way
and not the time, so stretches of the recordings show enough of it to fit it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from microgripper_control.diagnosis.evidence import Evidence
from microgripper_control.diagnosis.trial import Base, Trial, base_of, moved, refine, unfitted
from microgripper_control.effects.registry import registry

PART, LARGER_PART = 15_000, 30_000  # samples on which an effect is tried, and fitted on


def on_a_part(
    evidence: Evidence, bases: Sequence[Base], name: str, most: int = PART
) -> tuple[Evidence, Sequence[Base]]:
    """What to try an effect on and the bases there: with a dear force, about `most` samples."""
    part = evidence.pieces(most) if any_dear((name, *bases[0].trial.effects)) else evidence
    if part is evidence:
        return evidence, bases
    return part, [base_of(part, moved(part, base.trial)) for base in bases]


def refined(evidence: Evidence, trial: Trial, tolerance: float, evaluations: int) -> Trial:
    """Fit on with all derivatives fresh, a dear force on a part, and judge what comes out."""
    part = evidence.pieces(LARGER_PART) if any_dear(trial.effects) else evidence
    if part is evidence:
        return refine(evidence, trial, tolerance, evaluations)
    found = refine(part, moved(part, trial), tolerance, evaluations)
    return unfitted(evidence, moved(evidence, found))


def any_dear(effects: Iterable[str]) -> bool:
    """Whether a force that remembers the way is among some effects."""
    forces = [registry()[name].force for name in effects]
    return any(force is not None and force.states > 0 for force in forces)
