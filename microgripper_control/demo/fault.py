"""The demo's second part: what happens to the rig, and the voltage that will show it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

from microgripper_control.demo.plan import Segments, true_model, write_reference
from microgripper_control.plant.model_file import save_model

# What may happen, and the range of each value that is drawn.
RANGES: Mapping[str, Mapping[str, tuple[float, float]]] = MappingProxyType(
    {
        "contact": {"position": (9e-6, 12e-6), "stiffness": (3e6, 6e6)},
        "creep": {"strength": (0.01, 0.02)},
    }
)
DIGITS = 2  # of a drawn value: it is to be read
# V: slow loops, steps with holds and a faster part, for effects of position, time and rate.
DRIVE: Segments = {
    "loops": {"shape": "triangle", "length": 8.0, "low": 0.0, "high": 130.0, "frequency": 0.5},
    "steps": {
        "shape": "staircase",
        "length": 8.0,
        "low": 10.0,
        "high": 130.0,
        "steps": 4.0,
        "hold": 1.0,
    },
    "shaking": {
        "shape": "multisine",
        "length": 4.0,
        "low": 20.0,
        "high": 120.0,
        "period": 2.0,
        "lowest": 0.5,
        "highest": 20.0,
    },
    "again": {"shape": "triangle", "length": 4.0, "low": 0.0, "high": 130.0, "frequency": 0.5},
}


@dataclass(frozen=True)
class Fault:
    """An effect that the rig has from now on, with those of its values that are not nominal."""

    effect: str
    values: Mapping[str, float]


def drawn_fault(seed: int) -> Fault:
    """The fault that a seed stands for."""
    chance = np.random.default_rng(seed)
    effect = str(chance.choice(list(RANGES)))
    drawn = {name: chance.uniform(low, high) for name, (low, high) in RANGES[effect].items()}
    return Fault(effect, {name: float(f"{x:.{DIGITS - 1}e}") for name, x in drawn.items()})


def write_fault(folder: Path, fault: Fault) -> tuple[Path, Path]:
    """Write the model of the rig with the fault and the voltage's parameters; their paths."""
    rig, drive = folder / "rig_with_fault.yaml", folder / "drive.yaml"
    save_model(true_model().with_link(fault.effect, **fault.values), rig)
    write_reference(drive, DRIVE)
    return rig, drive
