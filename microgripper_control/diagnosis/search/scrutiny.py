"""How far an effect is worth being fitted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from microgripper_control.diagnosis.data.noise import removable
from microgripper_control.effects.base import Values

STARTS, MOST_STARTS = 2, 4  # best first guesses that are fitted


class Scrutiny(NamedTuple):
    """How far an effect is worth being fitted."""

    samples: int  # on which a costly one is fitted first
    starts: int = MOST_STARTS
    hopeless: float = math.inf  # m: what leaves more is fitted no further
    known: float = math.inf  # m, what the best of the others leaves
    found_alone: Sequence[Values] = ()  # what an effect that joins others was by itself

    def where_shown(self, base: float, shown: float) -> Scrutiny:
        """The same for a part that leaves `shown`, m, where the whole leaves the base: its share.

        Stretches with a zero of their own hide some of a gap. What leaves as great a share of what
        they show as is hopeless on the whole is as hopeless there.
        """
        if not base > self.hopeless:
            return self
        share = removable(self.hopeless, self.known) / removable(base, self.known)
        return self._replace(hopeless=math.hypot(self.known, share * removable(shown, self.known)))
