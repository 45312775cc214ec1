"""The samples of a rig as they come, with the model beside them, and what is to be said of both."""

from __future__ import annotations

import math

from microgripper_control.core.quantities import quantity
from microgripper_control.diagnosis.running_gap import Reading, RunningGap, Watch
from microgripper_control.nodes.health import Health, Level
from microgripper_control.nodes.kept_samples import KeptSamples
from microgripper_control.plant.model import Model

STALE = 1.0  # s without a sample, at least 10 sample periods
OTHER_RATE = 0.05  # of the sample rate: samples that are off by more come at another one


class LiveComparison:
    """Compares the samples of a rig, of which there are `rate` a second, with a model.

    The gap is taken over `gap_window` s; the samples of the last `kept` s are at hand. `now` is
    always in s, of a clock that does not jump.
    """

    def __init__(
        self, model: Model, rate: float, gap_window: float, kept: float, now: float
    ) -> None:
        self._rate = rate
        self._gap_window = gap_window
        self._patience = max(STALE, 10.0 / rate)
        self._came = now  # when the newest sample did
        self._unusable = self._unusable_before = 0
        self.samples = KeptSamples(rate, kept)
        self.use(model)

    def use(self, model: Model) -> None:
        """Compare with another model from now on."""
        RunningGap(model, 1.0 / self._rate, self._gap_window).sample(0, 0.0, 0.0)  # compiles
        self._running = RunningGap(model, 1.0 / self._rate, self._gap_window)
        self._watch = Watch()
        self._reading: Reading | None = None

    def take(self, stamp: int, voltage: float, displacement: float, now: float) -> None:
        """Take a sample with its stamp, ns, V and m."""
        self._came = now
        if not math.isfinite(voltage + displacement):
            self._unusable += 1
            return
        if self.samples.add(stamp, voltage, displacement):
            self._running.restart()
        if self.samples.took_it:
            self._running.sample(self.samples.tick, voltage, displacement)

    def read(self, ratio: float, least: float, now: float) -> Reading | None:
        """The newest window, judged as `Watch` says; None where there is none."""
        self._reading = None if self._waited(now) else self._running.reading()
        if self._reading is not None:
            self._watch.judge(self._reading, ratio, least)
        return self._reading

    def health(self, now: float) -> Health:
        """What to report."""
        waited, samples = self._waited(now), self.samples
        unusable = self._unusable > self._unusable_before
        self._unusable_before = self._unusable
        values: dict[str, object] = {
            "samples": samples.count,
            "samples missing": samples.missing,
            "samples unusable": self._unusable,
            "samples of another time": samples.disbelieved,
            "new beginnings": samples.restarts,
            "kept for a diagnosis, s": samples.duration,
        }
        if self._reading is not None:
            values["gap, m"] = self._reading.gap
            values["noise floor, m"] = self._reading.noise_floor
            values["gap in noise floors"] = self._reading.ratio
        if unusable:
            return Health("joint_states without a finite position and effort", Level.WARN, values)
        if not samples.count:
            return Health("waiting for joint_states", Level.STALE, values)
        if waited:
            message = f"no joint_states for {waited:.0f} s"
            return Health(message, Level.STALE, values, cause="no joint_states")
        if abs(samples.interval * self._rate - 1.0) > OTHER_RATE:
            found = f"{1.0 / samples.interval:.4g} Hz" if samples.interval else "one instant"
            message = f"joint_states come at {found}, not at sample_rate, {self._rate:g} Hz"
            return Health(message, Level.WARN, values, cause="joint_states at another rate")
        return self._verdict(values)

    def _verdict(self, values: dict[str, object]) -> Health:
        judged = self._watch.judged
        if judged is None or self._reading is None:
            return Health("warming up: the rig has to move for a while", Level.OK, values)
        numbers = (
            f"gap {quantity(judged.gap, 'm')}, noise floor {quantity(judged.noise_floor, 'm')}, "
            f"{judged.ratio:.1f} times"
        )
        if not self._watch.holds:
            cause = "the model no longer holds"
            return Health(f"{cause}: {numbers}", Level.WARN, values, cause)
        return Health(f"the model holds: {numbers}", Level.OK, values, "the model holds")

    def _waited(self, now: float) -> float:
        """Since when no sample has come, s; 0 where that is nothing unusual."""
        waited = now - self._came
        return waited if waited > self._patience else 0.0
