"""Everything that can happen to the nodes, one after the other, in a domain of its own."""

from __future__ import annotations

import os
import random
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ends import ends
from feed import feed
from flood import flood
from loop import Loop
from network import network
from nursery import Nursery
from overload import overload
from rounds import rounds
from table import Row

from microgripper_control.core.share import share_folder
from microgripper_control.demo.domain import on_this_machine, unused_domain

# In shared memory a process that is stopped with a lock in its hands stops those who write to it.
UDP_ALONE = {
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",
    "FASTRTPS_DEFAULT_PROFILES_FILE": str(share_folder() / "config" / "fastdds_udp.xml"),
}


@dataclass(frozen=True)
class Dose:
    """How much of everything."""

    messages: int = 1_000_000
    flood: float = 20.0  # s
    rounds: int = 200
    most: float = 560.0  # s, for all: what is over it the rounds do without
    ends: int = 200
    network: float = 5.0  # s of each impairment
    overload: float = 8.0  # s


OVERHEAD = 20.0  # s, for starting and ending loops
FULL = Dose()
SMALL = Dose(messages=20_000, flood=1.5, rounds=4, ends=8, network=1.0, overload=2.0)


def run(folder: Path, dose: Dose, seed: int, say: Callable[[str], None]) -> list[Row]:
    """All rows of the table. About six minutes for the full dose on two cores."""
    rows: list[Row] = []
    chance = random.Random(seed)
    folder.mkdir(parents=True, exist_ok=True)
    os.chdir(folder)
    begin = time.monotonic()
    with in_a_domain(folder / "ros"), Nursery(folder / "log") as nursery:

        def take(what: str, work: Callable[[], list[Row]]) -> None:
            start = time.monotonic()
            rows.extend(work())
            say(f"{what}: {time.monotonic() - start:.0f} s")

        take("callbacks", lambda: [feed(nursery, folder, dose.messages, seed)])
        take("ends", lambda: [ends(nursery, dose.ends, chance)])
        took = time.monotonic() - begin
        budget = dose.most - took - dose.flood - 4 * dose.network - dose.overload - OVERHEAD
        take("rounds", lambda: _on_a_loop(nursery, folder, dose, budget, seed, chance))
        take("network", lambda: network(nursery, folder / "hosts", dose.network, seed))
        take("overload", lambda: [overload(nursery, folder, dose.overload)])
    return rows


def _on_a_loop(
    nursery: Nursery,
    folder: Path,
    dose: Dose,
    budget: float,
    seed: int,
    chance: random.Random,
) -> list[Row]:
    """What is done to one and the same loop."""
    loop = Loop(nursery, folder)
    found = [
        *rounds(loop, dose.rounds, budget, chance),
        flood(nursery, loop, dose.flood, seed),
    ]
    statuses = loop.end()
    found[-1].notes += [f"{name}: exit status {code}" for name, code in statuses.items() if code]
    return found


@contextmanager
def in_a_domain(logs: Path) -> Iterator[None]:
    """A ROS domain that nobody else uses and that does not leave this machine."""
    before = dict(os.environ)
    with unused_domain() as domain:
        inside = on_this_machine(domain) | {"ROS_LOG_DIR": str(logs)} | UDP_ALONE
        try:
            os.environ.clear()
            os.environ.update(inside)
            yield
        finally:
            os.environ.clear()
            os.environ.update(before)
