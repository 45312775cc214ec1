"""The verdict in words that a technician understands."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from microgripper_control.core.quantities import number, percent, quantity
from microgripper_control.diagnosis.answers.places import as_sentence, clause
from microgripper_control.diagnosis.data.noise import removable
from microgripper_control.diagnosis.findings import (
    EFFECTS,
    NONE,
    PARAMETERS,
    Candidate,
    Gap,
    Range,
)
from microgripper_control.effects.base import Scales, Values
from microgripper_control.effects.registry import registry
from microgripper_control.plant.model import Model, Setting, title

MOVED = 0.01  # of a parameter: a smaller correction is not spoken of
MOST_MOVED = 3
VAGUE = 0.1  # of a value: a wider interval is spoken of
UNDRIVEN = ("time_s", "frequency_Hz")  # axes along which a disturbance may lie


def sentence(
    verdict: str,
    effects: Sequence[str],
    gap: Gap,
    nominal: Model,
    model: Model,
    candidates: Sequence[Candidate],
    where: Sequence[Range],
    scales: Scales,
    ambiguous: Sequence[Sequence[str]] = (),
    sizes: Mapping[str, float] = MappingProxyType({}),
    slow_gain: bool = False,
) -> str:
    """The verdict, the numbers behind it and how far the error shrinks, in a few plain sentences.

    `nominal` is the model as given, `model` the one that the verdict stands for. `ambiguous` are
    groups of effects that could stand for each other, `sizes` those of the effects of which each
    recording has a course of its own, m rms. `slow_gain` says whether a gain that changes slowly
    would explain much.
    """
    floor = f"noise floor {quantity(gap.noise_floor, 'm')}"
    if verdict == NONE:
        left = f"it leaves {quantity(gap.nominal, 'm')} ({floor})"
        if removable(gap.nominal, gap.noise_floor) > gap.noise_floor:
            return f"Nothing that was tried foretells the recordings better than the model: {left}."
        return f"The model explains the recordings down to their noise: {left}."
    if verdict == PARAMETERS:
        after = f"from {quantity(gap.nominal, 'm')} to {quantity(gap.augmented, 'm')} ({floor})"
        return f"{_moved(nominal, model)} Fitting them again takes the held-out error {after}."
    if verdict == EFFECTS:
        groups = [_group(name, ambiguous) for name in effects]
        known = {candidate.effect: candidate for candidate in candidates}
        clauses = [_clause(group, model, known, sizes, scales) for group in groups]
        return " ".join(
            [as_sentence(clauses[0]), *map(_further, clauses[1:]), _shrunk(groups, gap)]
        )
    return _unexplained(gap, where, floor, slow_gain)


def described(name: str, values: Values, scales: Scales) -> str:
    """What an effect with these values does to the rig, as a clause."""
    link = registry()[name]
    return link.says(values, scales) if link.says else f"the rig shows {link.title}"


def _further(clause: str) -> str:
    return f"Besides, {clause}."


def _plain(name: str) -> str:
    """A canonical name as words."""
    return name.replace("_", " ")


def _group(name: str, ambiguous: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """An effect, first, and those that could stand for it."""
    others = dict.fromkeys(other for group in ambiguous if name in group for other in group)
    return (name, *(other for other in others if other != name))


def _clause(
    group: Sequence[str],
    model: Model,
    known: Mapping[str, Candidate],
    sizes: Mapping[str, float],
    scales: Scales,
) -> str:
    """What one effect does, or what each of several would that could stand for it."""
    said = []
    for name in group:
        settings = known[name].parameters if name in known else {}
        settings = model.settings.get(name, settings)
        said.append(_with_size(name, settings, sizes, scales))
    if len(said) == 1:
        return said[0]
    return f"either {', or '.join(said)}; these recordings do not tell which"


def _with_size(
    name: str, settings: Mapping[str, Setting], sizes: Mapping[str, float], scales: Scales
) -> str:
    """An effect's clause."""
    link = registry()[name]
    if not settings:
        return f"the rig shows {link.title}"
    clause = described(name, {key: setting.value for key, setting in settings.items()}, scales)
    clause += _vague(name, settings)
    if name in sizes:
        clause += f" ({quantity(sizes[name], 'm')} rms)"
    return clause


