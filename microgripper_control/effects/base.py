"""The contract of a link of the signal chain.

A link is one file with the equation, the parameters, the source and a compiled step. The same link
is run live by the plant simulator, fitted by identification, tried by diagnosis and inverted by the
controller. A module in one of the stage folders that defines `LINK` is found by the registry; no
other file has to change.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from microgripper_control.core.parameters import Parameter
from microgripper_control.core.signals import Array, Timing

Values = Mapping[str, float]


class Stage(enum.Enum):
    """Places in the chain, in the order in which the signal passes them."""

    DRIVE = "drive"
    MATERIAL = "material"
    MECHANICS = "mechanics"
    TRANSMISSION = "transmission"
    SENSOR = "sensor"

    @property
    def position(self) -> int:
        """0 for the first stage."""
        return list(Stage).index(self)


@dataclass(frozen=True)
class Prepared:
    """A link made ready for one time grid.

    `coefficients` has one row per internal step of a sample period (one row in all for a sampled
    link); `state` is what the kernel carries from call to call; `ramped` is the course of the
    signal that leaves.
    """

    coefficients: Array
    state: Array
    ramped: bool


# prepare(values, timing, levels): `levels` holds, for each row of the bus, the level at which the
# plant rests when the run begins, and at both ends of the drive, for what h tells of the way there
# (`effects.past`); the link reads its input's and writes its output's, at all three `PLACES`.
Prepare = Callable[[Values, Timing, Array], Prepared]

# kernel(coefficients, state, bus): works through the columns of the bus in place. Column j uses row
# j % len(coefficients); a call always holds whole sample periods.
Kernel = Callable[[Array, Array, Array], None]


# courses(values, time): shapes, (p, n) in m per unit of their weight, of what no input explains and
# each recording has for itself: the phase of a hum, the course of a drift, creep not yet finished
# when the recording began. `time` (n,) is s since its first sample. Weights are fitted linearly.
Courses = Callable[[Values, Array], Array]


def no_courses(values: Values, time: Array) -> Array:
    """A link whose output follows from its input alone."""
    return np.zeros((0, len(time)))


# observed(values, weights, time): what the weights that one recording gave the courses say about
# parameters that are not fitted: how strong a hum was, how far it drifted. For the live simulation.
Observed = Callable[[Values, Array, Array], Values]


def nothing_observed(values: Values, weights: Array, time: Array) -> Values:
    """A link whose courses say nothing about its parameters."""
    return {}


@dataclass(frozen=True)
class Scales:
    """The sizes of a rig at work, read off its recordings: what first guesses are measured by.

    Positions are those of the nominal plant, without the recording's zero.
    """

    sample_period: float  # s
    duration: float  # s, of the longest recording
    voltage: tuple[float, float]  # V, lowest and highest
    rate: float  # V/s, fastest change from sample to sample
    position: tuple[float, float]  # m, lowest and highest
    stiffness: float  # N/m, k + k_s
    mass: float  # kg
    resolution: float = 0.0  # m, of the grid that all readings lie on; 0 if on none
    rounding: float = 0.0  # m rms, what reading on that grid leaves
    clock: float = 0.0  # s, between conversions of a sensor with a clock of its own, else 0

    @property
    def swing(self) -> float:
        """V between the lowest and the highest voltage."""
        return self.voltage[1] - self.voltage[0]

    @property
    def stroke(self) -> float:
        """m between the lowest and the highest position."""
        return self.position[1] - self.position[0]


# starts(scales): points from which a fit of the link is tried, as values by name; parameters left
# out are nominal. A diagnosis tries the links that have some.
Starts = Callable[[Scales], Sequence[Values]]


def no_starts(scales: Scales) -> Sequence[Values]:
    """A link that explains nothing by itself."""
    return ()


# more(values, scales): first guesses of a further part of the law, which only a fit without it can
# suggest: what is added to the values of that fit, weak, with one parameter that vanishes.
More = Callable[[Values, Scales], Sequence[Values]]


def no_more(values: Values, scales: Scales) -> Sequence[Values]:
    """A link whose first guesses are all there is."""
    return ()


# credible(values, course, scales): whether the course that one recording was given, m, shape (n,),
# can be the link's own with these values. Weights are fitted freely: another cause may use them.
Credible = Callable[[Values, Array, Scales], bool]


def always_credible(values: Values, course: Array, scales: Scales) -> bool:
    """A link without courses, or one whose courses may be of any size."""
    return True


# behind(values): s by which what leaves the link is behind a slow ramp of what enters it.
Behind = Callable[[Values], float]


def never_behind(values: Values) -> float:
    """A link that answers at once, as far as a controller is concerned."""
    return 0.0


# ringing(values): s, an upper bound of |G(jw) - 1| / w over all w, G being the link's response: by
# so much, times ki and the plant's gain at rest, a mode can raise the loop gain of integral action.
# What is `behind` at all frequencies alike does not count.
Ringing = Callable[[Values], float]


def never_ringing(values: Values) -> float:
    """A link without a mode of its own."""
    return 0.0


# rescaled(values, factor): what else changes, where the parameters at which the link vanishes
# become `factor` times as large, so that it does the same, only stronger.
Rescaled = Callable[[Values, float], Values]


def nothing_else(values: Values, factor: float) -> Values:
    """A link whose strength is a factor."""
    return {}


# likened(other, values, scales): values with which the link does about what another link, of that
# name, does with its values; none where it cannot.
Likened = Callable[[str, Values, Scales], Values]


def like_no_other(other: str, values: Values, scales: Scales) -> Values:
    """A link that imitates none, or is found by itself."""
    return {}


# says(values, scales): what a technician sees of the effect, a clause in small letters with numbers
# in practical units. Of a link whose size belongs to each recording, the size is left out.
Says = Callable[[Values, Scales], str]


# plausible(scales): the ranges, as (lowest, highest) by name, in which a diagnosis looks for the
# link's parameters on the rig at hand; for those left out it is the declared range.
Plausible = Callable[[Scales], Mapping[str, tuple[float, float]]]


def as_declared(scales: Scales) -> Mapping[str, tuple[float, float]]:
    """A link whose declared ranges will do."""
    return {}


# unusual(values, scales): from 0, for values that the field knows the effect by, to 1, for those
# that go by another name, or more for those that the name rules out. Laws that can imitate each
# other are told apart by their sizes, too.
Unusual = Callable[[Values, Scales], float]


def never_unusual(values: Values, scales: Scales) -> float:
    """A link that goes by its name whatever its values."""
    return 0.0


# nonsense(values): why values that are each within their range make no sense together, for who
# wrote them; empty if they do. A fit may pass through such values.
Nonsense = Callable[[Values], str]


def always_sensible(values: Values) -> str:
    """A link whose parameters do not depend on each other."""
    return ""


# idle(values): names of parameters that change nothing as long as those that are not fitted stay.
Idle = Callable[[Values], Collection[str]]


def none_idle(values: Values) -> Collection[str]:
    """A link that answers to each of its parameters."""
    return ()


def no_part_of_its_own(values: Values, timing: Timing, levels: Array) -> Prepared:
    """A force has no place on the bus: it acts inside the mechanics' solve."""
    return Prepared(np.zeros((1, 0)), np.zeros(0), timing.ramped)


