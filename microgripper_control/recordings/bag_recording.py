"""Voltage, displacement and setpoint out of a bag.

The usual bag has one topic `joint_states`, whose every message is a whole sample (`effort` carries
the drive voltage). Bags of other rigs may hold the quantities on two topics: the displacement's
samples are the clock then, and each is given the newest voltage stamped at or before it, as a
converter would hold it. Where a clock sends the voltage and some of it is missing, it would be held
for too long: those samples are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.recordings.bag import Bag
from microgripper_control.recordings.clock import on_uniform_clock
from microgripper_control.recordings.layout import Layout, LayoutError, Place
from microgripper_control.recordings.mapping import Mapping, Source
from microgripper_control.recordings.samples import Samples
from microgripper_control.recordings.storage import Integers, Topic
from microgripper_control.recordings.values import values_by_block

JOINT_STATE = "sensor_msgs/msg/JointState"
FLOAT64 = "std_msgs/msg/Float64"
JOINT = "finger"
JOINT_FIELDS = {"voltage": "effort", "displacement": "position", "setpoint": "position"}
BY_NAME = ("position", "velocity", "effort")
Names = tuple[str, ...]  # of a message's joints, by which its driver is known
USUAL_TOPICS = {
    "voltage": ("joint_states", JOINT_STATE),
    "displacement": ("joint_states", JOINT_STATE),
    "setpoint": ("setpoint", FLOAT64),
}
SAME_INSTANT = 0.01  # of the sample period: a voltage stamped later by less is not late
FEWEST = 10  # intervals between voltages that tell whether they are sent by a clock
LONGEST_HOLD = 3.0  # of its periods: a voltage that is older is not what was applied
MOST_UNUSED = 0.5  # of the voltages


@dataclass(frozen=True)
class Choice:
    """Where one quantity is read from in a bag; NaN where it is not `needed` and not there."""

    quantity: str
    topic: Topic
    field: str | None
    scale: float
    needed: bool
    joint: str | None = None  # whose messages are read, others are passed over; None: not chosen

    def joint_of(self, layout: Layout) -> str | None:
        """Whose number is read in a message; None where it is not by a joint's name."""
        names = layout.texts.get("name", ())
        return (JOINT if JOINT in names else names[0]) if self.is_by_name and names else None

    def passes_over(self, layout: Layout) -> bool:
        """Whether a message is of another joint than the one that is read."""
        return self.joint is not None and self.is_by_name and self.joint_of(layout) != self.joint

    @property
    def is_by_name(self) -> bool:
        """Whether it is the number of a joint, wherever that one's name stands in a message."""
        return self.topic.type == JOINT_STATE and (self.field or "position") in BY_NAME

    def place(self, layout: Layout) -> Place | None:
        """The quantity's number in a message; LayoutError if it is needed and not there."""
        try:
            return layout.place(self._path(layout))
        except LayoutError:
            if self.needed:
                raise
            return None

    def _path(self, layout: Layout) -> str:
        if self.topic.type == JOINT_STATE:
            path = self.field or JOINT_FIELDS[self.quantity]
            names = layout.texts.get("name", [])
            if path not in BY_NAME:
                return path
            if JOINT in names:
                return f"{path}[{names.index(JOINT)}]"
            if len(names) > 1:
                listed = ", ".join(names)
                raise LayoutError(
                    f"has the joints {listed}, no {JOINT!r}; choose one, as {path}[0]"
                )
            return f"{path}[0]"
        if self.field is not None:
            return self.field
        if "data" in layout.places:
            return "data"
        if len(layout.places) == 1:
            return next(iter(layout.places))
        known = ", ".join(layout.places)
        raise LayoutError(f"has several numbers; choose one as {self.topic.name}:FIELD of {known}")


class Series(NamedTuple):
    """The numbers of one topic, in order of receipt: shapes (n,), (n,) and (n, numbers)."""

    received: Integers  # ns
    stamps: Integers | None  # ns; None where the messages carry none
    values: Array


def read_bag(path: str | Path, mapping: Mapping, *, needs_displacement: bool) -> Recording:
    """Read a bag; MicrogripperError says what is wrong with it and what it holds instead."""
    if mapping.time is not None:
        raise MicrogripperError(f"{path}: --map time= is for CSV; a bag's messages are stamped")
    with Bag(path) as bag:
        try:
            return _recording(bag, mapping, needs_displacement)
        except MicrogripperError as error:
            if not bag.warnings:
                raise
            raise MicrogripperError(f"{error} ({'; '.join(bag.warnings)})") from None


