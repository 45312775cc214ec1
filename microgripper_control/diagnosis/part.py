"""Less to look at where each sample is dear.

A force in the mechanics under a zero-order hold is balanced several times a sample. Such a force
knows the way and not the time, so stretches of the recordings show enough of it to begin with.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from microgripper_control.diagnosis.evidence import Evidence
from microgripper_control.diagnosis.trial import Base, base_of, moved
from microgripper_control.effects.registry import registry
from microgripper_control.plant.simulate import Hold

PART = 30_000  # samples that are fitted then


def on_a_part(
    evidence: Evidence, bases: Sequence[Base], name: str, most: int = PART
) -> tuple[Evidence, Sequence[Base]]:
    """What to try an effect on and the bases there: with a dear force, about `most` samples."""
    held = evidence.conditions.hold is Hold.ZERO
    if not held or not any_dear((name, *bases[0].trial.effects)):
        return evidence, bases
    part = evidence.pieces(most)
    if part is evidence:
        return evidence, bases
    return part, [base_of(part, moved(part, base.trial)) for base in bases]


def any_dear(effects: Iterable[str]) -> bool:
    """Whether a force that remembers the way is among some effects."""
    forces = [registry()[name].force for name in effects]
    return any(force is not None and force.states > 0 for force in forces)
