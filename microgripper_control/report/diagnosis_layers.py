"""The models that a diagnosis compares, and where the gap lies, as the figures draw them."""

from __future__ import annotations

from dataclasses import dataclass

from microgripper_control.core.signals import Array
from microgripper_control.diagnosis.answers.places import AXES
from microgripper_control.diagnosis.findings import Diagnosis, Judged
from microgripper_control.report.figure_data import Figure
from microgripper_control.report.wording import listed, span

INK, BEFORE, AFTER, GIVEN, GREY = "#1b1f24", "#c04a00", "#0067a8", "#7d8894", "#5b6670"
MICRO, NANO = 1e6, 1e9  # displacements are drawn in µm, residuals in nm


@dataclass(frozen=True)
class Layer:
    """One of the models compared: `before` and `after` are those between which the gap closes."""

    field: str  # of Judged
    name: str
    colour: str
    hidden: bool = False  # until somebody asks for it

    def residual(self, judged: Judged) -> Array:
        """Measured minus predicted, m, shape (n,)."""
        predicted: Array = getattr(judged, self.field)
        return judged.recording.measured - predicted


def layers(diagnosis: Diagnosis) -> tuple[Layer, ...]:
    """The models to draw: the last but one is before, the last is after."""
    if not diagnosis.effects:
        return (
            Layer("nominal", "model as given", BEFORE),
            Layer("refit", "parameters refitted", AFTER),
        )
    added = listed(diagnosis.effects) if len(diagnosis.effects) <= 2 else "the effects"
    return (
        Layer("nominal", "model as given", GIVEN, hidden=True),
        Layer("refit", "parameters refitted", BEFORE),
        Layer("augmented", f"with {added}", AFTER),
    )


def gap_bands(diagnosis: Diagnosis, axis: str, recording: str = "") -> list[Figure]:
    """Where the gap lies on an axis, of a time in the `recording` of that name."""
    unit = AXES[axis].unit
    return [
        {
            "low": found.low,
            "high": found.high,
            "kind": "gap",
            "name": span(found.low, found.high, unit, 2),
        }
        for found in diagnosis.where
        if found.axis == axis and found.recording in ("", recording)
    ]
