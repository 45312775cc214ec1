"""The laboratory of one case: an actuator not quite nominal, a sensor, and what is recorded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from microgripper_control.validation.base import ACTUATORS, MISTUNED, Actuator, Base
from microgripper_control.validation.block import Array
from microgripper_control.validation.closed_loop import track, tune
from microgripper_control.validation.drive import Drive
from microgripper_control.validation.excitation import Plan, hold_setting, open_loop, plans
from microgripper_control.validation.law import Taken
from microgripper_control.validation.machine import Applied, Rig
from microgripper_control.validation.simulate import measure, run

ACTUATOR_SHARES = (0.55, 0.25, 0.2)  # of the cases
RATES = (200.0, 500.0, 1000.0, 2000.0, 5000.0, 10000.0)  # Hz
RATE_SHARES = (0.08, 0.1, 0.5, 0.17, 0.1, 0.05)
FASTEST_LOOP = 1000.0  # Hz, as each of its samples is a call
FASTEST_BRIEF = 1000.0  # Hz
SMOOTH_SHARE = 0.25
MISTUNING = 0.15  # largest, either way
USUAL_NOISE = 15e-9  # m, in half of the cases
NOISE_RANGE = (5e-9, 50e-9)  # m, in the others
FARTHEST_ZERO = 3e-6  # m
ZERO_JITTER = 5e-8  # m, from one recording to the next
BANDWIDTHS = (0.7, 3.0)  # Hz, of the closed loop

# What a draw is for, so that more draws for one thing leave the others alone.
FOR_RIG, FOR_PLANS, FOR_NOISE, FOR_EFFECTS = range(4)


@dataclass(frozen=True)
class Laboratory:
    """All that stays the same whatever effect the rig has."""

    seed: int
    actuator: Actuator
    sample_period: float  # s
    smooth: bool
    noise: float  # m
    base: Base  # the true one
    zeros: tuple[float, ...]  # m, what the sensor shows at x = 0, for each recording
    bandwidth: float  # Hz
    brief: bool
    plans: tuple[Plan, ...]

    @property
    def hold(self) -> str:
        """The `--hold` that is true."""
        return hold_setting([plan.wave for plan in self.plans], self.sample_period, self.smooth)

    def chance(self, index: int) -> tuple[int, ...]:
        """The seed of what is random in one recording's effects."""
        return self.seed, FOR_EFFECTS, index

    def rig(self, effects: Sequence[Applied] = ()) -> Rig:
        """The rig with effects."""
        return Rig(self.base, self.actuator.scale, tuple(effects))

    def drives(self, steps: int) -> list[Drive]:
        """Voltages of all recordings; a closed loop's are those it needs without any effect."""
        return [self._take(i, (), steps)[0] for i in range(len(self.plans))]

    def record(
        self, effects: Sequence[Applied], steps: int, drives: Sequence[Drive] | None = None
    ) -> list[Taken]:
        """All recordings: over given voltages, or as made, where closed loops answer effects."""
        taken = []
        for i, plan in enumerate(self.plans):
            drive, recorded = self._take(i, effects, steps, drives[i] if drives else None)
            taken.append(Taken(plan.name, drive, recorded + self.zeros[i], self.chance(i)))
        return taken

    def _take(
        self, index: int, effects: Sequence[Applied], steps: int, drive: Drive | None = None
    ) -> tuple[Drive, Array]:
        plan, rig, chance = self.plans[index], self.rig(effects), self.chance(index)
        begun = drive or open_loop(plan, self.actuator, self.sample_period, self.smooth)
        count = len(begun.recorded)
        generator = np.random.default_rng([self.seed, FOR_NOISE, index])
        noise = self.noise * generator.standard_normal(count)
        if plan.closed_loop and drive is None:
            scale = self.actuator.scale
            times: Array = self.sample_period * np.arange(float(count))
            setpoint = scale.bottom + scale.stroke * plan.wave.share(times)
            controller = tune(self.bandwidth, scale.stroke, scale.low, scale.high)
            return track(rig, begun, setpoint, controller, noise, steps, chance)
        machine, readings = run(rig, begun, steps, chance)
        return begun, measure(machine, readings, noise, self.sample_period)


def equipped(
    seed: int,
    excitation: str,
    mistuned: bool = True,
    like: Laboratory | None = None,
    brief: bool = False,
) -> Laboratory:
    """Draw a laboratory; `like` keeps another's sampling and takes only the plans anew.

    A `brief` one samples more slowly and records less, so that a case takes less time.
    """
    generator = np.random.default_rng([seed, FOR_RIG])
    actuator = ACTUATORS[generator.choice(len(ACTUATORS), p=ACTUATOR_SHARES)]
    rate = max(float(generator.choice(RATES, p=RATE_SHARES)), actuator.slowest)
    smooth = bool(generator.uniform() < SMOOTH_SHARE) and excitation != "tracking"
    usual = generator.uniform() < 0.5
    other = float(np.exp(generator.uniform(*np.log(NOISE_RANGE))))
    factors = 1.0 + MISTUNING * generator.uniform(-1.0, 1.0, len(MISTUNED))
    zero = generator.uniform(-FARTHEST_ZERO, FARTHEST_ZERO)
    bandwidth = float(generator.uniform(*BANDWIDTHS))
    if excitation == "tracking":
        rate = min(rate, FASTEST_LOOP)
    if brief:
        rate = min(rate, max(FASTEST_BRIEF, actuator.slowest))
    if like is not None:
        rate, smooth, brief = 1.0 / like.sample_period, like.smooth, like.brief
    base = actuator.base
    if mistuned:
        base = base.scaled(dict(zip(MISTUNED, factors.tolist(), strict=True)))
    chance = np.random.default_rng([seed, FOR_PLANS])
    made = plans(excitation, actuator, 1.0 / rate, smooth, chance, brief)
    zeros = zero + ZERO_JITTER * generator.standard_normal(len(made))
    return Laboratory(
        seed,
        actuator,
        1.0 / rate,
        smooth,
        USUAL_NOISE if usual else other,
        base,
        tuple(zeros.tolist()),
        bandwidth,
        brief,
        tuple(made),
    )
