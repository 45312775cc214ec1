"""Whether the rig is late: what a delay or a lag leaves in the spectra of residual and motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from microgripper_control.diagnosis.data.residuals import Residual, gap_power
from microgripper_control.diagnosis.signs.spectra import same_clock, spectrum_of

VISIBLE = 10.0  # times the noise: the motion at a frequency that is looked at
FAR = 0.15  # rad at the fastest motion: from here on delay and lag differ


@dataclass(frozen=True)
class Lateness:
    """What the residual has in common with the speed of the predicted motion."""

    delay: float  # s, by which the measured motion is behind
    explained: float  # of the gap, by being late
    phase: float  # rad, at the fastest motion that is seen
    loss: float  # of amplitude there over that of a first-order lag as late; 0 for a delay
    highest: float  # Hz
    spread: float  # of the frequencies that make up the motion: highest over lowest


def lateness(residuals: Sequence[Residual], noise: float) -> Lateness | None:
    """How late the measured motion is; None where nothing fast enough moves. `noise` in m.

    A delay tau leaves -tau x' of a motion x, and at high frequencies an amplitude of one. A lag of
    first order loses (w tau)^2 / 2 of the amplitude, a mean over 2 tau a third of that.
    """
    group = max(same_clock(residuals), key=lambda one: sum(len(r.error) for r in one))
    spectrum = spectrum_of(group)
    total = gap_power(group, noise)
    if spectrum is None or total <= 0.0:
        return None
    omega = 2.0 * np.pi * spectrum.frequency
    floor = 2.0 * noise**2 * spectrum.period
    seen = (spectrum.motion > VISIBLE * floor) & (spectrum.frequency > spectrum.resolution)
    if np.count_nonzero(seen) < 4:
        return None
    w, motion, cross = omega[seen], spectrum.motion[seen], spectrum.cross[seen]
    speed = float(w**2 @ motion)
    match = -float(w @ cross.imag)
    delay = match / speed
    explained = match**2 / speed * spectrum.step / total
    # The part of the spectrum that carries most of the speed tells the loss of amplitude.
    weight = w**2 * motion
    top = w >= w[np.searchsorted(np.cumsum(weight), 0.5 * weight.sum())]
    shared = np.cumsum(w * motion)  # between place and speed
    ends = w[np.searchsorted(shared, np.array([0.1, 0.9]) * shared[-1])]
    transfer = 1.0 + np.sum(cross[top] * w[top] ** 2) / np.sum(motion[top] * w[top] ** 2)
    slow = ~top
    gain = 1.0 + np.sum(cross[slow].real) / np.sum(motion[slow]) if slow.any() else 1.0
    centre = float(np.sqrt(np.sum(w[top] ** 4 * motion[top]) / np.sum(w[top] ** 2 * motion[top])))
    phase = -float(np.angle(transfer))
    first_order = 0.5 * float(np.log1p(np.tan(min(abs(phase), 1.4)) ** 2))
    lost = -float(np.log(np.abs(transfer) / gain))
    loss = lost / first_order if abs(phase) > FAR else 0.0
    return Lateness(
        delay, min(1.0, explained), phase, loss, centre / (2.0 * np.pi), float(ends[1] / ends[0])
    )
