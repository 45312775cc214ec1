"""The newest samples of a rig, kept with their stamps for a diagnosis."""

from __future__ import annotations

from collections import deque
from statistics import median

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.core.sliding import Sliding
from microgripper_control.nodes.pacing import SampleNumber, longest_pause
from microgripper_control.recordings.clean import cleaned
from microgripper_control.recordings.clock import on_uniform_clock
from microgripper_control.recordings.samples import Samples

FEWEST, MOST = 100, 1000  # newest intervals that tell the rate, whatever was missed meanwhile


class KeptSamples:
    """Those of the last `length` s of a clock of `rate`, Hz.

    Time that runs backwards and a long pause are new beginnings, counted in `restarts`: what was
    before is forgotten. Samples whose stamp is not believed, yet, are left out and `disbelieved`.
    """

    def __init__(self, rate: float, length: float) -> None:
        self._rate = rate
        self._length = length
        self._pause = longest_pause(rate)
        self._rows = Sliding(round(length * rate) + 1, 3)  # time, s, voltage, displacement
        self._intervals: deque[float] = deque(maxlen=MOST)  # s
        self._first = self._newest = 0  # stamps, ns
        self._number = SampleNumber(rate)
        self.count = 0
        self.missing = 0  # ticks of the clock without a sample
        self.restarts = self.disbelieved = 0

    @property
    def took_it(self) -> bool:
        """Whether the last sample was kept."""
        return self._number.believed

    @property
    def tick(self) -> int:
        """The number of the newest sample since the beginning."""
        return self._number.newest

    @property
    def interval(self) -> float:
        """Between two samples, s: the median; the expected one while there are few."""
        return median(self._intervals) if len(self._intervals) >= FEWEST else 1.0 / self._rate

    @property
    def duration(self) -> float:
        """From the oldest sample to the newest, s."""
        time = self._columns[0]
        return float(time[-1] - time[0]) if len(time) else 0.0

    def add(self, stamp: int, voltage: float, displacement: float) -> bool:
        """Keep a sample with its stamp, ns, V and m; whether it is a new beginning."""
        before, number = self.tick, self._number.of(stamp)
        if not self.took_it:
            self.disbelieved += 1
            return False
        interval = (stamp - self._newest) * 1e-9
        begins = self.count > 0 and not 0.0 <= interval <= self._pause
        if begins:
            self.restarts += 1
        if begins or not self.count:
            self._begin(stamp)
        else:
            self._intervals.append(interval)
            self.missing += max(0, number - before - 1)
        self._newest = stamp
        self.count += 1
        self._rows.append(((stamp - self._first) * 1e-9, voltage, displacement))
        return begins

    def recording(self) -> Recording:
        """The samples on one clock; MicrogripperError where they are too few or on none."""
        time, voltage, displacement = self._columns
        samples = Samples(time - time[:1], voltage, displacement, origin=0.0)
        return cleaned(on_uniform_clock("joint_states", samples))

    def _begin(self, stamp: int) -> None:
        self._first = stamp
        self._number = SampleNumber(self._rate)
        self._number.of(stamp)
        self._rows.clear()
        self._intervals.clear()

    @property
    def _columns(self) -> Array:
        columns = self._rows.columns
        time = columns[0]
        if not len(time):
            return columns
        newest: Array = columns[:, time > time[-1] - self._length - 0.5 / self._rate]
        return newest
