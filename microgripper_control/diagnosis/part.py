"""Less to look at where each sample is dear.

A force that remembers the way is balanced several times a sample. It knows the way and not the
time, so stretches of the recordings show enough of it to begin with.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from microgripper_control.diagnosis.evidence import Evidence
from microgripper_control.diagnosis.trial import Base, Trial, base_of, moved, refine
from microgripper_control.effects.registry import registry

PART = 15_000  # samples that are fitted then
MANY = 40_000  # samples
TO_THE_END, MOST = 1e-5, 60  # tolerance and evaluations of a fit to fewer
ENOUGH, FEWER = 1e-3, 8  # tolerance and evaluations of a fit to all of them,
ROUNDS, WORTH_ANOTHER = 3, 0.9  # which goes on as long as it takes away a tenth each time


def on_a_part(
    evidence: Evidence, bases: Sequence[Base], name: str, most: int
) -> tuple[Evidence, Sequence[Base]]:
    """What to try an effect on and the bases there: with a dear force, about `most` samples."""
    dear = any_dear((name, *bases[0].trial.effects))
    part = evidence.pieces(most) if dear else evidence
    if part is evidence:
        return evidence, bases
    return part, [base_of(part, moved(part, base.trial)) for base in bases]


def refined(evidence: Evidence, trial: Trial, tolerance: float, evaluations: int) -> Trial:
    """Fit on and judge what comes out; of many dear samples with fewer derivatives.

    Of few a dear force is fitted to the end: it bends while it is fitted, and gets there late.
    """
    if not any_dear(trial.effects):
        return refine(evidence, trial, tolerance, evaluations)
    if sum(len(recording) for recording in evidence.fitted) <= MANY:
        return refine(evidence, trial, TO_THE_END, MOST)
    for _ in range(ROUNDS):
        before = trial.fitted_rmse
        trial = refine(evidence, trial, ENOUGH, FEWER, fresh=trial.effects)
        if trial.fitted_rmse > WORTH_ANOTHER * before:
            break
    return trial


def any_dear(effects: Iterable[str]) -> bool:
    """Whether a force that remembers the way is among some effects."""
    forces = [registry()[name].force for name in effects]
    return any(force is not None and force.states > 0 for force in forces)
