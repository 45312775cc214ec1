"""Many minutes in lockstep: memory and latency have to stay where they are.

python test/chaos/soak.py [--minutes 30] [--simulated 60]

It ends when both have passed: the minutes on the clock and those of the plant.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path
from statistics import mean
from typing import Any

from nursery import PERIOD, Nursery
from run import in_a_domain
from witness import Witness

from microgripper_control.nodes.topics import VOLTAGE_COMMAND

LOOK_PERIOD = 10.0  # s
GROWTH = 0.03  # of memory, from the second fifth to the last
SLOWING = 0.25  # of a sample's time likewise; other work on the machine comes and goes
LOCKSTEP = {"lockstep": True, "lockstep_timeout": 60.0, "startup_timeout": 60.0}
NODES: dict[str, dict[str, Any]] = {
    "controller": LOCKSTEP,
    "reference": {"low": 3e-6, "high": 15e-6, "frequency": 1.0},
    "plant_simulator": LOCKSTEP,
}


def soak(minutes: float, simulated: float) -> list[str]:
    """Print a table; what was wrong."""
    folder = Path(tempfile.mkdtemp())
    with in_a_domain(folder), Nursery(folder) as nursery:
        witness = Witness(nursery, watched=(VOLTAGE_COMMAND,))
        nodes = {name: nursery.node(name, **settings) for name, settings in NODES.items()}
        rows: list[list[float]] = []  # memory of each node, MB; time of a sample, us
        samples, start = _samples(witness), time.monotonic()
        began = start
        print(f"{'min':>6} " + " ".join(f"{name + ', MB':>20}" for name in nodes) + "  sample, us")
        while began - start < 60.0 * minutes or PERIOD * samples < 60.0 * simulated:
            time.sleep(min(LOOK_PERIOD, 60.0 * minutes / 20))
            now, count = time.monotonic(), _samples(witness)
            if dead := [name for name, node in nodes.items() if node.status is not None]:
                return [f"{', '.join(dead)} ended: {nodes[dead[0]].log.read_text()[-500:]}"]
            latency = 1e6 * (now - began) / max(count - samples, 1)
            rows.append([*(1e-6 * node.memory for node in nodes.values()), latency])
            samples, began = count, now
            passed = (now - start) / 60.0
            print(f"{passed:6.1f} " + " ".join(f"{one:20.1f}" for one in rows[-1]), flush=True)
        print(f"{PERIOD * samples / 60.0:.1f} minutes of the plant's time in {passed:.1f}")
        invariants = witness.account()
        print(f"voltage {invariants.lowest:.1f} to {invariants.highest:.1f} V")
    return [*_growth([*nodes, "time of a sample"], rows)]


def _samples(witness: Witness) -> int:
    """How many the plant has published."""
    return int(witness.health("plant_simulator").get("samples", "0"))


def _growth(names: list[str], rows: list[list[float]]) -> list[str]:
    fifth = max(1, len(rows) // 5)
    faults = []
    bounds = [GROWTH] * (len(names) - 1) + [SLOWING]
    for name, bound, course in zip(names, bounds, zip(*rows, strict=True), strict=True):
        early, late = mean(course[fifth : 2 * fifth]), mean(course[-fifth:])
        print(f"{name}: {early:.1f}, in the end {late:.1f}, {100 * (late / early - 1):+.1f} %")
        if late > early * (1 + bound):
            faults.append(f"{name} grew from {early:.1f} to {late:.1f}")
    return faults


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--simulated", type=float, default=60.0, help="minutes of the plant")
    asked = parser.parse_args()
    faults = soak(asked.minutes, asked.simulated)
    print(*faults, sep="\n")
    sys.exit(bool(faults))
