"""Two hosts on this machine: network namespaces with a link between them that can be impaired.

The link is a veth pair with `tc netem` where the kernel has that, else two pairs and a wire in user
space (`wire`) between them. It needs the rights of root.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from contextlib import ExitStack
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from types import TracebackType

from impairment import NONE, Impairment
from nursery import Nursery, Place
from wire import run_wire

HOSTS = ("rig", "desk")
ADDRESSES = {"rig": "10.199.7.1/24", "desk": "10.199.7.2/24"}
CLONE_NEWNET = 0x40000000


class NotHereError(Exception):
    """This machine does not allow it; the message says why."""


class Hosts:
    """A context; raises NotHereError on entry. `link` says of what kind the link is."""

    def __init__(self, nursery: Nursery, seed: int) -> None:
        self._nursery = nursery
        self._seed = seed
        self._prefix = f"mg{os.getpid()}"
        self._stack = ExitStack()
        self._wire: Connection | None = None
        self.link = ""

    def __enter__(self) -> Hosts:
        if os.geteuid() != 0:
            raise NotHereError("not root")
        for tool in ("ip", "tc"):
            if shutil.which(tool) is None:
                raise NotHereError(f"no `{tool}`: apt-get install iproute2")
        with self._stack:
            for host in HOSTS:
                self._add(host)
            self._connect()
            self._stack = self._stack.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stack.close()

    def place(self, host: str) -> Place:
        """What a process does to be on a host; all it sends leaves by the network."""
        path = f"/run/netns/{self._name(host)}"

        def enter() -> None:
            _enter(path)
            os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SUBNET"
            os.environ["FASTDDS_BUILTIN_TRANSPORTS"] = "UDPv4"
            os.environ.pop("FASTRTPS_DEFAULT_PROFILES_FILE", None)  # that stays on one machine

        return enter

    def impair(self, impairment: Impairment) -> None:
        """Impair the link, in both directions, until it is impaired otherwise."""
        if self._wire is not None:
            self._wire.send(impairment)
            return
        for host in HOSTS:
            _run(
                *("tc", "-n", self._name(host), "qdisc", "replace", "dev", "eth0", "root"),
                *("netem", *impairment.netem()),
            )

    def _name(self, host: str) -> str:
        return f"{self._prefix}{host}"

    def _add(self, host: str) -> None:
        name = self._name(host)
        _run("ip", "netns", "add", name)
        self._stack.callback(_run, "ip", "netns", "del", name)
        _run("ip", "-n", name, "link", "set", "lo", "up")

    def _connect(self) -> None:
        rig, desk = map(self._name, HOSTS)
        pair = ("link", "add", "eth0", "type", "veth", "peer", "name", "eth0", "netns")
        _run("ip", "-n", rig, *pair, desk)
        self._up()
        try:
            self.impair(NONE)
            self.link = "tc netem"
        except NotHereError:
            _run("ip", "-n", rig, "link", "del", "eth0")
            self._connect_by_wire()
            self.link = "a wire in user space; this kernel has no netem"

    def _connect_by_wire(self) -> None:
        self._add("wire")
        wire = self._name("wire")
        ends = ("to_rig", "to_desk")
        for host, end in zip(HOSTS, ends, strict=True):
            pair = ("link", "add", "eth0", "type", "veth", "peer", "name", end, "netns", wire)
            _run("ip", "-n", self._name(host), *pair)
            _run("ip", "-n", wire, "link", "set", end, "up")
        self._up()
        self._wire, theirs = Pipe()
        path = f"/run/netns/{wire}"
        child = self._nursery.fork(
            "wire", lambda: run_wire(ends, theirs, self._seed), place=lambda: _enter(path)
        )
        self._stack.callback(child.kill)

    def _up(self) -> None:
        for host in HOSTS:
            name = self._name(host)
            _run("ip", "-n", name, "addr", "add", ADDRESSES[host], "dev", "eth0")
            _run("ip", "-n", name, "link", "set", "eth0", "up")
            _run("ip", "-n", name, "route", "add", "224.0.0.0/4", "dev", "eth0")


def _run(*words: str) -> None:
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode:
        raise NotHereError(f"{' '.join(words)}: {done.stderr.strip()}")


def _enter(path: str) -> None:
    """Enter a network namespace."""
    libc = ctypes.CDLL(None, use_errno=True)
    with open(path, "rb") as file:  # noqa: PTH123 (a file descriptor, not a file's content)
        if libc.setns(file.fileno(), CLONE_NEWNET):
            raise OSError(ctypes.get_errno(), "setns")
