"""The control loop under test: plant, controller, reference and recorder, and who sees them."""

from __future__ import annotations

import shutil
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from nursery import NODES, PERIOD, Child, Nursery, Place
from witness import Witness

PATIENCE = 40.0  # s, for the loop to track
SETPOINTS = {"shape": "sine", "low": 3e-6, "high": 15e-6, "frequency": 0.25}
SETTINGS: dict[str, dict[str, Any]] = {
    "plant_simulator": {},
    "controller": {"setpoint_loss": "return", "setpoint_timeout": 0.06},
    "reference": SETPOINTS,
    "recorder": {},
}


class NotTrackingError(Exception):
    """The loop does not do what it is there for."""


class Loop:
    """The running nodes by name; `place` says where a node's host is, if there are several."""

    def __init__(
        self,
        nursery: Nursery,
        folder: Path,
        *,
        place: Callable[[str], Place | None] = lambda name: None,
        names: tuple[str, ...] = NODES,
        period: float = PERIOD,
        reliable: bool = True,
        settings: dict[str, dict[str, Any]] | None = None,
    ) -> None:
        self._nursery = nursery
        self._folder = folder
        self._place = place
        self._settings = settings or {}
        self._bags = 0
        self.witness = Witness(nursery, place("witness"), period=period, reliable=reliable)
        self.nodes: dict[str, Child] = {}
        for name in names:
            self.start(name)

    def start(self, name: str) -> Child:
        """Start a node, or start it again."""
        settings = {**SETTINGS[name], **self._settings.get(name, {})}
        if name == "recorder":
            shutil.rmtree(self.bag, ignore_errors=True)
            self._bags += 1
            settings["out"] = self.bag
        child = self._nursery.node(name, place=self._place(name), **settings)
        self.nodes[name] = child
        return child

    @property
    def bag(self) -> Path:
        """Where the recorder writes."""
        return self._folder / f"bag_{self._bags}"

    def tracks_since(self, start: float) -> float:
        """When after `start`, s, the setpoint was tracked; NotTrackingError if it never is."""
        found = self.witness.until(lambda: self.witness.tracking_since(start), PATIENCE)
        if found is None:
            raise NotTrackingError(f"no tracking within {PATIENCE:g} s of {start:.3f} s")
        return float(found)

    def tracks(self) -> None:
        """Wait until the setpoint is tracked from now on."""
        self.tracks_since(time.time())

    def dead(self) -> list[str]:
        """Nodes that have ended, with their status."""
        status = {name: child.status for name, child in self.nodes.items()}
        return [f"{name} ({code})" for name, code in status.items() if code is not None]

    def end(self) -> dict[str, int | None]:
        """End all nodes in order; their exit status."""
        ends: dict[str, int | None] = {}
        for name in ("reference", "controller", "recorder", "plant_simulator"):
            if name in self.nodes:
                self.nodes[name].send(signal.SIGTERM)
                ends[name] = self.nodes[name].wait(10.0)
        self.witness.process.kill()
        return ends
