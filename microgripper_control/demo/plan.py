"""What the demo does: the rig, the controller's imperfect model of it, and the setpoints."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from microgripper_control.control.setpoints import Sequence, make_setpoint
from microgripper_control.core.files import written_whole
from microgripper_control.core.share import share_folder
from microgripper_control.plant.model import Key, Model
from microgripper_control.plant.model_file import load_model, save_model

MODES = ("feedforward", "pid", "cascade")
SAMPLE_PERIOD = 1e-3  # s
NOISE = 15e-9  # m
# The controller's model is off by as much as a careless identification: every parameter by 10 %.
MISTUNED: dict[Key, float] = {
    ("bouc_wen", "d"): 0.9,
    ("bouc_wen", "alpha"): 1.1,
    ("bouc_wen", "beta"): 0.9,
    ("bouc_wen", "gamma"): 1.1,
    ("second_order", "m"): 1.1,
    ("second_order", "b"): 0.9,
    ("second_order", "k"): 1.1,
    ("second_order", "k_s"): 0.9,
}
# After the first cycle a piezo no longer returns to zero: the warm-up brings it there, and the
# setpoints that count stay above what is left at 0 V.
WARM_UP = "warm-up"
LOW, HIGH = 3e-6, 15e-6  # m
SPAN = {"low": LOW, "high": HIGH}
SETTINGS = ("rig.yaml", "controller_model.yaml", "reference.yaml")  # files of an experiment
Segments = Mapping[str, Mapping[str, Any]]  # shape, length and values of each, in their order
SEGMENTS: Segments = {
    WARM_UP: {"shape": "triangle", "length": 2.0, "low": 0.0, "high": 17e-6, "frequency": 0.5},
    "staircase": {"shape": "staircase", "length": 6.5, "steps": 6.0, "hold": 0.5, **SPAN},
    "triangle": {"shape": "triangle", "length": 3.0, "frequency": 1.0, **SPAN},
    "sine": {"shape": "sine", "length": 4.0, "frequency": 1.0, **SPAN},
}


def true_model() -> Model:
    """The rig that is simulated: the paper's actuator."""
    return load_model(share_folder() / "config" / "apa120s.yaml")


def controllers_model() -> Model:
    """What the controller believes, and identification starts from."""
    truth = true_model()
    return truth.with_values({key: truth.value(*key) * f for key, f in MISTUNED.items()})


def course() -> Sequence:
    """The setpoints of one run, m."""
    parts = []
    for name, segment in SEGMENTS.items():
        values = {key: value for key, value in segment.items() if key not in ("shape", "length")}
        parts.append((make_setpoint(segment["shape"], values, name), segment["length"]))
    return Sequence(tuple(parts))


def length_of(segments: Segments) -> float:
    """How long segments take one after the other, s."""
    return float(sum(segment["length"] for segment in segments.values()))


def write_settings(folder: Path) -> tuple[Path, Path, Path]:
    """Write the rig's model, the controller's model and the reference's parameters; their paths."""
    rig, believed, reference = (folder / name for name in SETTINGS)
    save_model(true_model(), rig)
    save_model(controllers_model(), believed)
    write_reference(reference, SEGMENTS)
    return rig, believed, reference


def write_reference(path: Path, segments: Segments) -> None:
    """Write segments as parameters of the node `reference`."""
    parameters = {"segments": list(segments), **segments}
    with written_whole(path) as file:
        yaml.safe_dump({"/**": {"ros__parameters": parameters}}, file, sort_keys=False)
