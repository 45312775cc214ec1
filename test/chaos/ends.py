"""Nodes asked to end at random moments, from their first line in the log on."""

from __future__ import annotations

import random
import signal
import time

from nursery import NODES, Child, Nursery
from table import Row

AT_ONCE = 4  # nodes
LATEST = 1.0  # s after its start
PATIENCE = 20.0  # s
CLEAN_END = 5.0  # s, of which reaching the safe voltage takes a tenth


def ends(nursery: Nursery, count: int, chance: random.Random) -> Row:
    """So many SIGTERMs; each has to end in exit status 0, whatever the node was doing."""
    row = Row("SIGTERM at any moment")
    while row.injected < count:
        names = [chance.choice(NODES) for _ in range(min(AT_ONCE, count - row.injected))]
        nodes = [
            nursery.node(name, **_settings(name, row.injected + k)) for k, name in enumerate(names)
        ]
        for node in nodes:
            _begun(node)
        born = time.monotonic()
        moments = sorted((chance.uniform(0.0, LATEST), k) for k in range(len(nodes)))
        for moment, k in moments:
            time.sleep(max(0.0, born + moment - time.monotonic()))
            nodes[k].send(signal.SIGTERM)
        for node in nodes:
            row.injected += 1
            begin = time.monotonic()
            status = node.wait(CLEAN_END)
            row.survived += status == 0
            row.recoveries.append(time.monotonic() - begin)
            if status != 0:
                row.failed(f"{node.name}: exit status {status}: {node.log.read_text()[-300:]}")
                node.kill()
    return row


def _begun(node: Child) -> None:
    """Wait for the first line: before, there is no node yet that could end in order."""
    end = time.monotonic() + PATIENCE
    while "starting" not in node.log.read_text() and time.monotonic() < end:
        time.sleep(0.002)


def _settings(name: str, number: int) -> dict[str, str]:
    return {"out": f"ended_{number}"} if name == "recorder" else {}
