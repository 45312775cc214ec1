"""What a diagnosis may fit and what it is judged on.

With held-out recordings the others are fitted on all of their samples. Without, every recording is
cut into ten blocks: the odd ones are fitted, the even ones judge, and the samples next to a judged
block are fitted by nobody, because a residual remembers its neighbours. Either way a judged
recording's own values are fitted on its odd blocks and errors are taken on its even ones, as
`microgripper simulate` does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.scales import measure
from microgripper_control.effects.base import Scales
from microgripper_control.identification.nuisance import (
    BLOCKS,
    Conditions,
    Mask,
    blocks,
    heldout_prediction,
)
from microgripper_control.plant.model import Model

GAP = 0.05  # of a block, on each side of a judged one


@dataclass(frozen=True)
class Evidence:
    """Recordings to fit, with the samples that count, and recordings to judge on."""

    fitted: tuple[Recording, ...]
    used: tuple[Mask, ...]
    judged: tuple[Recording, ...]
    conditions: Conditions
    separate: bool  # whether the judged recordings are others than the fitted ones
    scales: Scales

    @classmethod
    def gather(
        cls,
        recordings: Sequence[Recording],
        heldout: Sequence[Recording],
        conditions: Conditions,
        nominal: Model,
    ) -> Evidence:
        """The evidence in recordings of the rig that `nominal` is meant to describe.

        Raises MicrogripperError for a recording that never moves or has no displacement.
        """
        if not recordings:
            raise MicrogripperError("no recording given to diagnose")
        for recording in (*recordings, *heldout):
            if np.ptp(recording.measured) == 0.0 or np.ptp(recording.voltage) == 0.0:
                raise MicrogripperError(
                    f"{recording.name}: voltage or displacement never changes; record a run that "
                    "moves"
                )
        scales = measure(nominal, (*recordings, *heldout))
        if heldout:
            whole = tuple(np.ones(len(recording), bool) for recording in recordings)
            return cls(tuple(recordings), whole, tuple(heldout), conditions, True, scales)
        apart = tuple(_fitted_blocks(len(recording)) for recording in recordings)
        return cls(tuple(recordings), apart, tuple(recordings), conditions, False, scales)

    def predictions(self, model: Model) -> list[tuple[Array, Mask]]:
        """Of each judged recording: the prediction, m, and the samples that judge."""
        return [heldout_prediction(model, recording, self.conditions) for recording in self.judged]

    def errors(self, model: Model) -> list[Array]:
        """Measured minus predicted on the judging samples of each judged recording, m."""
        return [
            (recording.measured - prediction)[counted]
            for recording, (prediction, counted) in zip(
                self.judged, self.predictions(model), strict=True
            )
        ]


def _fitted_blocks(length: int) -> Mask:
    """The odd blocks without the samples next to a judged block."""
    fitted = blocks(length, odd=True)
    gap = int(GAP * length / BLOCKS)
    judged = np.flatnonzero(np.diff(fitted.astype(int)))  # the last sample before each border
    for border in judged:
        fitted[max(0, border + 1 - gap) : border + 1 + gap] = False
    return fitted


def rms(errors: Sequence[Array]) -> float:
    """Root mean square over all samples of several arrays."""
    together = np.concatenate(list(errors))
    return float(np.sqrt(np.mean(together**2)))
