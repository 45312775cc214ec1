"""The control law's exchange with its plant: who answers what, from which voltage on.

In wall time nothing is taken for granted. Samples that are stale, late or wild are not answered;
without fresh ones the voltage goes to the safe one; and whenever the plant was out of sight, or did
not do as it was told, the law begins again at the voltage that the plant reports, at the ramp rate
until the plant is seen to follow. In lockstep every sample is answered.
"""

from __future__ import annotations

import math
import time

from microgripper_control.control.controller import Controller
from microgripper_control.nodes.applied_watch import AppliedWatch
from microgripper_control.nodes.feedback_watch import FeedbackWatch, Verdict
from microgripper_control.nodes.pairing import Paired
from microgripper_control.nodes.stamp_rate import StampRate
from microgripper_control.nodes.voltage_output import Descent, VoltageOutput


class Exchange:
    """Between a controller, the samples of a plant, and the way out for voltages."""

    def __init__(
        self,
        controller: Controller,
        output: VoltageOutput,
        feedback: FeedbackWatch,
        applied: AppliedWatch,
        *,
        sample_period: float,
        lockstep: bool,
    ) -> None:
        self.feedback = feedback
        self.applied = applied
        self.stamps = StampRate(1.0 / sample_period)
        self._controller = controller
        self._output = output
        self._period = sample_period
        self._lockstep = lockstep
        self._started = self._resumed = False
        self._descent: Descent | None = None

    def meets(self, stamp: int, displacement: float, voltage: float, now: float) -> bool:
        """Whether a sample, stamped at `stamp`, ns, and come at `now`, s, is to be answered."""
        finite = math.isfinite(displacement) and math.isfinite(voltage)
        if self._lockstep:
            verdict = self.feedback.take_any(finite)
        else:
            before = self.feedback.missed
            verdict = self.feedback.take(stamp, finite, now)
            self._controller.lose(self.feedback.missed - before)
        if verdict is Verdict.UNUSABLE:  # answered with what is known, as long as that is fresh
            return self._started and not self.feedback.lost
        if verdict is not Verdict.FRESH:
            return False
        self.stamps.note(stamp)
        self._descent = None
        if not self._started:
            self._started = True
            self._controller.start(voltage)
            self.applied.begin(voltage)
        elif not self._lockstep and (self.feedback.resumes or not self.applied.follows(voltage)):
            self._resume(voltage, self._output.elapsed)
        return True

    def answer(self, paired: Paired, *, returns: bool) -> bool:
        """Answer a sample, by the control law or, where it `returns`, towards the safe voltage.

        One that is too old by now is not answered; whether it was.
        """
        guard = self._controller.guard
        if not self._lockstep:
            if self.feedback.age(time.monotonic()) > self.feedback.limit:
                return False  # it has waited while this process stood still
            guard.passed(self._allowed_time(returns=returns))
        if returns:
            guard.ramp_to(guard.limits.safe)
        else:
            self._controller.step(paired.setpoint, paired.displacement, paired.voltage)
        self._send()
        return True

    def returned(self) -> None:
        """Let the control law take over again after answers towards the safe voltage."""
        self._resume(self._controller.guard.voltage, 0.0)

    def descend(self, now: float) -> float:
        """Go towards the safe voltage without samples; time until the next step is due, s."""
        if self._descent is None:
            self._descent = Descent(self._output, self._controller.guard, self._period)
        return self._descent.work(now)

    def end(self) -> None:
        """Bring the voltage down, if there ever was one, before nobody can any more."""
        if self._started and not self._lockstep:
            Descent(self._output, self._controller.guard, self._period).finish()

    def _resume(self, voltage: float, elapsed: float) -> None:
        self._controller.resume(voltage, elapsed)
        self.applied.begin(voltage)
        self._resumed = True

    def _allowed_time(self, *, returns: bool) -> float:
        """For how much time the rate allows a change, s; the ramp's own is slow enough."""
        if self._resumed:  # that has used it up
            return 0.0
        if returns:
            return self._output.elapsed
        limits = self._controller.guard.limits
        share = 1.0 if self.applied.proved else limits.ramp_rate / limits.rate
        return self._output.elapsed * share

    def _send(self) -> None:
        self._resumed = False
        now = self._output.send(self._controller.guard)
        self.applied.sent(self._controller.guard.voltage, now)
