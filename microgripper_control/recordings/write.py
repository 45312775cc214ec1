"""Recordings out: a rosbag2 all at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rosbags.typesys import Stores, get_typestore

from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.recordings.bag_recording import FLOAT64, JOINT, JOINT_STATE
from microgripper_control.recordings.bag_writer import BagWriter

JOINT_STATES = "/microgripper/joint_states"
SETPOINT = "/microgripper/setpoint"


def write_bag(path: str | Path, recording: Recording, storage: str = "mcap") -> None:
    """Write `joint_states` and, if there is one, `setpoint`, as the plant and `reference` would.

    Each message is received at its stamp; a setpoint follows the sample that it answers by a
    quarter of the sample period. A recording that starts before 1970 is moved to begin there.
    Samples that were filled in are left out: whoever reads the bag fills them in and knows it.
    """
    store = get_typestore(Stores.ROS2_JAZZY)
    stamp, header = store.types["builtin_interfaces/msg/Time"], store.types["std_msgs/msg/Header"]
    joint_state, float64 = store.types[JOINT_STATE], store.types[FLOAT64]
    start, period = round(1e9 * max(recording.start, 0.0)), 1e9 * recording.sample_period  # ns
    ticks = start + np.rint(period * np.arange(len(recording))).astype(np.int64)
    positions = recording.displacement
    velocities = (
        None if positions is None else np.diff(positions, prepend=positions[0]) * 1e9 / period
    )
    with BagWriter(path, storage) as bag:
        bag.add_topic(JOINT_STATES, JOINT_STATE)
        if recording.setpoint is not None:
            bag.add_topic(SETPOINT, FLOAT64)
        for k in np.flatnonzero(recording.present).tolist():
            tick = int(ticks[k])
            message = joint_state(
                header=header(stamp=stamp(*divmod(tick, 10**9)), frame_id=""),
                name=[JOINT],
                position=_part(positions, k),
                velocity=_part(velocities, k),
                effort=_part(recording.voltage, k),
            )
            bag.write(JOINT_STATES, tick, bytes(store.serialize_cdr(message, JOINT_STATE)))
            if recording.setpoint is not None and np.isfinite(recording.setpoint[k]):
                wanted = float64(data=float(recording.setpoint[k]))
                after = tick + int(period / 4)
                bag.write(SETPOINT, after, bytes(store.serialize_cdr(wanted, FLOAT64)))


def _part(samples: Array | None, index: int) -> Array:
    """One sample as an array; empty where nothing was recorded."""
    return np.empty(0) if samples is None else samples[index : index + 1]
