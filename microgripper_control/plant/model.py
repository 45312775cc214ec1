"""The model of a rig: which links its chain has and the value of each of their parameters."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.signals import Array
from microgripper_control.effects.base import Link, Values
from microgripper_control.effects.bouc_wen_behaviour import BehaviourClass, behaviour
from microgripper_control.effects.registry import link_named, registry

Key = tuple[str, str]  # link, parameter
ZERO: Key = ("sensor_zero", "offset")
BEYOND = 0.01  # of the voltage range: so much beyond it is not spoken of


def title(key: Key) -> str:
    """A parameter's name as people read it: the paper's own by themselves, others with the link."""
    return key[1] if registry()[key[0]].nominal else f"{key[0]}.{key[1]}"


@dataclass(frozen=True)
class Setting:
    """A parameter's value in a model; `interval` holds its 95 % bounds if it was identified."""

    value: float
    interval: tuple[float, float] | None = None
    frozen: bool = False  # a fit leaves it alone

    @property
    def ends(self) -> tuple[float | None, float | None]:
        """The bounds, None where the data leave one open: JSON knows no infinity."""
        low, high = self.interval or (-math.inf, math.inf)
        return low if math.isfinite(low) else None, high if math.isfinite(high) else None


@dataclass(frozen=True)
class Model:
    """A rig's model, checked at construction; raises MicrogripperError naming the key."""

    name: str
    voltage_range: tuple[float, float]  # V
    settings: Mapping[str, Mapping[str, Setting]]  # link -> parameter -> setting
    description: str = ""
    origin: str = field(default="model", compare=False)  # what error messages call it

    def __post_init__(self) -> None:
        low, high = self.voltage_range
        if not low < high:
            raise MicrogripperError(
                f"{self.origin}: voltage: low {low:g} must be below high {high:g}"
            )
        for name in self.settings:
            self._check(link_named(name, self.origin))
        missing = [name for name, link in registry().items() if link.nominal]
        missing = [name for name in missing if name not in self.settings]
        if missing:
            raise MicrogripperError(f"{self.origin}: nominal: {missing[0]} is missing")
        ordered = sorted(self.settings, key=lambda name: registry()[name].place)
        frozen = {name: MappingProxyType(dict(self.settings[name])) for name in ordered}
        object.__setattr__(self, "settings", MappingProxyType(frozen))

    def _check(self, link: Link) -> None:
        given = self.settings[link.name]
        where = f"{self.origin}: {link.name}"
        known = [p.name for p in link.parameters]
        for name in given:
            if name not in known:
                raise MicrogripperError(
                    f"{where}: unknown key {name!r}; known are {', '.join(known)}"
                )
        for parameter in link.parameters:
            if parameter.name not in given:
                raise MicrogripperError(
                    f"{where}: {parameter.name} is missing; allowed is {parameter.range_text}"
                )
            parameter.check(given[parameter.name].value, where)

    def __reduce__(self) -> tuple[object, ...]:
        plain = {name: dict(settings) for name, settings in self.settings.items()}
        return Model, (self.name, self.voltage_range, plain, self.description, self.origin)

    @cached_property
    def at_work(self) -> Sequence[tuple[Link, Values]]:
        """The links in the order of the chain, with their numbers; those that are off are absent.

        Kept, and the numbers not to be changed: most models are simulated over and over.
        """
        present = [(registry()[name], self.values(name)) for name in self.settings]
        return [(link, values) for link, values in present if not link.is_off(values)]

    @property
    def links(self) -> list[Link]:
        """The links that are at work, in the order of the chain."""
        return [link for link, _ in self.at_work]

    @cached_property
    def clock(self) -> float:
        """Between conversions of a sensor with a clock of its own, s; 0 if it has none."""
        return max((self.value(*key) for key in self._clocks), default=0.0)

    def unclocked(self) -> Model:
        """A copy whose sensor converts with every sample."""
        return self.with_values(dict.fromkeys(self._clocks, 0.0))

    @property
    def _clocks(self) -> list[Key]:
        return [(name, "clock") for name in self.settings if registry()[name].clocked]

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the links beyond the paper's plant."""
        return tuple(name for name in self.settings if not registry()[name].nominal)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What to know before these values are trusted, one line each: show it on loading."""
        found = behaviour(self.values("bouc_wen"))
        low, high = self.voltage_range
        if high - low <= found.safe_span:
            return ()
        where = f"{self.origin}: voltage: {low:g} .. {high:g} V"
        if found.kind is BehaviourClass.RATCHETING:
            return (f"{where}: bouc_wen with beta < 0 is {found.kind.value}; identify it again",)
        turns = "the displacement turns against the voltage"
        fault = "h grows to infinity" if found.safe_span == found.escape else turns
        return (
            f"{where}: with these alpha, beta and gamma {fault} in cycles wider than "
            f"{found.safe_span:.1f} V; narrow the range or identify them again",
        )

    def beyond(self, voltage: Array) -> str:
        """What of a drive voltage, V, shape (n,), these values do not hold for; empty if none."""
        (low, high), least, most = self.voltage_range, float(voltage.min()), float(voltage.max())
        room = BEYOND * (high - low)
        if least >= low - room and most <= high + room:
            return ""
        return f"voltage {least:g} .. {most:g} V; the model holds for {low:g} .. {high:g} V"

    @property
    def rounding(self) -> tuple[str, ...]:
        """Names of the links that round what the sensor shows."""
        return tuple(name for name in self.settings if registry()[name].read_off)

    @property
    def zero(self) -> float:
        """What the sensor reads at x = 0, m."""
        return self.value(*ZERO) if ZERO[0] in self.settings else 0.0

    @property
    def dead_time(self) -> float:
        """S by which its effects let the reading be behind the command, all delays and lags."""
        return sum(registry()[link].behind(self.values(link)) for link in self.settings)

    @property
    def ringing(self) -> float:
        """S: how much the modes of its effects can add to a loop, per ki and gain at rest."""
        return sum(registry()[link].ringing(self.values(link)) for link in self.settings)

    @property
    def beside_the_inverse(self) -> tuple[str, ...]:
        """Names of the effects at work that a controller knows nothing of, in any of its values."""
        known = (ZERO[0], *self.rounding)
        return tuple(
            link.name
            for link, values in self.at_work
            if not (link.nominal or link.random or link.name in known)
            and not (link.behind(values) or link.ringing(values))
        )

    def values(self, link: str) -> dict[str, float]:
        """The plain numbers of one link."""
        return {name: setting.value for name, setting in self.settings[link].items()}

    def value(self, link: str, parameter: str) -> float:
        """One number."""
        return self.settings[link][parameter].value

    def with_settings(self, changes: Mapping[Key, Setting]) -> Model:
        """A copy with some settings replaced; the links must be present."""
        settings = {name: dict(old) for name, old in self.settings.items()}
        for (link, parameter), setting in changes.items():
            settings[link][parameter] = setting
        return replace(self, settings=settings)

    def with_values(self, changes: Mapping[Key, float]) -> Model:
        """A copy with some values replaced; intervals of the old values are dropped."""
        return self.with_settings(
            {
                (link, name): Setting(value, frozen=self.settings[link][name].frozen)
                for (link, name), value in changes.items()
            }
        )

    def with_link(self, name: str, **values: float) -> Model:
        """A copy with a link added (or replaced); parameters not given are nominal."""
        link = link_named(name, self.origin)
        chosen = {p.name: Setting(values.pop(p.name, p.nominal)) for p in link.parameters}
        if values:
            raise MicrogripperError(f"{self.origin}: {name}: unknown key {next(iter(values))!r}")
        return replace(self, settings={**self.settings, name: chosen})

    def with_rounding_of(self, other: Model) -> Model:
        """A copy that rounds what the sensor shows as another model does."""
        taken = {name: other.settings[name] for name in other.rounding}
        return replace(self, settings={**self.settings, **taken}) if taken else self

    def without(self, names: Iterable[str]) -> Model:
        """A copy without some links."""
        dropped = set(names)
        kept = {name: old for name, old in self.settings.items() if name not in dropped}
        return replace(self, settings=kept)


def nominal_model(name: str = "APA120S (paper, Table 1)") -> Model:
    """The paper's actuator: every nominal link at its declared nominal values, 0 to 160 V."""
    settings = {
        link.name: {p.name: Setting(p.nominal) for p in link.parameters}
        for link in registry().values()
        if link.nominal
    }
    return Model(name, (0.0, 160.0), settings)
