"""What a laboratory records: which courses, how many, how long, and what went before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.validation.base import Actuator
from microgripper_control.validation.block import Array
from microgripper_control.validation.drive import KNOTS, Drive
from microgripper_control.validation.waves import (
    Maker,
    Wave,
    Wish,
    chirp,
    decaying,
    keyframes,
    loops,
    multisine,
    poor,
    setpoints,
    staircase,
)

# Shortest and longest recording of each kind, s.
KINDS: dict[str, tuple[Maker, float, float]] = {
    "loops": (loops, 15.0, 44.0),
    "decaying": (decaying, 15.0, 44.0),
    "staircase": (staircase, 25.0, 60.0),
    "multisine": (multisine, 12.0, 30.0),
    "chirp": (chirp, 15.0, 40.0),
    "tracking": (setpoints, 20.0, 44.0),
    "poor": (poor, 20.0, 40.0),
}
MIXED = ("loops", "decaying", "staircase", "multisine", "chirp")
EXCITATIONS = (*KINDS, "mixed")
# What bounds the time that it takes to make a case, and to diagnose it.
LONGEST_TOGETHER = 60.0  # s, all recordings of a case
MOST_SAMPLES, MOST_BRIEF = 60_000, 15_000  # of all recordings of a case, unless they get too short
SHORTEST = 5.0  # s, one recording
FASTEST = 1 / 8  # of the sampling rate: the highest frequency
FASTEST_STRAIGHT = 1 / 40  # of it: up to here straight lines between the samples will do
# Where an effect is to be seen at all; every other effect by all but the poor ones.
SUITED = {"extra_resonance": ("staircase", "multisine", "chirp", "mixed")}


@dataclass(frozen=True)
class Plan:
    """One recording to be made; a closed loop follows `wave` with its displacement."""

    name: str
    kind: str
    wave: Wave
    past: Wave  # ends where the recording begins

    @property
    def closed_loop(self) -> bool:
        """Whether a controller decides on the voltage."""
        return self.kind == "tracking"


def plans(
    excitation: str,
    actuator: Actuator,
    sample_period: float,
    smooth: bool,
    generator: np.random.Generator,
    brief: bool = False,
) -> list[Plan]:
    """One to three recordings for training, then one or two held out; all draws in fixed order.

    `brief` ones are fewer and shorter.
    """
    if excitation not in EXCITATIONS:
        known = ", ".join(EXCITATIONS)
        raise MicrogripperError(f"rig: unknown excitation {excitation!r}; known are {known}")
    names = _names(excitation, brief, generator)
    kinds = [excitation] * len(names)
    if excitation == "mixed":
        training = sum(name.startswith("recording") for name in names)
        order = generator.permutation(len(MIXED))
        # A slow course and a staircase at least, as anyone who looks for trouble would record.
        first = [MIXED[generator.integers(0, 2)], "staircase", MIXED[3 + generator.integers(0, 2)]]
        kinds = first[:training] + [MIXED[i] for i in order[: len(names) - training]]
    wanted = [generator.uniform(*KINDS[kind][1:]) for kind in kinds]
    most_samples = MOST_BRIEF if brief else MOST_SAMPLES
    share = min(1.0, min(LONGEST_TOGETHER, most_samples * sample_period) / sum(wanted))
    made = []
    for name, kind, longest in zip(names, kinds, wanted, strict=True):
        duration = max(share * longest, SHORTEST)
        maker = KINDS[kind][0]
        # One setting of how the voltage runs between samples must suit slow and fast ones together.
        fastest = FASTEST_STRAIGHT if smooth and excitation == "mixed" else FASTEST
        wave = maker(generator, Wish(duration, sample_period, smooth, fastest))
        made.append(Plan(name, kind, wave, _past(actuator, wave, generator)))
    return made


def _names(excitation: str, brief: bool, generator: np.random.Generator) -> list[str]:
    training = int(generator.choice([1, 2, 3], p=[0.25, 0.5, 0.25]))
    heldout = int(generator.choice([1, 2], p=[0.7, 0.3]))
    if excitation == "poor":
        training = heldout = 1
    if excitation == "mixed":
        training = max(training, 2)
    if brief:
        training, heldout = min(training, 2), 1
    return [f"recording_{i + 1}" for i in range(training)] + [
        f"heldout_{i + 1}" for i in range(heldout)
    ]


def _past(actuator: Actuator, wave: Wave, generator: np.random.Generator) -> Wave:
    """From 0 V to the wave's beginning: straight, or after two full loops; then a wait."""
    rest = -actuator.low / (actuator.high - actuator.low)
    start = float(wave.share(np.zeros(1))[0])
    used = generator.uniform() < 0.5
    wait = generator.uniform(0.5, 4.0)
    if not used and start == rest:
        return Wave(0.0, lambda t: np.full_like(t, rest))
    levels = [rest, 1.0, 0.0, 1.0, 0.0, start] if used else [rest, start]
    edge = 0.5
    times: Array = edge * np.arange(len(levels) - 1.0)
    return Wave(float(times[-1]) + edge + wait, keyframes(times, np.array(levels), edge))


def open_loop(plan: Plan, actuator: Actuator, sample_period: float, smooth: bool) -> Drive:
    """The drive of a plan; a closed loop's own is only its past, at the setpoint's start."""
    past = round(plan.past.duration / sample_period)
    count = round(plan.wave.duration / sample_period)
    fine = KNOTS if smooth else 1
    times: Array = sample_period / fine * np.arange(float(-past * fine), float(count * fine))
    before = plan.past.share(times[: past * fine] + past * sample_period)
    share = np.concatenate([before, plan.wave.share(times[past * fine :])])
    voltage = actuator.low + (actuator.high - actuator.low) * share
    if not smooth:
        return Drive(sample_period, past, voltage)
    return Drive(sample_period, past, voltage[::fine].copy(), voltage)


def hold_setting(waves: list[Wave], sample_period: float, smooth: bool) -> str:
    """The `--hold` that is true of these recordings."""
    if not smooth:
        return "zero"
    fast = max(wave.highest for wave in waves) * sample_period
    return "bandlimited" if fast > 1.01 * FASTEST_STRAIGHT else "first"


def suited(effect: str) -> tuple[str, ...]:
    """The excitations on which an effect can be seen, if it is large enough."""
    return SUITED.get(effect, tuple(one for one in EXCITATIONS if one != "poor"))
