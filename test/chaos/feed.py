"""A million messages straight into the callbacks of a controller and a rig.

Over DDS as many would take a quarter of an hour; what is tested is what the nodes make of them.
Every voltage that the controller publishes is checked, and whether memory grows.
"""

from __future__ import annotations

import json
import os
import random
import sys
import time
from pathlib import Path
from typing import Any

import rclpy
from hostile import Hostile
from invariants import HIGH, LOW, Invariants
from nursery import Nursery
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from table import Row

from microgripper_control.control.controller import Mode
from microgripper_control.nodes.controller import ControllerNode
from microgripper_control.nodes.plant_simulator import PlantSimulator

POOL = 4096  # messages of a kind; they are sent over and over
HONEST = 0.2  # share of the samples that are what a plant would send
WORK = 20  # messages between the nodes' own turns
CHANGE = 20_000  # messages between changes of the mode
GROWTH = 8e6  # bytes that memory may grow by after the first fifth
PATIENCE = 600.0  # s


def feed(nursery: Nursery, folder: Path, count: int, seed: int) -> Row:
    """So many messages, most of them hostile."""
    out = folder / "feed.json"
    child = nursery.fork("feed", lambda: out.write_text(json.dumps(_feed(count, seed))))
    row = Row("hostile messages, into the callbacks", injected=count)
    if child.wait(PATIENCE) != 0:
        row.failed(f"the nodes died: {child.log.read_text()[-500:]}")
        return row
    found = json.loads(out.read_text())
    row.lowest, row.highest, row.worst_rate = found["lowest"], found["highest"], found["rate"]
    faults = [*found["faults"]]
    if found["grown"] > GROWTH:
        faults.append(f"memory grew by {1e-6 * found['grown']:.1f} MB")
    row.survived = 0 if faults else count
    row.notes += faults
    row.remarks.append(
        f"{found['voltages']} voltages published, memory {found['grown'] / 1e6:+.1f} MB"
    )
    return row


class _Checked:
    """Stands in the place of the publisher of the voltages."""

    def __init__(self, publisher: Any) -> None:  # noqa: ANN401
        self.invariants = Invariants()
        self._publisher = publisher

    def publish(self, message: Any) -> None:  # noqa: ANN401
        self.invariants.note(time.monotonic(), message.data)

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401
        return getattr(self._publisher, name)


def _feed(count: int, seed: int) -> dict[str, Any]:
    """In a process of its own: what came of it."""
    sys.argv = ["feed"]
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    chance = random.Random(seed)
    hostile = Hostile(chance)
    samples = [hostile.sample() for _ in range(POOL)]
    numbers = [hostile.number() for _ in range(POOL)]
    honest = JointState(name=["finger"], position=[0.0], effort=[0.0])
    controller, plant = ControllerNode(), PlantSimulator()
    for node in (controller, plant):
        node.begin()
    output: Any = controller._output
    output.publisher = checked = _Checked(output.publisher)
    faults: list[str] = []
    early = 0
    for number in range(count):
        kind = chance.random()
        if kind < 0.5:
            sample = honest if chance.random() < HONEST else samples[chance.randrange(POOL)]
            if sample is honest:
                honest.position[0], honest.effort[0] = plant._rig.position, plant._rig.voltage
            if sample is honest or chance.random() < 0.5:
                stamp = sample.header.stamp
                stamp.sec, stamp.nanosec = divmod(time.monotonic_ns(), 10**9)
            controller._on_sample(sample)
        elif kind < 0.7:
            controller._on_setpoint(numbers[chance.randrange(POOL)])
        elif kind < 0.8:
            controller._on_voltage_setpoint(numbers[chance.randrange(POOL)])
        else:
            plant._on_command(numbers[chance.randrange(POOL)])
        if number % WORK == 0:
            now = time.monotonic()
            for node in (controller, plant):
                node.work(now)
                node.report_if_due(now)
            if not LOW <= plant._rig.voltage <= HIGH:
                faults.append(f"the rig was at {plant._rig.voltage} V")
        if number % CHANGE == CHANGE - 1:
            mode = chance.choice(list(Mode)).value
            controller.set_parameters([Parameter("mode", value=mode)])
        if number == count // 5:
            early = _memory()
    invariants = checked.invariants
    return {
        "lowest": invariants.lowest,
        "highest": invariants.highest,
        "rate": invariants.worst_rate,
        "voltages": invariants.count,
        "faults": faults[:5] + invariants.described,
        "grown": _memory() - early,
    }


def _memory() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")
