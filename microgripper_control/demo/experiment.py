"""The recorded experiments: the three control modes, then the rig with a fault."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import make_folder
from microgripper_control.demo.fault import DRIVE, Fault, write_fault
from microgripper_control.demo.fresh_bag import fresh_bag
from microgripper_control.demo.plan import (
    MODES,
    NOISE,
    SAMPLE_PERIOD,
    SEGMENTS,
    SETTINGS,
    length_of,
    write_settings,
)
from microgripper_control.demo.processes import Nodes

BAG, BAG_WITH_FAULT = "bag", "bag_with_fault"  # folders
STARTING = 120.0  # s: longest time for a node to start, compiling included
SLOWEST = 10.0  # times as long as in wall time: the longest that lockstep may take
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Run:
    """One mode's run: all its samples are stamped between `begin` and `end`, s since 1970."""

    mode: str
    begin: float
    end: float


@dataclass(frozen=True)
class Experiment:
    """What was recorded: the bag's folder, and the runs in it."""

    bag: Path
    runs: tuple[Run, ...]


def run_experiment(folder: Path, seed: int, progress: Progress) -> Experiment:
    """Run all modes, recorded in one bag. Takes about a minute.

    Plant and recorder run throughout, a controller and a reference for each mode.
    """
    _refuse_bags_of_others(make_folder(folder))
    rig, believed, reference = write_settings(folder)
    rate = 1.0 / SAMPLE_PERIOD
    length = length_of(SEGMENTS)
    # Like the plant's stamps, so that the runs stay where they are if somebody sets the clock.
    start_of_clock = time.time() - time.monotonic()
    runs = []
    with fresh_bag(folder, BAG) as bag, Nodes(folder / "log") as nodes:
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
            begin = time.monotonic()
            setpoints = nodes.start(
                "reference",
                reference,
                label=f"reference_{mode}",
                sample_rate=rate,
                at_end="stop",
                partners=["controller", "recorder"],
            )
            nodes.wait_for(setpoints, STARTING + length)
            end = time.monotonic()
            runs.append(Run(mode, start_of_clock + begin, start_of_clock + end))
            nodes.end(setpoints)
            nodes.end(controller)
        progress("closing the bag")
        nodes.end(recorder)
        nodes.end(plant)
    return Experiment(folder / BAG, tuple(runs))


def _refuse_bags_of_others(folder: Path) -> None:
    """Only a demo's own bags are replaced; its settings lie beside them."""
    if any((folder / name).exists() for name in SETTINGS):
        return
    for bag in (folder / BAG, folder / BAG_WITH_FAULT):
        if bag.exists():
            raise MicrogripperError(f"{bag}: is there already; move it away or give another --out")


def record_fault(folder: Path, fault: Fault, seed: int) -> Path:
    """Record the rig with a fault, driven open loop in lockstep; the bag's folder."""
    rig, drive = write_fault(folder, fault)
    rate, length = 1.0 / SAMPLE_PERIOD, length_of(DRIVE)
    lockstep: dict[str, Any] = {"lockstep": True, "lockstep_timeout": STARTING}
    logs = folder / "log" / "with_fault"
    with fresh_bag(folder, BAG_WITH_FAULT) as bag, Nodes(logs) as nodes:
        recorder = nodes.start("recorder", out=bag)
        controller = nodes.start(
            "controller",
            mode="open_loop",
            sample_rate=rate,
            partners=["plant_simulator", "recorder"],
            **lockstep,
        )
        plant = nodes.start(
            "plant_simulator",
            model_file=rig,
            sample_rate=rate,
            noise_std=NOISE,
            seed=seed,
            duration=length,
            partners=["controller", "reference", "recorder"],
            startup_timeout=STARTING,
            **lockstep,
        )
        setpoints = nodes.start(
            "reference",
            drive,
            quantity="voltage",
            sample_rate=rate,
            at_end="stop",
            partners=["controller", "recorder"],
        )
        for node in (plant, setpoints):
            nodes.wait_for(node, STARTING + SLOWEST * length)
        for node in (setpoints, controller, recorder, plant):
            nodes.end(node)
    return folder / BAG_WITH_FAULT
