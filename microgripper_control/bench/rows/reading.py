"""Reading a bag of `joint_states`, against rosbags message by message."""

from __future__ import annotations

from functools import partial

from microgripper_control.bench import rig
from microgripper_control.bench.row import FASTER, Effort, Line, Measured, Row, at_least
from microgripper_control.bench.timing import Contestant, take_turns
from microgripper_control.plant.model import nominal_model
from microgripper_control.recordings.one_by_one import read_one_by_one
from microgripper_control.recordings.read import read_recording
from microgripper_control.recordings.write import write_bag

STORAGES = {"mcap": "MCAP", "sqlite3": "SQLite3"}
GOAL = at_least(10.0)


def measure(effort: Effort) -> Measured:
    """As `Row` says."""
    recording = rig.recording(nominal_model())
    count = len(recording)
    lines = []
    for storage, name in STORAGES.items():
        bag = effort.folder / f"bag_{storage}"
        write_bag(bag, recording, storage)
        times = take_turns(
            {
                "ours": Contestant(partial(read_recording, bag), count),
                "theirs": Contestant(partial(read_one_by_one, bag), count),
            },
            effort.few_rounds,
        )
        lines.append(
            Line(
                f"{name}, joint_states of one joint, per message",
                "rosbags, message by message",
                times.ratio("theirs", "ours"),
                FASTER,
                GOAL,
                times.of("ours").median,
                times.of("theirs").median,
            )
        )
    note = (
        f"{count} messages; the files lie in the operating system's cache. Ours also puts the "
        "samples on a uniform clock and checks them."
    )
    return Measured(tuple(lines), (note,))


ROW = Row("reading", "reading a bag", measure)
