"""The controller: four modes, one answer a tick.

    open_loop     the command is a voltage and goes out
    feedforward   inverse model of the setpoint
    pid           PID on setpoint minus displacement
    cascade       both: the PID corrects what the feedforward leaves

Each answer passes the voltage guard. Whenever the law changes (start, mode, identified values) the
voltage goes on from where it is: the PID's integral takes over the difference, or, in the modes
without one, it fades at the guard's ramp rate.

In cascade the displacement is compared with what was asked of it two ticks and the plant's dead
time before (`_asked`), not with the setpoint of the same tick: a PID that sees a step before the
plant can have answered it acts a second time on what the feedforward already does (54 % overshoot
on the plant it knows, against 0.1 %; with 3 ms of dead time left out, 25 %). Since the feedforward
looks ahead by two ticks, the two references are else the same for smooth motion. The feedforward's
model then follows the feedforward's own voltage: made to follow the sum it would reverse its
hysteresis against each correction.
"""

from __future__ import annotations

import enum
import math
from collections import deque

from microgripper_control.control.feedforward import Inverse, InverseKind, make_inverse
from microgripper_control.control.identified import Identified
from microgripper_control.control.limits import VoltageGuard, VoltageLimits
from microgripper_control.control.lookahead import Lookahead
from microgripper_control.control.pid import Pid, PidGains
from microgripper_control.control.tuning import default_gains
from microgripper_control.core.errors import MicrogripperError


class Mode(str, enum.Enum):
    """The control laws by name."""

    OPEN_LOOP = "open_loop"
    FEEDFORWARD = "feedforward"
    PID = "pid"
    CASCADE = "cascade"


