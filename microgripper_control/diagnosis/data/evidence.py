"""What a diagnosis may fit and what it is judged on.

With held-out recordings the others are fitted on all of their samples. Without, every recording is
cut into ten blocks: the odd ones are fitted, the even ones judge, and the samples next to what
judges are fitted by nobody, because a residual remembers its neighbours. Either way a judged
recording's own values are fitted on its odd blocks and errors are taken on its even ones, as
`microgripper simulate` does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.data.grid import Grid
from microgripper_control.diagnosis.data.scales import measure
from microgripper_control.diagnosis.data.settling import settled
from microgripper_control.effects.base import Scales
from microgripper_control.identification.nuisance import (
    BLOCKS,
    Conditions,
    Heldout,
    Mask,
    all_in_time,
    blocks,
    heldout_prediction,
)
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Initial

AS_GIVEN = 0.1  # of a step: a grid closer to the one in the rig's model is that
SHORTEST = 100  # samples of a recording: of fewer no noise can be told
GAP = 0.05  # of a block, on each side of what judges
STRIPS = 4  # of a block that judges, every other of which may be fitted
MOST_COMPARED = 300_000  # samples: an explanation takes hundreds of comparisons
STRETCH, STRETCHES = 1000, 50  # samples in a row where not all are, and the least of such rows
GOLDEN = 0.6180339887498949
MOST_SIMULATED = 2_000_000  # samples
MOST_PIECES = 5  # of a recording that is too long to be simulated
LONG_PIECE, SHORTEST_PIECE = 5000, 1000  # samples
LEAD_IN = 0.2  # of a piece that does not begin with its recording


@dataclass(frozen=True)
class Evidence:
    """Recordings to fit, with the samples that count, and recordings to judge on."""

    nominal: Model  # of the rig, but for what rounds its readings
    fitted: tuple[Recording, ...]
    used: tuple[Mask, ...]
    judged: tuple[Recording, ...]
    compared: tuple[Mask, ...]  # of those the samples that may judge
    conditions: Conditions
    separate: bool  # whether the recordings that judge were given for that
    scales: Scales
    rounded: bool = False  # whether the rig's model knows of the grid that its readings lie on

    @classmethod
    def gather(
        cls,
        recordings: Sequence[Recording],
        heldout: Sequence[Recording],
        conditions: Conditions,
        nominal: Model,
    ) -> Evidence:
        """The evidence in recordings of the rig that `nominal` is meant to describe.

        Raises MicrogripperError for a recording that never moves, is too short, or has no
        displacement.
        """
        if not recordings:
            raise MicrogripperError("no recording given to diagnose")
        for recording in (*recordings, *heldout):
            if np.ptp(recording.measured) == 0.0 or np.ptp(recording.voltage) == 0.0:
                raise MicrogripperError(
                    f"{recording.name}: voltage or displacement never changes; record a run that "
                    "moves"
                )
            if len(recording) < SHORTEST:
                raise MicrogripperError(
                    f"{recording.name}: {len(recording)} samples; a diagnosis needs {SHORTEST}"
                )
        scales = measure(nominal, (*recordings, *heldout))
        used = _used(recordings, bool(heldout))
        fitted = all_in_time(nominal, recordings, conditions)
        judged = all_in_time(nominal, heldout, conditions) or fitted
        return cls(
            nominal.without(nominal.rounding),
            fitted,
            used,
            judged,
            _all(judged),
            conditions,
            bool(heldout),
            scales,
            _known(nominal, scales.resolution),
        )

    def joined(self) -> Evidence:
        """The same with some of what judges fitted as well.

        Of judged recordings these are the odd blocks, while the even ones judge; of blocks that
        judge it is every other strip.
        """
        if not self.separate:
            shared = [_odd_or_striped(len(recording)) for recording in self.fitted]
            return replace(
                self,
                used=tuple(_away_from_borders(mask) for mask in shared),
                compared=tuple(~mask for mask in shared),
            )
        return replace(
            self,
            fitted=(*self.fitted, *self.judged),
            used=(*self.used, *_used(self.judged, False)),
        )

    def clocked(self, clock: float, ages: Sequence[float]) -> Evidence:
        """The same with the sensor's clock, s, and the ages of the fitted first readings, s."""
        fitted = [
            replace(recording, reading_age=age)
            for recording, age in zip(self.fitted, ages, strict=True)
        ]
        new = {id(old): timed for old, timed in zip(self.fitted, fitted, strict=True)}
        judged = tuple(new.get(id(recording), recording) for recording in self.judged)
        scales = replace(self.scales, clock=clock)
        return replace(self, fitted=tuple(fitted), judged=judged, scales=scales)

    @property
    def grid(self) -> Grid:
        """The grid that all readings lie on."""
        return Grid(self.scales.resolution, self.scales.rounding)

    @property
    def apart(self) -> bool:
        """Whether no recording that judges is fitted as well."""
        return not any(judge is one for judge in self.judged for one in self.fitted)

    def lean(self, most: int = MOST_COMPARED) -> Evidence:
        """The same with about `most` samples that are fitted and as many that judge.

        They are stretches all over the recordings, which are simulated as a whole: what takes long
        to show, such as creep, is not cut short.
        """
        evidence = self.pieces(MOST_SIMULATED)
        used = _sparse(evidence.used, most)
        compared = _sparse(evidence.compared, most)
        if used is self.used and compared is self.compared:
            return self
        return replace(evidence, used=used, compared=compared)

    def pieces(self, most: int) -> Evidence:
        """The same with about `most` samples to fit and as many that judge.

        There are more where many recordings each keep few. Of longer ones pieces are kept, each as
        a recording of its own that begins as the rig happened to be: neither from rest nor where a
        period ends.
        """
        conditions = replace(self.conditions, initial=Initial.FIRST_SAMPLE)
        cut = partial(_pieces_of, most=most, conditions=conditions, anywhere=self.separate)
        fitted, used = cut(self.fitted, self.used)
        judged, compared = fitted, _all(fitted)
        if self.separate:
            judged, compared = cut(self.judged, self.compared)
        uncut = fitted is self.fitted and (judged is self.judged or not self.separate)
        if uncut or not (fitted and judged):
            return self
        return replace(
            self,
            fitted=fitted,
            used=used,
            judged=judged,
            compared=compared,
            conditions=conditions,
        )

    def settled(self) -> Evidence:
        """The same without what a hysteresis still owes to the time before each recording."""
        if self.nominal.value("bouc_wen", "alpha") == 0.0:
            return self
        masks = [
            mask & settled(recording)
            for mask, recording in zip(self.used, self.fitted, strict=True)
        ]
        if all(np.array_equal(mask, old) for mask, old in zip(masks, self.used, strict=True)):
            return self
        return replace(self, used=tuple(masks))

    def predictions(self, model: Model) -> list[Heldout]:
        """What a model says of each judged recording; the samples that judge count."""
        found = [heldout_prediction(model, recording, self.conditions) for recording in self.judged]
        return [
            one._replace(counted=one.counted & compared)
            for one, compared in zip(found, self.compared, strict=True)
        ]

    def errors(self, model: Model) -> list[Array]:
        """Measured minus predicted on the judging samples of each judged recording, m."""
        return [
            (recording.measured - said.prediction)[said.counted]
            for recording, said in zip(self.judged, self.predictions(model), strict=True)
        ]


