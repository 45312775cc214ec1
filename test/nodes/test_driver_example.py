"""The driver for a real rig that the documentation shows, with a DAQ that is none."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import textwrap
from itertools import pairwise
from pathlib import Path

import pytest
from running_nodes import PATIENCE, ROOT, Watcher
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

pytestmark = pytest.mark.ros

DAQ = """
class daq:
    def read_voltage():
        return 0.0

    def sample_and_latch(voltage):
        return 1e-7 * voltage
"""


def example() -> str:
    """The code in the document."""
    text = (ROOT / "docs" / "reliability.md").read_text(encoding="utf-8")
    found = re.search(
        r"^    import math\n(?:(?:    .*)?\n)*?    run\(Driver\)\n", text, re.MULTILINE
    )
    assert found is not None
    return textwrap.dedent(found[0])


def test_it_obeys_and_comes_down_by_itself(
    watcher: Watcher, ros_domain: dict[str, str], tmp_path: Path
) -> None:
    file = tmp_path / "driver.py"
    file.write_text(DAQ + example(), encoding="utf-8")
    env = {**ros_domain, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    states = watcher.messages(JointState, "joint_states")
    driver = subprocess.Popen([sys.executable, str(file)], env=env, cwd=tmp_path)
    try:
        commands = watcher.publisher(Float64, "voltage_command")

        def obeys() -> bool:
            commands.publish(Float64(data=50.0))
            return bool(states) and states[-1].effort[0] == 50.0

        watcher.until(obeys, "50 V")
        watcher.until(lambda: states[-1].effort[0] == 0.0, "0 V, without any command")
        watcher.until(obeys, "50 V again")
        driver.send_signal(signal.SIGTERM)
        assert driver.wait(PATIENCE) == 0
    finally:
        driver.kill()
        driver.wait()
    voltages = [state.effort[0] for state in states]
    steps = [abs(b - a) for a, b in pairwise(voltages)]
    assert max(steps) <= 2.0 * 5  # the ramp rate; a few samples may have been lost on the way
