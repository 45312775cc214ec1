"""Recordings cut where nobody knows what was applied: a hysteresis remembers it.

What is missing is filled in with the voltage held. That does no harm if the voltage could hardly
move the while; after a longer gap a recording begins anew, with a state of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from microgripper_control.core.recording import Recording
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
    found = {id(one): list(_pieces(one)) for one in (*recordings, *heldout)}
    lines = [
        f"{one.name}: nobody knows what was applied in its longest gaps: what lies between them is "
        "taken as recordings of their own"
        for one in (*recordings, *heldout)
        if found[id(one)][0] is not one
    ]
    if lines:
        conditions = replace(conditions, initial=Initial.FIRST_SAMPLE)
    fitted, judging = (
        [piece for one in some for piece in found[id(one)]] for some in (recordings, heldout)
    )
    return Pieces(fitted, judging, conditions, lines)


def _pieces(recording: Recording) -> Iterator[Recording]:
    """The parts between long gaps, or the recording itself if it has none."""
    gaps = list(_long_gaps(recording))
    if not gaps:
        yield recording
        return
    count = len(recording)
    starts = [0, *(gap.stop for gap in gaps)]
    stops = [*(gap.start for gap in gaps), count]
    long = [(a, b) for a, b in zip(starts, stops, strict=True) if b - a >= SHORTEST]
    for first, last in long or [(0, count)]:
        yield _part(recording, slice(first, last))


def _long_gaps(recording: Recording) -> Iterator[slice]:
    """Rows of samples that were filled in, in which the voltage may have gone far."""
    if recording.read is None:
        return
    filled = np.concatenate([[False], ~recording.read, [False]])
    known = recording.voltage[recording.read]
    usual = float(np.mean(np.abs(np.diff(known)))) if len(known) > 1 else 0.0
    for first, last in np.flatnonzero(np.diff(filled)).reshape(-1, 2):
        held = np.ptp(recording.voltage[first:last]) == 0.0  # else it is known, but not the reading
        if held and (last - first) * usual > WAY * np.ptp(known):
            yield slice(int(first), int(last))


def _part(recording: Recording, part: slice) -> Recording:
    begins = recording.start + part.start * recording.sample_period
    setpoint, read = recording.setpoint, recording.read
    return replace(
        recording,
        name=recording.name if part.start == 0 else f"{recording.name} from {begins:.4g} s",
        voltage=recording.voltage[part].copy(),
        displacement=recording.measured[part].copy(),
        setpoint=None if setpoint is None else setpoint[part].copy(),
        read=None if read is None else read[part],
        start=begins,
    )
