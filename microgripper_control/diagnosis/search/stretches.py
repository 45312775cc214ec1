"""Less to look at where each sample is costly.

A force is balanced within each sample, many times where the mass rings or the way counts. It knows
place and way and not the time, so stretches of the recordings show enough of it to begin with.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from microgripper_control.diagnosis.data.evidence import Evidence, rms
from microgripper_control.diagnosis.data.noise import innovation, removable
from microgripper_control.diagnosis.fits.fitting import Base, base_of
from microgripper_control.diagnosis.fits.trial import Trial, moved
from microgripper_control.diagnosis.search.labour import is_force, is_laborious_with
from microgripper_control.effects.registry import registry

PART = 15_000  # samples that are fitted then
WORTHWHILE = 2.0  # times that many, at least, or all are fitted
HIDDEN = 0.3  # of the gap: a part that shows less of it is no part to look at
GLANCE = 6000  # samples on which it is seen what a force promises
MANY = 40_000  # samples
IF_CHEAP = 50_000  # that are fitted with a force that is balanced once a sample


def on_a_part(
    evidence: Evidence, bases: Sequence[Base], name: str, most: float
) -> tuple[Evidence, Sequence[Base]]:
    """What to try an effect on and the bases there: `_enough` samples, about.

    Less than twice as many are left whole: a stretch forgets what was before it, and its fit may
    lead astray. So are all where the stretches, each with a zero and a beginning of its own, show
    too little of the gap.
    """
    most = _enough(evidence, bases[0].trial, name, most)
    worthwhile = sum(len(recording) for recording in evidence.fitted) > WORTHWHILE * most
    part = evidence.pieces(int(most)) if worthwhile else evidence
    if part is evidence:
        return evidence, bases
    anchors = [base_of(part, moved(part, base.trial)) for base in bases]
    return (evidence, bases) if _hides(anchors[0], bases[0]) else (part, anchors)


def _enough(evidence: Evidence, trial: Trial, name: str, most: float) -> float:
    """How many samples show enough of an effect: `most` if it is a costly force.

    For a glance that goes for any force, and for a play.
    """
    if is_laborious_with(evidence, trial, name) or (most <= GLANCE and _is_shown(name)):
        return most
    return IF_CHEAP if is_force(name) else math.inf


def _hides(part: Base, whole: Base) -> bool:
    """Whether a part of the samples shows little of what all show."""
    floor = innovation([whole.residual])
    seen, there = (removable(rms([base.residual]), floor) for base in (part, whole))
    return seen < HIDDEN * there


def _is_shown(effect: str) -> bool:
    """Whether stretches show an effect."""
    return is_force(effect) or registry()[effect].of_the_way
