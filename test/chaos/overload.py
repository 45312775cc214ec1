"""Four times the rate that this machine can do, and both cores busy with something else."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from loop import Loop
from nursery import Nursery
from table import Row

RATE = 4000.0  # Hz
COUNTED = 0.05  # how well the counts have to fit the time that passed


def overload(nursery: Nursery, folder: Path, length: float) -> Row:
    """For `length` s; misses have to be counted and reported, and the voltage has to stay sane."""
    row = Row(f"overload: {RATE:g} Hz, busy cores", injected=1)
    rate = {"sample_rate": RATE}
    names = ("plant_simulator", "controller", "reference")
    settings = dict.fromkeys(names, rate)
    loop = Loop(nursery, folder, names=names, period=1.0 / RATE, settings=settings)
    busy = [nursery.fork("busy", _busy) for _ in range(os.cpu_count() or 1)]
    plant = loop.nodes["plant_simulator"]
    loop.witness.until(lambda: loop.witness.health("plant_simulator"), 20.0)
    before, began = loop.witness.health("plant_simulator"), time.monotonic()
    time.sleep(length)
    loop.witness.until(lambda: loop.witness.health("plant_simulator") != before, 5.0)
    after, took = loop.witness.health("plant_simulator"), time.monotonic() - began
    for child in busy:
        child.kill()
    samples, missed = (int(after[name]) - int(before[name]) for name in ("samples", "missed ticks"))
    # Reports come once a second, so the time between two of them is known to about one.
    due = RATE * took
    if not missed:
        row.failed("no tick was missed: this was no overload")
    if abs(samples + missed - due) > RATE + COUNTED * due:
        row.failed(f"{samples} samples and {missed} missed ticks in {took:.1f} s")
    if "ticks missed" not in plant.log.read_text():
        row.failed("misses were not reported")
    row.notes += [f"ended: {one}" for one in loop.dead()]
    invariants = loop.witness.account()
    row.saw(invariants)
    row.notes += invariants.described
    skipped = loop.witness.health("controller").get("samples missed", "?")
    row.remarks.append(f"{missed} of {samples + missed} ticks missed, the controller {skipped}")
    row.notes += [f"{name}: exit status {code}" for name, code in loop.end().items() if code]
    row.survived = 0 if row.notes else 1
    return row


def _busy() -> None:
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    while True:
        pass
