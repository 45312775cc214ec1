"""What the demo prints and puts on its page: tables, and sentences about them."""

from __future__ import annotations

from collections.abc import Sequence

from microgripper_control.core.quantities import quantity
from microgripper_control.core.recording import Recording
from microgripper_control.demo.fault import Fault
from microgripper_control.demo.plan import (
    MISTUNED,
    MODES,
    SEGMENTS,
    WARM_UP,
    controllers_model,
    true_model,
)
from microgripper_control.demo.tracking import MOST_MISSED, Tracking
from microgripper_control.diagnosis.findings import Diagnosis
from microgripper_control.effects.mechanics.second_order import static_gain
from microgripper_control.effects.registry import registry
from microgripper_control.identification.fit import Fit
from microgripper_control.plant.model import Model, Setting
from microgripper_control.report.demo_page import Shown

PAPERS_ERROR = 0.05  # "less than 5 %"
DIGITS = 4  # of a fault's value as it was found


def tracking_table(parts: Sequence[Tracking]) -> Shown:
    """How well each mode followed each segment."""
    segments = [name for name in SEGMENTS if name != WARM_UP]
    cells = {(part.segment, part.mode): _cell(part) for part in parts}
    rows = [
        [segment, *(cells.get((segment, mode), "not recorded") for mode in MODES)]
        for segment in segments
    ]
    title = (
        "Tracking error, rms in % of the setpoint's peak to peak "
        f"(the paper: less than {100.0 * PAPERS_ERROR:g} %)"
    )
    return Shown(title, ("segment", *MODES), rows)


def _cell(part: Tracking) -> str:
    if part.rms is None:
        return f"missed {100.0 * part.missed:.0f} %"
    return f"{100.0 * part.rms:.3f}"


def identification_table(found: Fit) -> Shown:
    """What was identified, beside what the rig has."""
    truth, start = true_model(), controllers_model()
    rows = [_parameter_row("d k/(k + k_s), m/V", _gain(truth), _gain(start), found.gain)]
    for name in ("alpha", "beta", "gamma"):
        settings = found.model.settings["bouc_wen"][name]
        values = truth.value("bouc_wen", name), start.value("bouc_wen", name)
        rows.append(_parameter_row(name, *values, settings))
    header = ("parameter", "before", "identified, 95 %", "true", "off by")
    return Shown("Identified from the bag", header, rows)


def _parameter_row(title: str, true: float, before: float, found: Setting) -> list[str]:
    low, high = found.interval or (float("nan"), float("nan"))
    identified = f"{found.value:.5g} ± {0.5 * (high - low):.1g}"
    off = f"{100.0 * (found.value / true - 1.0):+.3f} %"
    return [title, f"{before:.4g}", identified, f"{true:.5g}", off]


def _gain(model: Model) -> float:
    return model.value("bouc_wen", "d") * static_gain(model.values("second_order"))


def sentences(recording: Recording, found: Fit, parts: Sequence[Tracking]) -> list[str]:
    """What was recorded and what the identified model leaves of it."""
    lost = " ".join(recording.warnings) or "no sample was lost"
    said = [
        f"Recorded: {len(recording)} samples in {recording.duration:.1f} s at "
        f"{1.0 / recording.sample_period:g} Hz; {lost}.",
        "The controllers' model was 10 % off in every parameter. "
        f"Identified from the bag, it predicts the recording to {1e9 * found.rmse[0]:.1f} nm rms, "
        f"{100.0 * found.relative_rmse[0]:.3f} % of peak to peak; white noise in that: "
        f"{1e9 * found.white_noise[0]:.1f} nm.",
    ]
    if any(part.rms is None for part in parts):
        said.append(
            f"Where more than {100.0 * MOST_MISSED:.0f} % was missed (the plant slept through the "
            "sample, or its setpoint came late), the machine was too slow to judge the controller."
        )
    return said


def before_diagnosis(found: Diagnosis) -> str:
    """What became of the identified model, before anybody looks for the cause."""
    recording, gap = found.judged[0].recording, found.gap
    lost = " ".join(recording.warnings) or "no sample was lost"
    return (
        f"Then something happened to the rig. On a new recording of {recording.duration:.0f} s "
        f"({lost}) the identified model is {1e9 * gap.nominal:.0f} nm rms off, with a noise floor "
        f"of {1e9 * gap.noise_floor:.0f} nm. From the model and this bag alone, the diagnosis says:"
    )


def fault_table(fault: Fault, found: Diagnosis) -> Shown:
    """What was planted, beside what the diagnosis found of it."""
    settings = found.model.settings.get(fault.effect, {})
    rows = []
    for name, planted in fault.values.items():
        unit = registry()[fault.effect].parameter(name).unit
        rows.append([name, quantity(planted, unit), _found(settings.get(name), unit)])
    title = f"What the diagnosis was not told: the effect planted is {fault.effect}"
    return Shown(title, ("parameter", "planted", "found, 95 %"), rows)


def fault_notes(fault: Fault) -> list[str]:
    """What to know about the numbers of that table."""
    if fault.effect != "contact":
        return []
    off = MISTUNED["second_order", "k"] - 1.0
    return [
        f"Forces are found in proportion to the model's k: {100.0 * off:.0f} % too high in the "
        "controllers' model, and still so, because a recording at 1 kHz does not determine k."
    ]


def _found(setting: Setting | None, unit: str) -> str:
    if setting is None:
        return "not found"
    low, high = setting.interval or (float("nan"), float("nan"))
    ends = (quantity(end, unit, DIGITS) for end in (low, high))
    return f"{quantity(setting.value, unit, DIGITS)} [{', '.join(ends)}]"
