"""The recorded experiment: plant and recorder throughout, a controller and a reference a mode."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

from microgripper_control.demo.plan import MODES, NOISE, SAMPLE_PERIOD, SEGMENTS, write_settings
from microgripper_control.demo.processes import Nodes

STARTING = 60.0  # s: longest time for a node to start, compiling included
Progress = Callable[[str], None]


def run_experiment(folder: Path, seed: int, progress: Progress) -> Path:
    """Run all modes, recorded in one bag; returns its folder. Takes about a minute."""
    rig, believed, reference = write_settings(folder)
    bag = folder / "bag"
    shutil.rmtree(bag, ignore_errors=True)
    rate = 1.0 / SAMPLE_PERIOD
    length = sum(segment["length"] for segment in SEGMENTS.values())
    with Nodes(folder / "log") as nodes:
        plant = nodes.start(
            "plant_simulator", model_file=rig, sample_rate=rate, noise_std=NOISE, seed=seed
        )
        recorder = nodes.start("recorder", out=bag)
        for mode in MODES:
            progress(mode)
            controller = nodes.start(
                "controller",
                label=f"controller_{mode}",
                mode=mode,
                sample_rate=rate,
                model_file=believed,
            )
            setpoints = nodes.start(
                "reference",
                reference,
                label=f"reference_{mode}",
                sample_rate=rate,
                at_end="stop",
                partners=["controller", "recorder"],
            )
            nodes.wait_for(setpoints, STARTING + length)
            nodes.end(setpoints)
            nodes.end(controller)
        progress("closing the bag")
        nodes.end(recorder)
        nodes.end(plant)
    return bag