class Controller:
    """Answers each sample of the plant with a voltage.

    `clamped`, `limited` and `refused` count the ticks whose setpoint was out of reach, whose answer
    the guard's limits cut, and whose command was not finite.
    """

    def __init__(
        self,
        identified: Identified,
        sample_period: float,
        *,
        limits: VoltageLimits | None = None,
        gains: PidGains | None = None,
        mode: Mode = Mode.CASCADE,
        inverse: InverseKind = InverseKind.EXACT,
    ) -> None:
        if not (math.isfinite(sample_period) and sample_period > 0.0):
            raise MicrogripperError(f"controller: sample period {sample_period} s must be positive")
        if limits is None:
            low, high = identified.voltage_range
            limits = VoltageLimits(low=low, high=high, safe=min(max(0.0, low), high))
        authority = max(abs(limits.low), abs(limits.high), limits.high - limits.low)
        self.guard = VoltageGuard(limits, sample_period)
        self.forget_counts()
        self._period = sample_period
        self._mode = mode
        self._kind = inverse
        self._inverse = self._inverse_of(identified)
        self._lookahead = Lookahead()
        self._pid = Pid(gains or default_gains(identified, sample_period), sample_period, authority)
        self._fade_step = limits.ramp_rate * sample_period
        self._difference = 0.0  # V, between the answer and the law's wish
        self._joining = True  # at the next step the law takes over from what went before
        self._unasked = True  # of the displacement, so far, by the law at work
        self._command = math.nan  # the last good one; none yet
        self._ahead = self._ticks_ahead(identified)
        self._asked = deque([math.nan] * self._ahead)  # of x, m, at this tick and those after it

    @property
    def mode(self) -> Mode:
        """The law at work."""
        return self._mode

    @property
    def gains(self) -> PidGains:
        """The PID's gains."""
        return self._pid.gains

    @property
    def reach(self) -> tuple[float, float]:
        """Smallest and largest setpoint taken as it is, m, as the sensor reads it."""
        return self._lowest + self._zero, self._highest + self._zero

    def set_gains(self, gains: PidGains) -> None:
        """Change the PID's gains without a jump."""
        self._pid.change_gains(gains)

    def set_mode(self, mode: Mode) -> None:
        """Change the law without a jump.

        Between open loop and the others the command changes its meaning from voltage to
        displacement: the old one is dropped, and the voltage held until a new one comes.
        """
        if mode is self._mode:
            return
        if Mode.OPEN_LOOP in (mode, self._mode):
            self._command = math.nan
        self._mode = mode
        self._law_changed()

    def set_identified(self, identified: Identified) -> None:
        """Change the identified values without a jump; the PID's gains stay."""
        inverse = self._inverse_of(identified)
        inverse.take_over(self._inverse)
        self._inverse = inverse
        self._ahead = self._ticks_ahead(identified)
        self._law_changed()

    def start(self, reported: float) -> float:
        """Begin, or begin again, at the voltage that the plant reports, V. Returns it, in range.

        Raises MicrogripperError if it is not finite.
        """
        self._command = math.nan
        return self.resume(reported, math.inf)

    def forget_counts(self) -> None:
        """Count from here on."""
        self.clamped = self.limited = self.refused = 0

    def resume(self, reported: float, elapsed: float) -> float:
        """Go on at the voltage that the plant reports after it was out of sight; returns it, V.

        The command stays. `elapsed` is the time since the last voltage went out, s, after which
        the rate allows only so much. Raises MicrogripperError if the report is not finite.
        """
        voltage = self.guard.start(reported, elapsed)
        self._law_changed()
        return voltage

    def lose(self, samples: int) -> None:
        """Say that so many samples were lost since the last step."""
        self._pid.lose(samples)

    def step(self, command: float | None, displacement: float, applied: float) -> float:
        """The voltage u[k+1], V, for what was read at tick k.

        `command` is the setpoint, m, or in open loop the voltage, V; None where no new one came.
        `displacement` is what the sensor reads, m, `applied` u[k], V, as the plant reports them.
        Samples that are not finite change nothing: the last good command, correction or answer
        stands in. The voltage is held until there is a command.
        """
        displacement -= self._zero
        if self._joining or self._mode is not Mode.CASCADE:
            known = applied if math.isfinite(applied) else self.guard.voltage
            self._inverse.applied(self.guard.limits.clip(known))
        if command is not None and math.isfinite(command):
            self._command = command
        elif command is not None:
            self.refused += 1
        if math.isnan(self._command):
            return self.guard.voltage
        if self._mode is Mode.CASCADE:
            return self._cascade(displacement)
        if self._mode is Mode.OPEN_LOOP:
            return self._fade(self._command)
        if self._mode is Mode.FEEDFORWARD:
            return self._fade(self._inverse.step(self._target()))
        error = self._reachable(self._command) - displacement
        return self._issue(self._correct(error, displacement, 0.0), self._pid.bounded)

    def _cascade(self, displacement: float) -> float:
        target = self._target()
        forward = self._inverse.step(target)
        asked = self._asked.popleft()
        error = 0.0 if math.isnan(asked) else asked - displacement
        if self._unasked and not self._joining and math.isfinite(asked - displacement):
            self._unasked = False  # the first error goes on from the answer as it is, too
            self._pid.join(self._pid.output, error, displacement)
        correction = self._correct(error, displacement, forward)
        self._asked.append(target)
        if self._pid.bounded:
            # The plant gets less than was asked of it: so does the model, and so does the PID.
            integral = self._pid.integral
            lowest, highest = self.guard.lowest - integral, self.guard.highest - integral
            self._inverse.applied(self.guard.limits.clip(min(max(forward, lowest), highest)))
            self._asked[-1] = self._inverse.displacement
        else:
            self._inverse.applied(forward)
        return self._issue(forward + correction, self._pid.bounded)

    def _target(self) -> float:
        """The reachable setpoint for the displacement that this answer moves."""
        ahead = self._lookahead.step(self._reachable(self._command))
        low, high = self._lowest, self._highest
        return low if ahead < low else high if ahead > high else ahead

    def _reachable(self, setpoint: float) -> float:
        """The displacement x, m, nearest to the one at which the sensor reads the setpoint."""
        wanted = setpoint - self._zero
        if self._lowest <= wanted <= self._highest:
            return wanted
        self.clamped += 1
        return min(max(wanted, self._lowest), self._highest)

    def _correct(self, error: float, displacement: float, forward: float) -> float:
        """The PID's voltage beside `forward`, V, within what the guard will let out."""
        if self._joining:
            self._joining = False
            return self._pid.join(self.guard.voltage - forward, error, displacement)
        low, high = self.guard.lowest - forward, self.guard.highest - forward
        return self._pid.step(error, displacement, low, high)

    def _fade(self, wanted: float) -> float:
        """Answer with `wanted`, V, and what is left of the difference at the change of the law."""
        inside = self.guard.limits.clip(wanted)
        self.clamped += self._mode is Mode.OPEN_LOOP and inside != wanted
        if self._joining:
            self._joining = False
            self._difference = self.guard.voltage - inside
        else:
            self._difference -= min(max(self._difference, -self._fade_step), self._fade_step)
        return self._issue(inside + self._difference, inside != wanted)

    def _issue(self, wanted: float, bounded: bool = False) -> float:
        answer = self.guard.step(wanted)
        if bounded or answer != wanted:
            self.limited += 1
        return answer

    def _inverse_of(self, identified: Identified) -> Inverse:
        limits = self.guard.limits
        low, high = identified.voltage_range
        if not low <= limits.low < limits.high <= high:
            raise MicrogripperError(
                f"controller: limits {limits.low:g} .. {limits.high:g} V exceed the model's "
                f"voltage range {low:g} .. {high:g} V"
            )
        self._zero = identified.zero
        self._lowest, self._highest = identified.reach(limits.low, limits.high)
        return make_inverse(self._kind, identified, (limits.low, limits.high), self._period)

    def _ticks_ahead(self, identified: Identified) -> int:
        """How many ticks after the setpoint the displacement shows the answer to it."""
        return 2 + round(identified.dead_time / self._period)

    def _law_changed(self) -> None:
        self._joining = self._unasked = True
        self._difference = 0.0
        self._asked = deque([math.nan] * self._ahead)
        self._lookahead.reset()
        self._inverse.restart()
