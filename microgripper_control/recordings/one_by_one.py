"""A bag's samples by rosbags alone, message by message: slow, and shares no code with our reader.

What reading in bulk is measured against, and checked with.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from microgripper_control.core.signals import Array
from microgripper_control.recordings.bag_recording import JOINT_STATE


def read_one_by_one(path: str | Path) -> tuple[Array, Array, Array]:
    """Time, s, voltage, V, and displacement, m, of `joint_states` of one joint, shape (n,) each."""
    store = get_typestore(Stores.ROS2_JAZZY)
    time, voltage, displacement = [], [], []
    with AnyReader([Path(path)], default_typestore=store) as reader:
        wanted = [c for c in reader.connections if c.msgtype == JOINT_STATE]
        for connection, _, raw in reader.messages(wanted):
            message = cast(Any, reader.deserialize(raw, connection.msgtype))
            stamp = message.header.stamp
            time.append(stamp.sec + 1e-9 * stamp.nanosec)
            voltage.append(message.effort[0])
            displacement.append(message.position[0])
    return np.array(time), np.array(voltage), np.array(displacement)