def no_step_of_its_own(coefficients: Array, state: Array, bus: Array) -> None:
    """See `no_part_of_its_own`."""


# law(coefficients, before, after, x0, x1, v, step): the force on the mass, N, positive with x, at
# the end of a `step`, s, in which the mass went one way from x0 to x1, m, and arrived with the
# speed v, m/s. `before` and `after` are the law's state at both ends; they may be one memory, and a
# law is tried many times from one `before`. A plain function: it is compiled by `core.compiled`.
Law = Callable[[Array, Array, Array, float, float, float, float], float]


def undamped(values: Values) -> float:
    """A force that asks for the place of the mass and its path, not for its speed."""
    return 0.0


def nothing_released(values: Values) -> float:
    """A force that holds, when a run begins, all that the way there has made of it."""
    return 0.0


@dataclass(frozen=True)
class Force:
    """What a link does that pushes on the moving mass, instead of acting on the bus.

    Held over a sample such a force would go unstable, so it lives inside the solve of the link that
    moves the mass. A law with a state follows the path of the mass, not its place alone; the state
    is zero where the mass has never been moved.
    """

    law: Law
    coefficients: Callable[[Values], Sequence[float]]
    stiffness: Callable[[Values], float]  # N/m, of the order of the largest: how fine the solve is
    states: int = 0
    fading: bool = False  # whether its state goes with time and is as smooth as the motion
    brakes: bool = False  # whether its speed may count so much that it must be solved for
    damping: Callable[[Values], float] = undamped  # N s/m, the largest that is not solved for
    released: Callable[[Values], float] = nothing_released  # 1 if it has let go before a run begins


