"""Each node in turn killed, stopped for a while, or ended and started again, at random moments."""

from __future__ import annotations

import random
import signal
import time
from collections.abc import Iterator

from loop import Loop, NotTrackingError
from nursery import NODES, PERIOD
from table import Row
from witness import Course

from microgripper_control.nodes import topics

FAULTS = KILL, STOP, RESTART = "SIGKILL", "SIGSTOP", "SIGTERM, start again"
SOONEST, LATEST = 0.02, 0.3  # s: the fault comes within this of the loop's tracking
SHOWN = 0.18  # s: the ramp has shown itself by then
CLEAN_END = 3.0  # s
RAMP_STEP = 2000.0 * PERIOD  # V
RAMP_BEGINS = 0.1  # s: at the latest, after the loss
RAMP_ROW = 4  # steps at the ramp rate in a row are no control

# What is lost with a node, and where the ramp that follows is seen.
LOST = {
    "plant_simulator": (topics.JOINT_STATES, topics.VOLTAGE_COMMAND),
    "controller": (topics.VOLTAGE_COMMAND, topics.JOINT_STATES),
    "reference": (topics.SETPOINT, topics.VOLTAGE_COMMAND),
}

GUARDED_BY = {
    "plant_simulator": "controller",
    "controller": "plant_simulator",
    "reference": "controller",
}


def rounds(loop: Loop, count: int, budget: float, chance: random.Random) -> list[Row]:
    """So many faults, or as many as fit in `budget`, s; a row for each kind on each node."""
    rows: dict[tuple[str, str], Row] = {}
    begin = time.monotonic()
    for number in range(count):
        if time.monotonic() - begin > budget:
            first = next(iter(rows.values()))
            first.remarks.append(f"{number} rounds instead of {count}: the time was up")
            break
        fault, name = FAULTS[number % len(FAULTS)], NODES[number % len(NODES)]
        row = rows.setdefault((fault, name), Row(f"{fault}: {name}"))
        row.injected += 1
        faults = list(_one(loop, fault, name, row, chance))
        row.survived += not faults
        row.notes += [f"round {number}: {one}" for one in faults]
    return [rows[key] for key in sorted(rows)]


def _one(loop: Loop, fault: str, name: str, row: Row, chance: random.Random) -> Iterator[str]:
    """Inject one fault; what was wrong."""
    try:
        loop.tracks()
    except NotTrackingError as error:
        yield f"before it, {error}"
        return
    time.sleep(chance.uniform(SOONEST, LATEST))
    begin = time.time()
    waited = loop.nodes[GUARDED_BY[name]].waited if name in LOST else 0.0
    node = loop.nodes[name]
    if fault == RESTART:
        node.send(signal.SIGTERM)
        if (status := node.wait(CLEAN_END)) != 0:
            yield f"exit status {status} on SIGTERM"
    else:
        node.send(signal.Signals[fault])
    time.sleep(SHOWN)
    if (fault, name) == (RESTART, "controller"):
        yield from _came_down(loop)
    elif name in LOST:
        yield from _ramp(loop, name, begin, waited, row)
    cause_ends = time.time()
    if fault == STOP:
        node.send(signal.SIGCONT)
    else:
        node.kill()
        loop.start(name)
    try:
        row.recoveries.append(loop.tracks_since(cause_ends) - cause_ends)
    except NotTrackingError as error:
        yield str(error)
    if loop.dead():
        yield f"ended: {', '.join(loop.dead())}"
    invariants = loop.witness.account()
    row.saw(invariants)
    if invariants.violations:
        yield f"the voltage: {'; '.join(invariants.described)}"


def _ramp(loop: Loop, name: str, begin: float, waited_before: float, row: Row) -> Iterator[str]:
    """Look for the ramp to the safe voltage after a loss; the one that ramps had waited before."""
    ramping = loop.nodes[GUARDED_BY[name]]
    lost, seen = LOST[name]
    last = max((at for at, _ in loop.witness.since(lost, begin - 0.5)), default=begin)
    course = loop.witness.since(seen, last)
    found = ramp_begin(course)
    if found is None:
        if max((voltage for _, voltage in course[1:]), default=0.0) > RAMP_ROW * RAMP_STEP:
            yield f"no ramp: {[(round(1e3 * (at - last)), round(v, 1)) for at, v in course[:12]]}"
        return  # it was at the safe voltage, or almost
    row.ramps.append(found - last)
    waited = ramping.waited - waited_before
    if found - last > RAMP_BEGINS + waited:
        yield (
            f"the ramp began {1e3 * (found - last):.0f} ms after the loss, "
            f"{1e3 * waited:.0f} ms of which its node had no processor"
        )


def _came_down(loop: Loop) -> Iterator[str]:
    """Look whether a controller that was asked to end has left the safe voltage behind."""
    *_, (_, voltage) = loop.witness.since(topics.JOINT_STATES, time.time() - 0.1)
    if voltage != 0.0:
        yield f"left {voltage:.1f} V behind"


def ramp_begin(course: Course) -> float | None:
    """When in the course of a voltage a descent at the ramp rate begins, s; None if none does."""
    in_row = 0
    for k in range(1, len(course)):
        voltage = course[k][1]
        step = course[k - 1][1] - voltage
        arrives = voltage == 0.0 and 0.0 < step < RAMP_STEP
        in_row = in_row + 1 if arrives or abs(step - RAMP_STEP) < 1e-6 else 0
        if in_row == RAMP_ROW:
            return course[k - RAMP_ROW + 1][0]
    return None
