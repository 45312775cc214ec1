"""The sealed answer of a case, as plain numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from microgripper_control.validation.effects.form import Place, Reach
from microgripper_control.validation.effects.registry import known_effects
from microgripper_control.validation.laboratory import Laboratory
from microgripper_control.validation.law import Taken
from microgripper_control.validation.machine import Applied
from microgripper_control.validation.strengths import Found

SEEN = 1.2  # ratio below which an effect cannot be asked for


@dataclass(frozen=True)
class Cause:
    """One effect at work: its numbers, and the ratio that it gives by itself."""

    effect: str
    form: str
    stage: str
    in_library: bool
    strength: float
    unit: str
    shape: dict[str, float]
    ratio: float
    reached: bool  # the ratio that was asked for, on these recordings
    seen: bool
    where: tuple[Place, ...]


@dataclass(frozen=True)
class Truth:
    """What is true of a case.

    `verdict` is the right one with the whole library: "parameters" also where no effect can be
    seen, "unknown" where a cause that no library has can be. An effect that cannot be seen cannot
    be asked for, and is no false alarm if it is named. `ratio` is the oracle's residual without the
    effects over the noise, on all recordings. Displacements in `where` are as the sensor shows
    them. `noise_m` is the white noise of the sensor, before any converter.

    `errors_m` holds rms errors on "training", "heldout" and "all": of the "nominal" model, after
    the "refit" of its parameters, and of the "oracle", the rig's own law with the effects, which is
    the least that anyone can leave. That is the noise, but for a converter: rounding by a `step`
    turns white noise into another, of which even one who knows every number and all that moved
    before the converter is left with about sqrt(noise^2 + step^2 / 12) for a step below three times
    the noise and sqrt(noise step / sqrt(pi)) for a wide one. What can be closed lies between
    "refit" and "oracle"; a fine step shows in the grid of its readings alone.
    """

    question: str
    effects: tuple[str, ...]
    form: str
    strength: str
    excitation: str
    seed: int
    verdict: str
    causes: tuple[Cause, ...]
    ratio: float
    noise_m: float
    errors_m: dict[str, dict[str, float]]
    base: dict[str, float]
    mistuning: dict[str, float]
    zeros_m: dict[str, float]
    kinds: dict[str, str]
    hold: str
    sample_rate_hz: float

    def plain(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def causes_of(
    found: Sequence[tuple[Applied, Found]], laboratory: Laboratory, recordings: Sequence[Taken]
) -> tuple[Cause, ...]:
    """The entry of each effect."""
    reach = _reach(laboratory, recordings)
    zero = float(np.mean(laboratory.zeros))
    causes = []
    for applied, size in found:
        effect = known_effects()[applied.effect]
        places = applied.form.where(applied.strength, applied.shape, reach)
        causes.append(
            Cause(
                effect=applied.effect,
                form=applied.form.name,
                stage=effect.stage,
                in_library=effect.in_library,
                strength=applied.strength,
                unit=applied.form.strength.unit,
                shape=dict(applied.shape),
                ratio=size.ratio,
                reached=size.reached,
                seen=size.ratio >= SEEN,
                where=tuple(_shown(place, zero) for place in places),
            )
        )
    return tuple(causes)


def verdict_of(mistuned: bool, causes: Sequence[Cause]) -> str:
    """The right verdict with the whole library."""
    seen = [cause for cause in causes if cause.seen]
    if seen:
        return "effects" if all(cause.in_library for cause in seen) else "unknown"
    return "parameters" if mistuned else "none"


def _shown(place: Place, zero: float) -> Place:
    """A place as the sensor shows it, whose reading at x = 0 is `zero` (m)."""
    if place.axis != "displacement_m":
        return place
    return Place(place.axis, place.low + zero, place.high + zero)


def _reach(laboratory: Laboratory, recordings: Sequence[Taken]) -> Reach:
    voltages = [taken.drive.recorded for taken in recordings]
    positions = [
        taken.measured - zero for taken, zero in zip(recordings, laboratory.zeros, strict=True)
    ]
    rates = [np.abs(np.diff(u)).max() / laboratory.sample_period for u in voltages]
    return Reach(
        sample_period=laboratory.sample_period,
        voltage=(float(min(u.min() for u in voltages)), float(max(u.max() for u in voltages))),
        displacement=(
            float(min(x.min() for x in positions)),
            float(max(x.max() for x in positions)),
        ),
        rate=float(max(rates)),
        hold=max(plan.wave.hold for plan in laboratory.plans),
        duration=max(taken.drive.duration for taken in recordings),
        scale=laboratory.actuator.scale,
    )
