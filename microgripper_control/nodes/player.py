"""Plays a recording back, in one of two paces.

- `recorded`: publishes the messages of a bag as they were published, `rate` times as fast.
- `samples`: answers each sample of a simulated plant with the voltage that followed it in the
  recording, so that the plant gets the very voltages of the rig, sample by sample, also in
  lockstep. It takes the controller's place, and the recording may be a CSV.
"""

from __future__ import annotations

import math
from pathlib import Path

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.parameters import Parameter
from microgripper_control.nodes import topics
from microgripper_control.nodes.health import Health
from microgripper_control.nodes.parameters import (
    declare_number,
    declare_path,
    declare_text,
    declare_texts,
)
from microgripper_control.nodes.playing import AsAnswers, AsRecorded, Playing
from microgripper_control.nodes.shell import POLL, Shell, run

RECORDED, SAMPLES = "recorded", "samples"
DISCOVERY, SETTLING = 3.0, 0.5  # s: for finding who listens, and for them to find the player
RATE = Parameter("rate", "1", 1.0, 1e-3, 1e3, "pace recorded: times as fast as it was")


class Player(Shell):
    """See the module."""

    def __init__(self) -> None:
        super().__init__("player")
        self._recording = declare_path(self, "recording", "", "bag or CSV to play")
        self._pace = declare_text(
            self,
            "pace",
            RECORDED,
            "as recorded, or one voltage for each sample of the plant",
            choices=(RECORDED, SAMPLES),
            read_only=True,
        )
        names = declare_texts(self, "topics", [], "pace recorded: topics to play; none: all")
        self._wanted = [self.resolve_topic_name(name, only_expand=True) for name in names]
        self._partners = declare_texts(
            self,
            "partners",
            [],
            "names of the nodes that must get what is played; none: whoever is found in "
            f"{DISCOVERY:g} s",
        )
        self._speed = declare_number(self, RATE, read_only=True)
        self._playing: Playing
        self._begun = False
        self._since = math.inf  # when it was first ready to begin, s,
        self._heard = math.inf  # and since when all that it plays is listened to

    def begin(self) -> None:
        """Open the recording."""
        if self._recording == Path():
            raise MicrogripperError("recording is empty; name a bag, -p recording:=PATH")
        if self._pace == SAMPLES:
            self._playing = AsAnswers(self, self._recording)
        else:
            self._playing = AsRecorded(self, self._recording, self._wanted, self._speed)

    def work(self, now: float) -> float:
        """As `Shell` says."""
        if not self._begun:
            self._since = min(self._since, now)
            self._begun = not self._missing() and (bool(self._partners) or self._is_found_out(now))
            return POLL
        wait = self._playing.work(now)
        if self._playing.is_over:
            self.finish(f"{self._playing.played} messages played")
        return wait

    def leave(self) -> None:
        """Stay until everything has arrived."""
        if self.outcome is not None:
            topics.await_delivery(self._playing.publishers)

    def _missing(self) -> list[str]:
        return [
            name
            for publisher in self._playing.publishers
            for name in topics.missing_partners(self, publisher, self._partners)
        ]

    def _is_found_out(self, now: float) -> bool:
        """Whether those who listen are known, and have had the time to know of the player, too."""
        heard = all(one.get_subscription_count() for one in self._playing.publishers)
        self._heard = min(self._heard, now) if heard else math.inf
        return now > min(self._heard + SETTLING, self._since + DISCOVERY)

    def health(self, elapsed: float) -> Health:
        """As `Shell` says."""
        if not self._begun:
            missing = dict.fromkeys(self._missing()) or ["somebody who listens"]
            return Health("waiting for " + ", ".join(missing))
        return Health(values={"messages played": self._playing.played})


def main() -> None:
    """Run the node."""
    run(Player)


if __name__ == "__main__":
    main()
