"""What a network does to packets."""

from __future__ import annotations

import random
from dataclasses import dataclass


@dataclass(frozen=True)
class Impairment:
    """Each packet is lost with a probability, or delayed; some overtake those before them."""

    name: str
    loss: float = 0.0  # probability
    delay: float = 0.0  # s
    jitter: float = 0.0  # s, of the delay, both ways
    reorder: float = 0.0  # probability of going at once

    def netem(self) -> list[str]:
        """As arguments of `tc qdisc ... netem`."""
        words = ["loss", f"{100 * self.loss:g}%"]
        if self.delay:
            words += ["delay", f"{1e6 * self.delay:g}us", f"{1e6 * self.jitter:g}us"]
        if self.reorder:
            words += ["reorder", f"{100 * self.reorder:g}%"]
        return words

    def delay_of_one(self, chance: random.Random) -> float | None:
        """The delay of one packet, s; None if it is lost."""
        if chance.random() < self.loss:
            return None
        if chance.random() < self.reorder:
            return 0.0
        return self.delay + chance.uniform(-self.jitter, self.jitter)


NONE = Impairment("no fault")
CUT = Impairment("cut link", loss=1.0)