def _recording(bag: Bag, mapping: Mapping, needs_displacement: bool) -> Recording:
    notes: list[str] = []
    voltage = _choose(bag, "voltage", mapping.voltage, True, notes)
    displacement = _choose(bag, "displacement", mapping.displacement, needs_displacement, notes)
    setpoint = _choose(bag, "setpoint", mapping.setpoint, False, notes)
    assert voltage is not None  # it is needed: _choose would have raised
    if displacement is None or displacement.topic == voltage.topic:
        received, samples = _one_topic(bag, voltage, displacement, notes)
    else:
        received, samples = _two_topics(bag, voltage, displacement, notes)
    position = samples.displacement
    if not needs_displacement and position is not None and np.all(np.isnan(position)):
        samples = replace(samples, displacement=None)
    if setpoint is not None:
        try:
            samples = replace(
                samples, setpoint=_setpoint_of_samples(bag, setpoint, received, notes)
            )
        except MicrogripperError as error:
            if setpoint.needed:
                raise
            notes.append(f"setpoint not read: {error}")
    return on_uniform_clock(str(bag.path), samples, (*bag.warnings, *notes))


def _choose(
    bag: Bag, quantity: str, source: Source | None, needed: bool, notes: list[str]
) -> Choice | None:
    """Find the quantity's topic, the mapped or the usual one, in any namespace."""
    name, kind = (source.name, None) if source else USUAL_TOPICS[quantity]
    bare = name.lstrip("/")
    found = [
        topic
        for topic in bag.topics
        if f"/{topic.name}".endswith(f"/{bare}") and kind in (None, topic.type)
    ]
    if source is not None:
        needed = True
        found = [topic for topic in found if topic.name.lstrip("/") == bare] or found
    if len(found) == 1:
        field, scale = (source.field, source.scale) if source else (None, 1.0)
        return Choice(quantity, found[0], field, scale, needed)
    listed = ", ".join(str(topic) for topic in found or bag.topics) or "no topics"
    remedy = f"choose one with --map {quantity}=TOPIC[:FIELD]"
    if found:
        problem = f"several topics match {name}: {listed}; {remedy}"
    else:
        problem = f"no topic {name}{f' ({kind})' if kind else ''}; it has {listed}; {remedy}"
    if needed:
        raise MicrogripperError(f"{bag.path}: {problem}")
    if found:
        notes.append(problem)
    return None


def _series(bag: Bag, notes: list[str], *choices: Choice) -> Series:
    """Read quantities that are on one topic.

    Where drivers share a topic, each with joints of its own, the finger's messages are read.
    """
    drivers: set[Names] = set()
    series, others = _numbers(bag, [replace(choice, joint=JOINT) for choice in choices], drivers)
    if others and not drivers:  # the only joint may have any name
        series, others = _numbers(bag, choices, drivers)
    _refuse_mixed(bag, choices, drivers)
    if others:
        notes.append(f"{choices[0].topic.name}: {others} messages are of other joints")
    return series


def _refuse_mixed(bag: Bag, choices: Sequence[Choice], drivers: set[Names]) -> None:
    """Raise MicrogripperError where what was read is not of one joint in all messages."""
    by_name = all(choice.is_by_name for choice in choices)
    if len(drivers) > 1 and not (by_name and all(JOINT in names for names in drivers)):
        listed = ", ".join(sorted("+".join(names) or "no joint" for names in drivers))
        raise MicrogripperError(
            f"{bag.path}: topic {choices[0].topic.name} has messages of {listed}; call the one to "
            f"be read {JOINT!r} and map it without an index, or record it on a topic of its own"
        )


def _numbers(bag: Bag, choices: Sequence[Choice], drivers: set[Names]) -> tuple[Series, int]:
    """The numbers of a topic's messages, and how many of these are passed over.

    The joints' names of the messages that are read are added to `drivers`.
    """

    def pick(layout: Layout) -> list[Place | None]:
        if any(choice.passes_over(layout) for choice in choices):
            return [None] * (2 + len(choices))
        if topic.type == JOINT_STATE:
            drivers.add(tuple(layout.texts.get("name", ())))
        stamp = [layout.places.get(f"header.stamp.{part}") for part in ("sec", "nanosec")]
        return [*stamp, *(choice.place(layout) for choice in choices)]

    topic, scales = choices[0].topic, np.array([choice.scale for choice in choices])
    received, stamps, values = [np.empty(0, np.int64)], [np.empty(0, np.int64)], []
    others = 0
    # By the block all of it stays in the processor's cache, which a long bag's table would not.
    for times, table in values_by_block(bag, topic, pick):
        passed_over = np.isnan(table[:, 0]) & (topic.type == JOINT_STATE)  # its header has a stamp
        if passed_over.any():
            others += int(np.count_nonzero(passed_over))
            times, table = times[~passed_over], table[~passed_over]
        seconds, nanoseconds = np.nan_to_num(table[:, :2]).T.astype(np.int64)  # NaN: no stamps
        received.append(times)
        stamps.append(seconds * 10**9 + nanoseconds)
        values.append(table[:, 2:] * scales)
    if not values:
        if not choices[0].needed:
            return Series(received[0], None, np.empty((0, len(choices)))), 0
        raise MicrogripperError(f"{bag.path}: topic {topic} holds no messages")
    stamped = any(map(np.any, stamps))
    series = Series(
        np.concatenate(received),
        np.concatenate(stamps) if stamped else None,
        np.concatenate(values),
    )
    return _in_order_of_receipt(series), others


