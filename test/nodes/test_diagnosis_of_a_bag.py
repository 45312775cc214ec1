"""A rig with an effect that the model lacks, driven over DDS, diagnosed from its bag alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from running_nodes import PATIENCE, Start

from microgripper_control.core.recording import Recording
from microgripper_control.diagnosis.diagnose import diagnose
from microgripper_control.diagnosis.findings import EFFECTS
from microgripper_control.plant.model import Model, nominal_model
from microgripper_control.plant.model_file import save_model
from microgripper_control.recordings.read import read_recording

pytestmark = pytest.mark.ros

PLANTED: dict[str, dict[str, float]] = {
    "contact": {"position": 10e-6, "stiffness": 4e6},
    "creep": {"strength": 0.015, "fastest": 0.02},
}
OFF = {"d": 1.05, "alpha": 0.95, "beta": 1.05, "gamma": 0.95}
LENGTH = 16.0  # s
# Shapes with their lengths, s; the ends are those of the loop's quantity.
COURSE: dict[str, dict[str, Any]] = {
    "loops": {"shape": "triangle", "length": 4.0, "frequency": 0.5},
    "steps": {"shape": "staircase", "length": 8.0, "steps": 4.0, "hold": 1.0},
    "shaking": {"shape": "multisine", "length": 4.0, "period": 2.0, "highest": 20.0},
}


def course(**ends: float) -> dict[str, Any]:
    """The reference's parameters."""
    segments = {name: {**segment, **ends} for name, segment in COURSE.items()}
    named = {f"{name}.{key}": x for name, own in segments.items() for key, x in own.items()}
    return {"segments": list(segments), **named}


def believed() -> Model:
    """What the user's YAML says: each parameter is 5 % off."""
    true = nominal_model()
    return true.with_values(
        {("bouc_wen", name): factor * true.value("bouc_wen", name) for name, factor in OFF.items()}
    )


def experiment(
    start: Start, folder: Path, rig: Model, mode: str, reference: dict[str, Any]
) -> Recording:
    """Record `rig` in lockstep; `reference` says in which quantity it is driven, and how."""
    save_model(rig, folder / "rig.yaml")
    save_model(believed(), folder / "believed.yaml")
    lockstep = {"lockstep": True, "lockstep_timeout": PATIENCE}
    recorder = start("recorder", out=str(folder / "bag"))
    control = start(
        "controller",
        model_file=str(folder / "believed.yaml"),
        partners=["plant_simulator", "recorder"],
        **lockstep,
        mode=mode,
    )
    plant = start(
        "plant_simulator",
        model_file=str(folder / "rig.yaml"),
        noise_std=15e-9,
        seed=3,
        duration=LENGTH,
        partners=["controller", "reference", "recorder"],
        startup_timeout=PATIENCE,
        **lockstep,
    )
    driver = start("reference", at_end="stop", partners=["controller", "recorder"], **reference)
    for node in (plant, driver):
        assert node.ended() == 0
    for node in (control, recorder):
        assert node.stop() == 0
    return read_recording(folder / "bag")


@pytest.mark.parametrize(
    ("mode", "quantity", "ends", "planted"),
    [
        ("cascade", "displacement", {"low": 2e-6, "high": 15e-6}, "creep"),
        ("open_loop", "voltage", {"low": 10.0, "high": 120.0}, "contact"),
    ],
    ids=["closed loop", "open loop"],
)
def test_the_effect_is_named_from_the_bag_alone(
    start: Start,
    tmp_path: Path,
    mode: str,
    quantity: str,
    ends: dict[str, float],
    planted: str,
) -> None:
    rig = nominal_model().with_link(planted, **PLANTED[planted])
    driven = {"quantity": quantity, **course(**ends)}
    recording = experiment(start, tmp_path, rig, mode, driven)
    assert recording.warnings == ()
    found = diagnose(believed(), [recording])
    assert (found.verdict, found.effects) == (EFFECTS, (planted,))
    assert found.gap.closed > 0.8
