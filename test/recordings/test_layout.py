"""The library's own serializer and deserializer are the truth here."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from microgripper_control.recordings.layout import Layout, LayoutError, types_of
from microgripper_control.recordings.storage import Block, Topic
from microgripper_control.recordings.values import block_values

STORE = get_typestore(Stores.ROS2_JAZZY)
JOINT_STATE = "sensor_msgs/msg/JointState"
DEFINITION = """\
bool on
my_rig/Channel[] channels
float32[3] gains
string<=9 note
int16 level
================================================================================
MSG: my_rig/Channel
string name
float64 reading
uint8[<=4] raw
int64 count
"""

names = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=9)
doubles = npst.arrays(np.float64, st.integers(0, 4), elements=st.floats(allow_nan=False))


def numbers(message: bytes, topic: Topic, *paths: str) -> list[float]:
    layout = Layout.of(message, topic.type, types_of(topic))
    found = []
    for path in paths:
        place = layout.place(path)
        found.append(float(np.frombuffer(message, place.dtype, 1, place.offset)[0]))
    return found


@settings(deadline=None)
@given(
    stamp=st.tuples(st.integers(-(2**31), 2**31 - 1), st.integers(0, 10**9 - 1)),
    frame=names,
    joints=st.lists(names, max_size=3),
    arrays=st.tuples(doubles, doubles, doubles),
    little=st.booleans(),
)
def test_any_joint_state(
    stamp: tuple[int, int],
    frame: str,
    joints: list[str],
    arrays: tuple[np.ndarray, np.ndarray, np.ndarray],
    little: bool,
) -> None:
    types = STORE.types
    message = types[JOINT_STATE](
        types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](*stamp), frame),
        joints,
        *arrays,
    )
    serialized = bytes(STORE.serialize_cdr(message, JOINT_STATE, little_endian=little))
    topic = Topic("/joint_states", JOINT_STATE)
    assert numbers(serialized, topic, "header.stamp.sec", "header.stamp.nanosec") == list(stamp)
    layout = Layout.of(serialized, JOINT_STATE, types_of(topic))
    assert layout.size == len(serialized)
    assert layout.texts["name"] == joints
    for name, values in zip(("position", "velocity", "effort"), arrays, strict=True):
        paths = [f"{name}[{index}]" for index in range(len(values))]
        assert numbers(serialized, topic, *paths) == values.tolist()
        with pytest.raises(LayoutError, match=f"{len(values)} numbers"):
            layout.place(f"{name}[{len(values)}]")


@settings(deadline=None)
@given(
    channels=st.lists(
        st.tuples(
            names,
            st.floats(allow_nan=False),
            st.binary(max_size=4),
            st.integers(-(2**53), 2**53),
        ),
        max_size=3,
    ),
    note=names,
    level=st.integers(-(2**15), 2**15 - 1),
)
def test_a_type_that_only_the_bag_defines(
    channels: list[tuple[str, float, bytes, int]], note: str, level: int
) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(DEFINITION, "my_rig/msg/Sample"))
    message = store.types["my_rig/msg/Sample"](
        True,
        [
            store.types["my_rig/msg/Channel"](name, reading, np.frombuffer(raw, np.uint8), count)
            for name, reading, raw, count in channels
        ],
        np.array([1.0, 2.0, 3.0], np.float32),
        note,
        level,
    )
    serialized = bytes(store.serialize_cdr(message, "my_rig/msg/Sample"))
    topic = Topic("/sample", "my_rig/msg/Sample", definition=DEFINITION)
    assert numbers(serialized, topic, "on", "gains[1]", "level") == [1.0, 2.0, level]
    for index, (_, reading, _, count) in enumerate(channels):
        where = f"channels[{index}]"
        assert numbers(serialized, topic, f"{where}.reading", f"{where}.count") == [reading, count]


def joint_state(position: float, effort: list[float], frame: str = "") -> bytes:
    types = STORE.types
    message = types[JOINT_STATE](
        types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](0, 0), frame),
        ["finger"],
        np.array([position]),
        np.empty(0),
        np.array(effort),
    )
    return bytes(STORE.serialize_cdr(message, JOINT_STATE))


def test_messages_of_different_layouts_in_one_block() -> None:
    topic = Topic("/joint_states", JOINT_STATE)
    messages = [joint_state(float(k), [float(-k)] * (1 + k % 2), "x" * (k % 3)) for k in range(30)]
    block = Block.of(topic, range(30), messages)
    values = block_values(
        block,
        types_of(topic),
        lambda layout: [layout.place("position"), None, layout.place("effort[0]")],
        0,
    )
    assert np.array_equal(values[:, 0], np.arange(30.0))
    assert np.isnan(values[:, 1]).all()
    assert np.array_equal(values[:, 2], -np.arange(30.0))


def test_a_bad_message_is_counted() -> None:
    topic = Topic("/joint_states", JOINT_STATE)
    messages = [joint_state(1.0, [1.0]) for _ in range(9)]
    messages[4] = joint_state(1.0, [])
    block = Block.of(topic, range(9), messages)
    with pytest.raises(LayoutError, match=r"in message 104 has 0 numbers in effort"):
        block_values(block, types_of(topic), lambda layout: [layout.place("effort[0]")], 100)


def test_a_message_cut_off_anywhere() -> None:
    whole = joint_state(1.0, [1.0, 2.0])
    types = types_of(Topic("/joint_states", JOINT_STATE))
    assert Layout.of(whole, JOINT_STATE, types).size == len(whole)
    for length in range(len(whole)):
        with pytest.raises(LayoutError, match=r"shorter than its type|not plain CDR"):
            Layout.of(whole[:length], JOINT_STATE, types)


@settings(deadline=None, max_examples=300)
@given(st.binary(max_size=120))
def test_noise_is_no_message(noise: bytes) -> None:
    topic = Topic("/sample", "my_rig/msg/Sample", definition=DEFINITION)
    for kind in (topic.type, JOINT_STATE, "diagnostic_msgs/msg/DiagnosticArray"):
        with suppress(LayoutError):  # and nothing else
            assert Layout.of(b"\0\1\0\0" + noise, kind, types_of(topic)).size <= 4 + len(noise)


@pytest.mark.parametrize(
    ("topic", "complaint"),
    [
        (Topic("/a", "my_rig/msg/Other"), "neither ROS 2 Jazzy nor the bag defines"),
        (Topic("/a", "my_rig/msg/Other", definition="float64 ??"), "is not understood"),
        (Topic("/a", JOINT_STATE, encoding="ros1"), "is encoded as 'ros1'"),
    ],
)
def test_types_that_are_not_known(topic: Topic, complaint: str) -> None:
    with pytest.raises(LayoutError, match=complaint):
        types_of(topic)


def test_the_bag_s_definition_goes_before_that_of_jazzy() -> None:
    topic = Topic("/a", "std_msgs/msg/Float64", definition="float32 before\nfloat64 data\n")
    fields = [name for name, _ in types_of(topic)[topic.type][1]]
    assert fields == ["before", "data"]
    damaged = replace(topic, definition="float64 ??")
    assert [name for name, _ in types_of(damaged)[topic.type][1]] == ["data"]


def test_a_field_that_is_not_there_lists_those_that_are() -> None:
    message = bytes(
        STORE.serialize_cdr(STORE.types["std_msgs/msg/Float64"](1.0), "std_msgs/msg/Float64")
    )
    layout = Layout.of(message, "std_msgs/msg/Float64", types_of(Topic("/a", JOINT_STATE)))
    with pytest.raises(LayoutError, match="has no number volts; it has data"):
        layout.place("volts")
    with pytest.raises(LayoutError, match=r"has no number volts\[3\]; it has data"):
        layout.place("volts[3]")


def test_messages_are_like_the_first_where_they_are_long_enough_and_share_its_bytes() -> None:
    messages = [b"abcd", b"abXd", b"aXcd", b"abc", b"abcdX", b""]
    block = Block.of(Topic("t", "k"), range(6), messages)
    found = block.like_first(np.array([0, 1, 3]), 4)
    assert found.tolist() == [True, True, False, False, True, False]


@pytest.mark.parametrize(("received", "messages"), [([1.5], [b"a"]), ([1], ["a"]), ([1], [None])])
def test_a_block_takes_whole_times_and_bytes_alone(received: list, messages: list) -> None:
    with pytest.raises(TypeError):
        Block.of(Topic("t", "k"), received, messages)