def _in_order_of_receipt(series: Series) -> Series:
    received, stamps, values = series
    if np.all(received[1:] >= received[:-1]):
        return series
    order = np.argsort(received, kind="stable")
    return Series(received[order], None if stamps is None else stamps[order], values[order])


def _one_topic(
    bag: Bag, voltage: Choice, displacement: Choice | None, notes: list[str]
) -> tuple[Integers, Samples]:
    series = _series(bag, notes, voltage, *([displacement] if displacement else []))
    stamps = series.stamps
    if stamps is None:
        notes.append(f"{voltage.topic.name} carries no stamps: the times of receipt were used")
        stamps = series.received
    position = series.values[:, 1] if displacement else None
    return series.received, _samples(stamps, series.values[:, 0], position)


def _two_topics(
    bag: Bag, voltage: Choice, displacement: Choice, notes: list[str]
) -> tuple[Integers, Samples]:
    drive, answer = _series(bag, notes, voltage), _series(bag, notes, displacement)
    if not displacement.needed and not len(answer.received):
        return _one_topic(bag, voltage, None, notes)
    if drive.stamps is None or answer.stamps is None:
        clock, given, of = answer.received, drive.received, "time of receipt"
    else:
        clock, given, of = answer.stamps, drive.stamps, "stamp"
    tolerance = SAME_INSTANT * np.median(np.diff(clock)) if len(clock) > 1 else 0.0
    notes.append(
        f"voltage ({voltage.topic.name}) and displacement ({displacement.topic.name}) come apart: "
        f"each displacement was given the newest voltage by {of}"
    )
    order = np.argsort(given, kind="stable")
    newest = np.searchsorted(given[order], clock + int(tolerance), side="right") - 1
    known = _known(given[order], clock - tolerance, newest, notes)
    values = drive.values[order, 0][newest[known]]
    return answer.received[known], _samples(clock[known], values, answer.values[known, 0])


def _known(given: Integers, clock: Array, newest: Integers, notes: list[str]) -> NDArray[np.bool_]:
    """Which displacements have the voltage that was applied, shape (displacements,).

    That at `clock[i]` (ns) has the one of `given[newest[i]]` (ns, rising), or none if it is -1.
    """
    known = newest >= 0
    if not np.all(known):
        notes.append(f"dropped before the first voltage: {np.count_nonzero(~known)} samples")
    late = known & (clock - given[newest] > _longest_hold(given))
    if np.any(late):
        count = np.count_nonzero(late)
        notes.append(f"no voltage in time for {count} displacements; they were left out")
        known &= ~late
    unused = len(given) - len(np.unique(newest[known]))
    if unused > MOST_UNUSED * len(given):
        notes.append(
            f"{unused} of {len(given)} voltages were not used: no displacement was read at them"
        )
    return known


def _longest_hold(given: Integers) -> float:
    """How long a voltage of rising times (ns) may stand, ns: for ever if no clock sends it."""
    intervals = np.diff(given)
    if len(intervals) < FEWEST:
        return np.inf
    period = float(np.median(intervals))
    return LONGEST_HOLD * period if np.quantile(intervals, 0.9) < 2.0 * period else np.inf


def _samples(stamps: Integers, voltage: Array, displacement: Array | None) -> Samples:
    first = stamps[0] if len(stamps) else 0
    return Samples((stamps - first) / 1e9, voltage, displacement, origin=float(first) / 1e9)


def _setpoint_of_samples(
    bag: Bag, choice: Choice, received: Integers, notes: list[str]
) -> Array | None:
    """The setpoint that answers each sample: the newest before the next sample; NaN if none yet."""
    series = _series(bag, notes, choice)
    if not len(series.received):
        return None
    newest = np.searchsorted(series.received, received[1:], side="left") - 1
    newest = np.append(newest, len(series.received) - 1)
    return np.where(newest >= 0, series.values[newest, 0], np.nan)
