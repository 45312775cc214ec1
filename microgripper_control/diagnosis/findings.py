"""What a diagnosis finds: plain data, as `diagnosis.json` and the report show it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.identification.nuisance import Conditions, Mask
from microgripper_control.plant.model import Model, Setting

NONE, PARAMETERS, EFFECTS, UNKNOWN = "none", "parameters", "effects", "unknown"
EXPLAINABLE = 0.2  # of a gap: less of it, and the voltage is hardly its cause


@dataclass(frozen=True)
class Range:
    """A range of one axis and the share of the gap's power in it, 0 .. 1.

    `axis` is one of frequency_Hz, displacement_m, voltage_V, rate_V_per_s, time_s, hold_time_s and
    direction (-1 falling, 1 rising).
    """

    axis: str
    low: float
    high: float
    share_of_gap: float
    bend: float | None = None  # the end of it at which the error takes another slope, if it does
    recording: str = ""  # of several the one in which a time lies


@dataclass(frozen=True)
class Signature:
    """A fit-free test of what an effect predicts: `agrees` is None where the data cannot say."""

    effect: str
    agrees: bool | None
    statement: str  # what was looked at and what was seen, in one sentence with numbers


@dataclass(frozen=True)
class Candidate:
    """One possible answer: an effect, or one of none, parameters and unknown (stage None)."""

    effect: str
    stage: str | None
    probability: float  # that it is the answer, or the largest of several; sums to one
    present: float  # that it is at work at all
    rmse: float | None  # m, on the judging samples; None where nothing was fitted
    parameters: Mapping[str, Setting] = field(default_factory=dict)
    share: float = 0.0  # of the closable gap that goes when it alone is added
    signatures: tuple[Signature, ...] = ()
    note: str = ""  # why it was not tried, what failed, a parameter at its bound


@dataclass(frozen=True)
class Gap:
    """Root mean square errors on the judging samples, m."""

    nominal: float
    refit: float
    augmented: float
    noise_floor: float
    closed: float  # share of the removable error that the effects take away
    closed_low: float
    closed_high: float
    free_form: float  # share that a free-form model of the residual could take away
    separate: bool  # judged on recordings of their own, not on blocks held out
    driver: str = ""  # the effect that alone takes most away and knows the voltage alone,
    by_driver: float = 0.0  # and its share
    unseen: bool = False  # what judges held what the fit had not seen at first

    @property
    def driven(self) -> float:
        """Share of the removable error that follows from the voltage, at least."""
        return max(self.free_form, self.by_driver)

    @property
    def foreign(self) -> bool:
        """Whether hardly any of it is seen to follow from the voltage."""
        return self.driven < EXPLAINABLE

    @property
    def untold(self) -> bool:
        """Whether that says nothing: what shows once only nobody can have learnt elsewhere."""
        return self.foreign and self.unseen


@dataclass(frozen=True)
class NextExperiment:
    """A voltage to record next, and what it would tell apart."""

    why: str
    separates: tuple[str, ...]
    sample_period: float  # s
    voltage: Array  # V, shape (n,)


@dataclass(frozen=True)
class Judged:
    """A judging recording with what each model predicts of it, m, shape (n,) each."""

    recording: Recording
    counted: Mask
    nominal: Array
    refit: Array
    augmented: Array
    zero: float = 0.0  # m, how much higher its sensor's zero is than on average of the recordings

    @property
    def position(self) -> Array:
        """What was measured, m, with the same zero for all recordings; `where` counts so."""
        return self.recording.measured - self.zero


@dataclass(frozen=True)
class Diagnosis:
    """The whole answer."""

    verdict: str
    sentence: str  # the verdict as a technician understands it
    effects: tuple[str, ...]  # most important first; empty unless the verdict is `effects`
    candidates: tuple[Candidate, ...]  # largest probability first
    stages: Mapping[str, float]
    gap: Gap
    where: tuple[Range, ...]
    ambiguous: tuple[tuple[str, ...], ...]
    next_experiment: NextExperiment | None
    nominal: Model
    refit: Model
    model: Model  # with the effects added and fitted
    conditions: Conditions
    judged: tuple[Judged, ...]
    shares: Mapping[str, float]  # of each diagnosed effect: what leaving it out would lose
    warnings: tuple[str, ...] = ()