def _vague(name: str, settings: Mapping[str, Setting]) -> str:
    """How far the recordings leave the one value of an effect open: a held voltage hides much."""
    fitted = [key for key in settings if registry()[name].parameter(key).fitted]
    if len(fitted) != 1:
        return ""
    (key,) = fitted
    setting = settings[key]
    low, high = setting.interval or (setting.value, setting.value)
    if high - low <= VAGUE * abs(setting.value):
        return ""
    unit = registry()[name].parameter(key).unit
    return f" ({quantity(low, unit)} to {quantity(high, unit)} would do as well)"


def _shrunk(groups: Sequence[Sequence[str]], gap: Gap) -> str:
    rounding = all(registry()[name].read_off for group in groups for name in group)
    if rounding and gap.augmented >= gap.refit:
        rounded = quantity(removable(gap.refit, gap.noise_floor), "m")
        return (
            f"That is {rounded} of the held-out error of {quantity(gap.refit, 'm')} (noise floor "
            f"{quantity(gap.noise_floor, 'm')}); which way a reading is rounded, no model "
            "foretells."
        )
    added = " and ".join(" or ".join(map(_plain, group)) for group in groups)
    low, high = (number(100.0 * end) for end in (gap.closed_low, gap.closed_high))
    return (
        f"Adding {added} takes the held-out error from {quantity(gap.refit, 'm')} to "
        f"{quantity(gap.augmented, 'm')} (noise floor {quantity(gap.noise_floor, 'm')}): "
        f"{percent(gap.closed)} [{low}, {high}] of what could be removed."
    )


def _moved(nominal: Model, model: Model) -> str:
    """Which parameters the recordings correct, the most corrected first."""
    changes = {}
    for link, settings in nominal.settings.items():
        for name, before in settings.items():
            after = model.settings[link][name]
            low, high = after.interval or (after.value, after.value)
            change = _share_of(before.value, after.value - before.value)
            if abs(change) >= MOVED and not low <= before.value <= high:
                changes[link, name] = change
    most = sorted(changes, key=lambda key: -abs(changes[key]))[:MOST_MOVED]
    if not most:
        return "The model's parameters are a little off, and nothing else."
    said = ", ".join(f"{title(key)} {_by(changes[key], model.value(*key))}" for key in most)
    return f"The model's parameters are off, and nothing else: {said}."


def _share_of(before: float, change: float) -> float:
    """A change in proportion to what was there; of nothing, any is infinitely much."""
    if before == 0.0:
        return math.copysign(math.inf, change) if change else 0.0
    return change / abs(before)


def _by(change: float, value: float) -> str:
    if math.isinf(change):
        return f"from 0 to {number(value)}"
    return f"by {'+' if change > 0.0 else ''}{percent(change)}"


def _unexplained(gap: Gap, where: Sequence[Range], floor: str, slow_gain: bool) -> str:
    """A real gap that no candidate explains."""
    # Where it lies on an axis that the voltage drives would read as if the voltage were its cause.
    told = [found for found in where if not gap.foreign or found.axis in UNDRIVEN]
    lies = f"; {clause(told[0], 'its')}" if told else ""
    if slow_gain:
        cause = (
            "The rig goes farther at some times than at others, as if its gain changed slowly: "
            "look for a supply that sags, a stack that ages, a sensor that warms."
        )
    elif gap.untold:
        cause = (
            "Whether it follows from the voltage cannot be told: it shows where the recordings do "
            "what they do nowhere else."
        )
    elif gap.foreign:
        cause = "Hardly any of it follows from the voltage: look for a disturbance."
    elif gap.by_driver > gap.free_form:
        cause = (
            f"Added alone, {_plain(gap.driver)} takes {percent(gap.by_driver)} of it away, so as "
            "much follows from the voltage, at least."
        )
    else:
        cause = (
            f"A free-form model closes {percent(gap.free_form)} of it from the voltage alone, "
            "so there is something to be found."
        )
    return (
        f"Something is missing that no known effect explains: after a refit the held-out error is "
        f"still {quantity(gap.refit, 'm')} ({floor}){lies}. {cause}"
    )
