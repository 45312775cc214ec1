"""Recordings cut where nobody knows what was applied: a hysteresis remembers it.

What is missing is filled in with the voltage held. That does no harm if the voltage could hardly
move the while; after a longer gap a recording begins anew, with a state of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

import numpy as np

from microgripper_control.core.recording import Recording
from microgripper_control.core.runs import runs
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.simulate import Initial

WAY = 0.3  # of the voltage's span: how far it may have gone in a gap, at its usual speed
SHORTEST = 200  # samples of a piece that is kept


class Pieces(NamedTuple):
    """Recordings without long gaps, how they begin, and a line for each that was cut."""

    recordings: list[Recording]
    heldout: list[Recording]
    conditions: Conditions
    lines: list[str]


def cut_at_gaps(
    recordings: Sequence[Recording], heldout: Sequence[Recording], conditions: Conditions
) -> Pieces:
    """Cut recordings in their long gaps; what comes after one begins in no known state."""
    fitted, judging = ([_pieces(one) for one in some] for some in (recordings, heldout))
    cut = [
        whole.name
        for whole, pieces in zip((*recordings, *heldout), (*fitted, *judging), strict=True)
        if pieces[0] is not whole
    ]
    lines = [
        f"{name}: nobody knows what was applied in its longest gaps: what lies between them is "
        "taken as recordings of their own"
        for name in cut
    ]
    if cut:
        conditions = replace(conditions, initial=Initial.FIRST_SAMPLE)
    return Pieces([*chain(*fitted)], [*chain(*judging)], conditions, lines)


def _pieces(recording: Recording) -> list[Recording]:
    """The parts between long gaps, of those that move; itself if it has no gap, or has no part."""
    gaps = _long_gaps(recording)
    starts = [0, *(gap.stop for gap in gaps)]
    stops = [*(gap.start for gap in gaps), len(recording)]
    between = [slice(a, b) for a, b in zip(starts, stops, strict=True) if b - a >= SHORTEST]
    parts = [part for part in between if _moves(recording, part)]
    if not gaps or not parts:
        return [recording]
    return [_piece(recording, part) for part in parts]


def _piece(recording: Recording, part: slice) -> Recording:
    """One of the parts: what lies in it is timed from where it begins, which its name says."""
    piece = recording.stretch(part)
    if part.start == 0:
        return piece
    begins = part.start * recording.sample_period
    return replace(piece, name=f"{piece.name} from {begins:.4g} s", skipped=0.0)


def _moves(recording: Recording, part: slice) -> bool:
    """Whether a part tells anything: one that rests does not."""
    return all(np.ptp(signal[part]) > 0.0 for signal in (recording.voltage, recording.measured))


def _long_gaps(recording: Recording) -> list[slice]:
    """Rows of samples that were filled in, in which the voltage may have gone far."""
    known = recording.voltage[recording.present]
    usual = float(np.mean(np.abs(np.diff(known)))) if len(known) > 1 else 0.0
    longest = WAY * float(np.ptp(known)) if len(known) else 0.0
    return [gap for gap in runs(~recording.present) if (gap.stop - gap.start) * usual > longest]
