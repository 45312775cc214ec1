"""A wire with faults, in user space: for kernels without `tc netem`.

It forwards Ethernet frames between two interfaces and loses, delays and reorders them on the way.
"""

from __future__ import annotations

import heapq
import itertools
import os
import random
import select
import socket
import time
from multiprocessing.connection import Connection

from impairment import NONE

ALL_FRAMES = 3  # ETH_P_ALL
OUTGOING = 4  # PACKET_OUTGOING: this wire's own frames, seen again
LARGEST = 65_536  # bytes
IP, UDP = b"\x08\x00", 17


def run_wire(interfaces: tuple[str, str], control: Connection, seed: int) -> None:
    """Forward until the other end of `control` is closed; from there impairments come."""
    chance = random.Random(seed)
    ends = [socket.socket(socket.AF_PACKET, socket.SOCK_RAW) for _ in interfaces]
    for end, name in zip(ends, interfaces, strict=True):
        end.bind((name, ALL_FRAMES))
        end.setblocking(False)
    other = dict(zip(ends, reversed(ends), strict=True))
    impairment = NONE
    order = itertools.count()
    under_way: list[tuple[float, int, bytes, socket.socket]] = []
    while os.getppid() != 1:
        now = time.monotonic()
        while under_way and under_way[0][0] <= now:
            _, _, frame, end = heapq.heappop(under_way)
            try:
                end.send(frame)
            except OSError:  # the interface is down
                continue
        wait = max(0.0, under_way[0][0] - now) if under_way else 0.1
        select.select([control, *ends], [], [], wait)
        if control.poll():
            impairment = control.recv()
        for source in ends:
            for frame in _frames(source):
                delay = impairment.delay_of_one(chance)
                if delay is not None:
                    due = time.monotonic() + delay
                    heapq.heappush(under_way, (due, next(order), frame, other[source]))


def _frames(end: socket.socket) -> list[bytes]:
    """Those that have come."""
    found: list[bytes] = []
    while True:
        try:
            frame, address = end.recvfrom(LARGEST)
        except BlockingIOError:
            return found
        if address[2] != OUTGOING:
            found.append(_without_checksum(frame))


def _without_checksum(frame: bytes) -> bytes:
    """A frame of UDP over IPv4 says that it has no checksum: the kernel left it to the hardware."""
    if frame[12:14] != IP or frame[23] != UDP:
        return frame
    begin = 14 + 4 * (frame[14] & 0x0F) + 6
    return frame[:begin] + b"\0\0" + frame[begin + 2 :]
