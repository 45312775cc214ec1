"""Start-up of each node, once compiled, against importing rclpy and creating a node."""

from __future__ import annotations

import subprocess
import sys
import time
from contextlib import suppress
from threading import Timer

import numpy as np

from microgripper_control.bench.loops import READY, check_ros
from microgripper_control.bench.row import Effort, Line, Measured, Row, at_most
from microgripper_control.bench.timing import Spread
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.demo.domain import on_this_machine, unused_domain

NODES = ("plant_simulator", "controller", "reference", "recorder", "diagnoser")
BARE = """
import rclpy
rclpy.init()
node = rclpy.create_node("bare")
node.get_logger().info("ready")
"""
LONGEST = 120.0  # s, until a node is ready
PATIENCE = 30.0  # s, until it has ended
ONE_SECOND = at_most(1.0)


def measure(effort: Effort) -> Measured:
    """As `Row` says."""
    check_ros()
    commands = {"bare": ["-c", BARE]}
    for name in NODES:
        commands[name] = ["-m", f"microgripper_control.nodes.{name}"]
    times: dict[str, list[float]] = {name: [] for name in commands}
    with unused_domain() as domain:
        env = {**on_this_machine(domain), "ROS_LOG_DIR": str(effort.folder / "log")}
        for turn in range(1 + effort.among(5, 2)):
            for name, words in commands.items():
                effort.progress(f"start-up: {name}")
                bag = ["--ros-args", "-p", f"out:=bag{turn}"] if name == "recorder" else []
                spent = until_ready([*words, *bag], env, effort)
                if turn:  # the first start compiles
                    times[name].append(spent)
    bare = np.array(times["bare"])
    lines = [
        Line(
            f"{name}, second start until ready",
            "importing rclpy and creating a node",
            Spread.of(np.array(times[name]) - bare),
            "s more",
            ONE_SECOND,
            float(np.median(times[name])),
            float(np.median(bare)),
        )
        for name in NODES
    ]
    return Measured(tuple(lines), ("From the start of the process until it logs `ready`.",))


def until_ready(words: list[str], env: dict[str, str], effort: Effort) -> float:
    """Start a process and end it once it is ready; how long that took, s."""
    began = time.monotonic()
    process = subprocess.Popen(
        [sys.executable, *words],
        env=env,
        cwd=effort.folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    assert process.stderr is not None
    too_long = Timer(LONGEST, process.kill)
    too_long.start()
    try:
        for line in process.stderr:
            if READY in line.decode(errors="replace"):
                return time.monotonic() - began
        raise MicrogripperError(f"bench: {words[1]} ended before it was ready")
    finally:
        too_long.cancel()
        process.terminate()
        process.stderr.close()
        with suppress(subprocess.TimeoutExpired):
            process.wait(PATIENCE)
        process.kill()


ROW = Row("startup", "start-up of a node", measure)
