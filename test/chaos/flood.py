"""Hostile messages over DDS, as fast as they go, into a loop that is at work."""

from __future__ import annotations

import random
import signal
import time

import rclpy
from hostile import Hostile
from loop import Loop, NotTrackingError
from nursery import Nursery
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from table import Row

from microgripper_control.nodes import qos, topics

POOL = 1000  # messages
PAUSE = 5e-4  # s: a flood in which nothing gets through at all would prove less
GROWTH = 30e6  # bytes; the middleware keeps the last 5000 messages of a publisher


def flood(nursery: Nursery, loop: Loop, length: float, seed: int) -> Row:
    """For `length` s; the controller and the reference hear them, the rig hears the controller."""
    row = Row("hostile messages, over DDS")
    loop.tracks()
    before = {name: child.memory for name, child in loop.nodes.items()}
    child = nursery.fork("hostile", lambda: _flood(seed))
    time.sleep(length)
    child.send(signal.SIGTERM)
    child.wait(5.0)
    ends = time.time()
    row.injected = int(child.log.read_text().split()[-1])
    faults = [f"ended: {one}" for one in loop.dead()]
    try:
        row.recoveries.append(loop.tracks_since(ends) - ends)
    except NotTrackingError as error:
        faults.append(str(error))
    if not faults:
        grown = {name: loop.nodes[name].memory - before[name] for name in before}
        faults += [f"{name} grew by {1e-6 * n:.0f} MB" for name, n in grown.items() if n > GROWTH]
        row.remarks.append(f"memory at worst {max(grown.values()) / 1e6:+.1f} MB")
    invariants = loop.witness.account()
    faults += invariants.described
    row.saw(invariants)
    row.survived = 0 if faults else row.injected
    row.notes += faults
    return row


def _flood(seed: int) -> None:
    asked: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, frame: asked.append(number))
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = Node("hostile", namespace=topics.NAMESPACE)
    hostile = Hostile(random.Random(seed))
    samples = [hostile.sample() for _ in range(POOL)]
    numbers = [hostile.number() for _ in range(POOL)]
    targets = {
        topic: node.create_publisher(topics.TYPES[topic], topic, qos.quality(qos.KEPT))
        for topic in (topics.JOINT_STATES, topics.SETPOINT, topics.VOLTAGE_SETPOINT)
    }
    count = 0
    while not asked:
        for topic, publisher in targets.items():
            if topic == topics.JOINT_STATES:
                sample = samples[count % POOL]
                if count % 2:
                    stamp = sample.header.stamp
                    stamp.sec, stamp.nanosec = divmod(time.time_ns(), 10**9)
                publisher.publish(sample)
            else:
                publisher.publish(numbers[count % POOL])
            count += 1
        time.sleep(PAUSE)
    print(count)
