"""Tells feedback that can be used from feedback that cannot, and notices when it is lost.

Two clocks are compared that need not agree: the stamps' and this process's monotonic one. What
their difference was at best in the last seconds is the fastest way from the plant to here; a sample
that took `limit` longer is too old. Stamps that come from the future, or run backwards, are not
believed either, unless several in a row agree: then somebody has set the clock, or the plant was
started again, and time goes on from there. So it does after a pause of several windows: by then
the two clocks may have drifted apart, and several in a row tell what the fastest way is now.
"""

from __future__ import annotations

import enum
import math

from microgripper_control.nodes.new_time import NewTime
from microgripper_control.nodes.silence import Silence

WINDOW = 5.0  # s; the fastest way is looked for in the last one or two of these,
LONG_PAUSE = 2.0 * WINDOW  # without any sample: it is looked for anew


class Verdict(str, enum.Enum):
    """On one sample."""

    FRESH = "ok"
    UNUSABLE = "no finite position and effort of the joint"
    REPEATED = "a stale sample repeated"
    LATE = "samples too old"
    OUT_OF_TIME = "stamps from another time"


class FeedbackWatch:
    """Lost is feedback of which nothing fresh was heard for `limit`, s.

    `counts` are the samples of each verdict, `losses` the times it was lost, `jumps` the times a
    new time was accepted, and `missed` the ticks that no sample came of.
    """

    def __init__(self, limit: float, sample_period: float) -> None:
        self.limit = limit
        self._period = sample_period
        self._silence = Silence(limit)
        self.counts = dict.fromkeys(Verdict, 0)
        self.losses = self.jumps = self.missed = 0
        self.lost = False
        self.resumes = False  # whether the newest fresh sample came after a loss or a gap
        self._newest = Verdict.FRESH  # the newest verdict since the last look
        self._reason = ""
        self._stamp = 0  # of the newest fresh sample, ns
        self._heard = -math.inf  # when it came, s
        self._came = -math.inf  # when the newest sample of all came, s
        self._fastest = _Fastest()
        self._other = NewTime(limit)

    @property
    def state(self) -> str:
        """In words."""
        return f"lost: {self._reason}" if self.lost else "ok"

    @property
    def begun(self) -> bool:
        """Whether anything fresh was heard."""
        return self._heard > -math.inf

    @property
    def left(self) -> float:
        """Time until it is lost if nothing comes, s."""
        return math.inf if self.lost else self._silence.left

    def age(self, now: float) -> float:
        """How long the newest fresh sample has been here at `now`, s."""
        return now - self._heard

    def take(self, stamp: int, finite: bool, now: float) -> Verdict:
        """Judge a sample with its stamp, ns, that came at `now`, s."""
        verdict = self._newest = self._judge(stamp, finite, now)
        self.counts[verdict] += 1
        if verdict is Verdict.FRESH:
            gap = now - self._heard
            self.resumes = self.lost or gap > self.limit
            if not self.resumes:
                self.missed += max(0, round((stamp - self._stamp) * 1e-9 / self._period) - 1)
            self.lost = False
            self._stamp, self._heard = stamp, now
            self._silence.heard(now)
        return verdict

    def take_any(self, finite: bool) -> Verdict:
        """Judge a sample where its stamp says nothing of the time: in lockstep."""
        verdict = Verdict.FRESH if finite else Verdict.UNUSABLE
        self.counts[verdict] += 1
        return verdict

    def is_lost(self, now: float) -> bool:
        """Look whether it is lost at `now`, s."""
        if not self.lost and self._silence.is_over(now):
            self.lost = True
            self.losses += 1
            self._reason = "none comes" if self._newest is Verdict.FRESH else self._newest.value
        return self.lost

    def _judge(self, stamp: int, finite: bool, now: float) -> Verdict:
        if not finite:
            return Verdict.UNUSABLE
        if now - self._came > LONG_PAUSE:
            self._fastest = _Fastest()
        self._came = now
        offset = now - stamp * 1e-9
        if self.begun:
            if stamp == self._stamp:
                return Verdict.REPEATED
            age = offset - self._fastest.offset
            if age > self.limit and stamp > self._stamp:
                return Verdict.LATE
            if stamp < self._stamp or age < -self.limit:
                if not self._other.agrees(stamp, offset):
                    return Verdict.OUT_OF_TIME
                self.jumps += math.isfinite(self._fastest.offset)
                self._stamp = stamp  # so that no tick counts as missed
                self._fastest = _Fastest()
        self._other.forget()
        self._fastest.note(offset, now)
        return Verdict.FRESH


class _Fastest:
    """The smallest offset, s, of the last one or two windows; infinite if none was noted."""

    def __init__(self) -> None:
        self._before = self._present = math.inf
        self._since = -math.inf

    def note(self, offset: float, now: float) -> None:
        if now - self._since > WINDOW:
            self._before, self._present, self._since = self._present, math.inf, now
        self._present = min(self._present, offset)

    @property
    def offset(self) -> float:
        return min(self._before, self._present)
