"""The loop over two hosts with a bad network between them: the rig here, the control there."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from pathlib import Path

from hosts import Hosts, NotHereError
from impairment import CUT, NONE, Impairment
from loop import Loop, NotTrackingError
from nursery import Child, Nursery
from table import Row

from microgripper_control.nodes import topics
from microgripper_control.recordings.bag import Bag

ON_THE_RIG = ("plant_simulator", "recorder")
# The control law of a loop that is slower than it was made for: none that feeds back.
SETTINGS = {
    "controller": {
        "mode": "feedforward",
        "qos_overrides./microgripper/voltage_command.publisher.reliability": "best_effort",
    },
    # Reliable, it would wait for each lost sample to be sent again, in 2 s for all but 8 of 2000.
    "reference": {
        "qos_overrides./microgripper/joint_states.subscription.reliability": "best_effort",
    },
}
FAULTS = (
    Impairment("5 % loss", loss=0.05),
    Impairment("delay 2 ms, 1 ms of jitter", delay=2e-3, jitter=1e-3),
    Impairment("loss, delay, a tenth overtakes", loss=0.02, delay=2e-3, jitter=5e-4, reorder=0.1),
)
CUT_FOR = 0.5  # s
RAMP_BEGINS = 0.1  # s, after the loss
LOST = re.compile(r"(\d+) lost")
RECORDED = (topics.VOLTAGE_COMMAND, topics.SETPOINT)


def network(nursery: Nursery, folder: Path, length: float, seed: int) -> list[Row]:
    """`length` s of each impairment; rows, of which one says so where nothing can be done."""
    try:
        with Hosts(nursery, seed) as hosts:
            return list(_rows(nursery, hosts, folder, length))
    except NotHereError as error:
        row = Row("two hosts")
        row.remarks.append(f"skipped: {error}")
        return [row]


def _rows(nursery: Nursery, hosts: Hosts, folder: Path, length: float) -> Iterator[Row]:
    places = {host: hosts.place(host) for host in ("rig", "desk")}
    loop = Loop(
        nursery,
        folder,
        place=lambda name: places["rig" if name in ON_THE_RIG else "desk"],
        reliable=False,  # as what it listens to
        settings=SETTINGS,
    )
    loop.tracks()
    for impairment in FAULTS:
        row = Row(f"two hosts, {impairment.name}", injected=1)
        row.remarks.append(f"link: {hosts.link}")
        hosts.impair(impairment)
        time.sleep(length)
        yield _judged(hosts, loop, row)
    yield _cut(hosts, loop)
    yield _counted(loop)


def _judged(hosts: Hosts, loop: Loop, row: Row) -> Row:
    """Take the impairment away and see that nothing was wrong."""
    hosts.impair(NONE)
    ends = time.time()
    try:
        row.recoveries.append(loop.tracks_since(ends) - ends)
    except NotTrackingError as error:
        row.failed(str(error))
    row.notes += [f"ended: {one}" for one in loop.dead()]
    invariants = loop.witness.account()
    row.saw(invariants)
    row.notes += invariants.described
    row.survived = 0 if row.notes else row.injected
    return row


def _cut(hosts: Hosts, loop: Loop) -> Row:
    """Cut the link for a while; each side has to come down by itself."""
    row = Row("two hosts, cut link", injected=1)
    hosts.impair(CUT)
    time.sleep(CUT_FOR)
    # Only the desk's side can be seen from there; the rig's is in its own report.
    *_, (_, voltage) = loop.witness.since(topics.VOLTAGE_COMMAND, time.time() - CUT_FOR)
    if voltage != 0.0:
        row.failed(f"the controller held {voltage:.1f} V without feedback")
    guarded = loop.witness.health("plant_simulator").get("times the rig's guard took over", "0")
    _judged(hosts, loop, row)
    name = "times the rig's guard took over"
    again = loop.witness.until(
        lambda: int(loop.witness.health("plant_simulator").get(name, "0")) > int(guarded), 5.0
    )
    if not again:
        row.failed("the rig's guard did not take over")
        row.survived = 0
    return row


def _counted(loop: Loop) -> Row:
    """Whether the recorder knows how much it lost of what was published on the other host."""
    row = Row("two hosts, the recorder's count", injected=1)
    recorder: Child = loop.nodes["recorder"]
    numbers = {topic: loop.witness.numbers(topic) for topic in RECORDED}
    statuses = loop.end()
    lost = int(LOST.findall(recorder.log.read_text())[-1])
    with Bag(loop.bag) as bag:
        missing = sum(_missing(bag, topic, numbers[topic]) for topic in RECORDED)
    row.remarks.append(f"lost {missing} messages, counted {lost}")
    if lost != missing:
        row.failed(f"lost {missing} messages, and counted {lost}")
    if any(statuses.values()):
        row.failed(f"exit status {statuses}")
    row.survived = 0 if row.notes else 1
    return row


def _missing(bag: Bag, topic: str, numbers: dict[float, int]) -> int:
    """How many messages a bag lacks between the first and the last that the witness saw too.

    The witness, on a machine with much to do, loses some as well: hence not those that it saw, but
    what their numbers say. Before and after them nothing was impaired.
    """
    (found,) = (one for one in bag.topics if one.name == f"/microgripper/{topic}")
    stamps = [stamp * 1e-9 for _, stamp, _ in bag.messages([found])]
    seen = [place for place, stamp in enumerate(stamps) if stamp in numbers]
    first, last = seen[0], seen[-1]
    return numbers[stamps[last]] - numbers[stamps[first]] - (last - first)