Load = tuple[Force, Values]


@dataclass(frozen=True)
class Solver:
    """How the link that moves the mass steps when there are forces; `prepare` gets them, too."""

    prepare: Callable[[Values, Timing, Array, Sequence[Load]], Prepared]
    kernel: Kernel


# Where a sample period is to be divided, in fractions of it. `jumps`: when, other than at the
# samples, what leaves jumps if the voltage is stepped. The others count from each jump, and say
# where a course that is taken as straight from step to step needs a corner: `breaks` always,
# `bends` unless the voltage is smooth, `settling` if a link behind follows the course between the
# samples.
Instants = Callable[[Values, float], set[float]]


def no_instants(values: Values, sample_period: float) -> set[float]:
    """A link that is exact on whole sample periods needs no division of them."""
    return set()


@dataclass(frozen=True)
class Link:
    """One member of the chain; see the module for what its parts must do."""

    name: str
    stage: Stage
    order: int  # among the links of one stage
    title: str
    source: str
    parameters: tuple[Parameter, ...]
    prepare: Prepare = no_part_of_its_own
    kernel: Kernel = no_step_of_its_own
    force: Force | None = None  # in place of the two
    solver: Solver | None = None  # in place of the two when there are forces
    jumps: Instants = no_instants
    breaks: Instants = no_instants
    bends: Instants = no_instants
    settling: Instants = no_instants
    courses: Courses = no_courses
    observed: Observed = nothing_observed
    credible: Credible = always_credible
    starts: Starts = no_starts
    more: More = no_more
    plausible: Plausible = as_declared
    unusual: Unusual = never_unusual
    nonsense: Nonsense = always_sensible
    idle: Idle = none_idle
    rescaled: Rescaled = nothing_else
    likened: Likened = like_no_other
    behind: Behind = never_behind
    ringing: Ringing = never_ringing
    says: Says | None = None  # the title does without
    nominal: bool = False  # part of the paper's plant, always there
    follows: bool = False  # the course between the samples matters to it
    of_the_way: bool = False  # knows place and way and, like a force, next to nothing of the time
    sampled: bool = False  # acts on the samples, not on the signal between them
    random: bool = False  # not repeatable: left out of predictions
    clocked: bool = False  # has a parameter `clock`: see `conversion_clock`

    def __post_init__(self) -> None:
        if not self.parameters or not self.title or not self.source:
            raise ValueError(f"link {self.name}: parameters, title and source are required")
        if (self.kernel is no_step_of_its_own) == (self.force is None):
            raise ValueError(f"link {self.name}: either a kernel or a force is required")
        if not self.nominal and all(p.vanishing is None for p in self.parameters):
            raise ValueError(f"link {self.name}: no parameter says where the effect vanishes")

    @cached_property
    def read_off(self) -> bool:
        """Whether its parameters are read off the recordings, not fitted: a sensor's grid."""
        return not self.random and not any(parameter.fitted for parameter in self.parameters)

    @property
    def place(self) -> tuple[int, int]:
        """Sort key: where along the chain the link stands."""
        return self.stage.position, self.order

    def parameter(self, name: str) -> Parameter:
        """The declared parameter of that name; KeyError if there is none."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise KeyError(name)

    def is_off(self, values: Values) -> bool:
        """Whether every parameter that can make the effect vanish does so."""
        if self.nominal:
            return False
        return all(
            values[p.name] == p.vanishing for p in self.parameters if p.vanishing is not None
        )
