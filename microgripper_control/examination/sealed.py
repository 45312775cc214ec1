"""The truth of a case, as scoring reads it out of its seal."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from microgripper_control.validation.strengths import RATIOS


@dataclass(frozen=True)
class Span:
    """A range on one of the axes of `where`."""

    axis: str
    low: float
    high: float


@dataclass(frozen=True)
class Cause:
    """One effect at work."""

    effect: str
    stage: str
    ratio: float
    seen: bool
    where: tuple[Span, ...]


@dataclass(frozen=True)
class Sealed:
    """What scoring needs of the truth; errors are rms on the held-out recordings, m."""

    question: str
    effects: tuple[str, ...]
    form: str
    excitation: str
    verdict: str
    causes: tuple[Cause, ...]
    ratio: float
    noise: float
    nominal: float
    refit: float
    oracle: float

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> Sealed:
        """From the sealed file's content."""
        causes = tuple(
            Cause(
                cause["effect"],
                cause["stage"],
                cause["ratio"],
                cause["seen"],
                tuple(Span(p["axis"], p["low"], p["high"]) for p in cause["where"]),
            )
            for cause in plain["causes"]
        )
        errors = plain["errors_m"]
        return cls(
            question=plain["question"],
            effects=tuple(plain["effects"]),
            form=plain["form"],
            excitation=plain["excitation"],
            verdict=plain["verdict"],
            causes=causes,
            ratio=plain["ratio"],
            noise=plain["noise_m"],
            nominal=errors["nominal"]["heldout"],
            refit=errors["refit"]["heldout"],
            oracle=errors["oracle"]["heldout"],
        )

    @property
    def seen(self) -> tuple[Cause, ...]:
        """The causes that can be asked for, the strongest first."""
        return tuple(sorted((c for c in self.causes if c.seen), key=lambda cause: -cause.ratio))

    @property
    def strength(self) -> str:
        """The name of the strength that is nearest to what the effects do on these recordings.

        Where a recording cannot show as much as was asked for, it is less than that.
        """
        return min(RATIOS, key=lambda name: abs(math.log(RATIOS[name] / max(self.ratio, 1e-9))))

    def removable(self, error: float) -> float:
        """What of a held-out error, m, the rig's own law could take away."""
        return math.sqrt(max(error**2 - self.oracle**2, 0.0))

    @property
    def gap(self) -> float:
        """The removable part of what a refit leaves, over the noise."""
        return self.removable(self.refit) / self.noise
