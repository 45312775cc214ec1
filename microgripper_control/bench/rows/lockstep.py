"""Lockstep: how much faster than real time plant and controller go, over DDS and in one process."""

from __future__ import annotations

import re
import shutil
from typing import Any

import numpy as np

from microgripper_control.bench import rig
from microgripper_control.bench.loops import STARTING, check_ros
from microgripper_control.bench.row import FASTER, Effort, Line, Measured, Row, at_least
from microgripper_control.bench.timing import Contestant, Spread, take_turns
from microgripper_control.control.controller import Controller
from microgripper_control.control.identified import Identified
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array
from microgripper_control.demo.processes import Nodes
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.rig import Rig

TWICE, IN_PROCESS = at_least(2.0), at_least(200.0)
TICKS = 2000
SAID = re.compile(r"(\d+) samples in ([\d.]+) s")
LOCKSTEP: dict[str, Any] = {"lockstep": True, "lockstep_timeout": STARTING}


def measure(effort: Effort) -> Measured:
    """As `Row` says."""
    check_ros()
    duration = effort.among(10.0, 3.0)
    inside, two, four = [], [], []
    # In turns: plant and controller in one process take a quarter of a second, and a machine has
    # slower moods than that.
    for _ in range(effort.among(3, 1)):
        two.append(over_dds(effort, duration, beside=False))
        inside.append(in_process(effort))
        four.append(over_dds(effort, duration, beside=True))
        inside.append(in_process(effort))
    what, real = "lockstep at 1 kHz over DDS, plant and controller", "real time"
    lines = (
        Line(what, real, Spread.of(np.array(two)), FASTER, TWICE),
        Line(f"{what}, reference and recorder beside", real, Spread.of(np.array(four)), FASTER),
        Line(
            "plant and controller in one process",
            real,
            Spread.of(np.concatenate(inside)),
            FASTER,
            IN_PROCESS,
        ),
    )
    return Measured(lines)


def in_process(effort: Effort) -> Array:
    """Simulated time over time spent, of the plant and the cascade in a Python loop, by rounds."""
    model = nominal_model()
    simulated = Rig(model, rig.SAMPLE_PERIOD)
    controller = Controller(Identified.of(model), rig.SAMPLE_PERIOD)
    controller.start(0.0)
    setpoints = (1e-7 * rig.voltage(TICKS)).tolist()

    def run() -> None:
        for setpoint in setpoints:
            simulated.tick()
            simulated.command(controller.step(setpoint, simulated.position, simulated.voltage))

    spent = take_turns({"run": Contestant(run, TICKS)}, effort.rounds).rounds["run"]
    return rig.SAMPLE_PERIOD / spent


def over_dds(effort: Effort, duration: float, *, beside: bool) -> float:
    """Simulated time over time spent; with `beside`, reference and recorder take part as well."""
    bag = effort.folder / "lockstep_bag"
    shutil.rmtree(bag, ignore_errors=True)
    others = ["reference", "recorder"] if beside else []
    effort.progress(" and ".join(["lockstep: plant", "controller", *others]))
    run: dict[str, Any] = {**LOCKSTEP, "duration": duration, "startup_timeout": STARTING}
    with Nodes(effort.folder / "log") as nodes:
        if beside:
            nodes.start("recorder", out=bag)
            nodes.start("reference", partners=["controller", "recorder"])
        nodes.start(
            "controller",
            partners=["plant_simulator", *others[1:]],
            await_setpoint=beside,
            **LOCKSTEP,
        )
        if not beside:  # then it sends the setpoint as well
            run["out"] = effort.folder / "lockstep_trips.json"
        plant = nodes.start(
            "plant_simulator" if beside else "timed_plant", partners=["controller", *others], **run
        )
        nodes.wait_for(plant, STARTING + 2.0 * duration)
    said = SAID.search(plant.log.read_text(encoding="utf-8"))
    if said is None:
        raise MicrogripperError("bench: the plant did not say how long it took")
    return int(said[1]) * rig.SAMPLE_PERIOD / float(said[2])


ROW = Row("lockstep", "lockstep", measure)