def _known(nominal: Model, step: float) -> bool:
    """Whether a model rounds its readings by the step, m, that these have."""
    steps = [value for name in nominal.rounding for value in nominal.values(name).values()]
    return any(math.isclose(one, step, rel_tol=AS_GIVEN) for one in steps)


def _all(recordings: Sequence[Recording]) -> tuple[Mask, ...]:
    return tuple(np.ones(len(recording), bool) for recording in recordings)


def _sparse(masks: tuple[Mask, ...], most: int) -> tuple[Mask, ...]:
    """Of more than `most` samples in some masks stretches all over, in step with no cycle."""
    total = sum(int(np.count_nonzero(mask)) for mask in masks)
    if total <= most:
        return masks
    share = most / total
    return tuple(mask & _stretches(len(mask), share) for mask in masks)


def _stretches(length: int, share: float) -> Mask:
    """Samples in stretches that together are a share of all."""
    count = max(STRETCHES, round(share * length / STRETCH))
    index = np.arange(count)
    starts = (index + (1.0 - share) * (GOLDEN * index % 1.0)) * length / count
    place = np.arange(length)
    since = place - starts[place * count // length]
    chosen: Mask = (since >= 0.0) & (since < share * length / count)
    return chosen


def _used(recordings: Sequence[Recording], separate: bool) -> tuple[Mask, ...]:
    """Of each recording the samples that are fitted."""
    if separate:
        return _all(recordings)
    return tuple(_away_from_borders(blocks(len(recording), odd=True)) for recording in recordings)


def _odd_or_striped(length: int) -> Mask:
    """The odd blocks, and every other strip of the even ones, the last among them."""
    strip = np.arange(length) * BLOCKS * STRIPS // length
    chosen: Mask = (strip // STRIPS % 2 == 0) | (strip % 2 == 1)
    return chosen


def _away_from_borders(chosen: Mask) -> Mask:
    """Samples to fit without those next to what judges."""
    fitted: Mask = chosen.copy()
    gap = int(GAP * len(chosen) / BLOCKS)
    for border in np.flatnonzero(np.diff(chosen.astype(int))):  # the last sample before each
        fitted[max(0, border + 1 - gap) : border + 1 + gap] = False
    return fitted


def _pieces_of(
    recordings: tuple[Recording, ...],
    masks: tuple[Mask, ...],
    most: int,
    conditions: Conditions,
    anywhere: bool,
) -> tuple[tuple[Recording, ...], tuple[Mask, ...]]:
    """Recordings and masks as they are if there are no more than `most` samples, else pieces.

    A piece's first samples do not count: they only show what a force remembers when it begins.
    Unless pieces may lie `anywhere`, its own even blocks judge. One with nothing left is no piece.
    """
    total = sum(len(recording) for recording in recordings)
    if total <= most:
        return recordings, masks
    pieces, counted = [], []
    for recording, mask in zip(recordings, masks, strict=True):
        begin = int(np.argmax(mask)) if anywhere else 0
        for part in _parts(begin, len(recording), len(recording) * most / total, anywhere):
            piece = recording.stretch(part)
            lead = int(LEAD_IN * len(piece)) if anywhere and part.start > 0 else 0
            counts = mask[part] & (np.arange(len(piece)) >= lead)
            if not anywhere:
                counts &= _used([piece], False)[0]
            if np.any(counts & conditions.answered(piece)):
                pieces.append(piece)
                counted.append(counts)
    return tuple(pieces), tuple(counted)


def _parts(begin: int, end: int, quota: float, anywhere: bool) -> Iterator[slice]:
    """Stretches between two samples of a recording that together have about `quota` samples.

    `anywhere` few and long ones, evenly spread; else the beginnings of the odd blocks.
    """
    quota = max(SHORTEST_PIECE, round(quota))
    if anywhere:
        count = min(MOST_PIECES, max(1, quota // LONG_PIECE))
        each = (end - begin) // count
        span = min(quota // count, each)
        firsts = [begin + index * each for index in range(count)]
    else:
        block = (end - begin) // BLOCKS
        span = min(block, max(SHORTEST_PIECE, quota // (BLOCKS // 2)))
        firsts = list(range(begin, begin + BLOCKS * block, 2 * block))
    for first in firsts:
        yield slice(first, min(first + span, end))


def rms(errors: Sequence[Array]) -> float:
    """Root mean square over all samples of several arrays."""
    together = np.concatenate(list(errors))
    return float(np.sqrt(np.mean(together**2)))
