"""Hostile bags: a recording, a warning or one line, never a traceback, never silent loss."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from bags_to_break import RECORDING, agrees, check_line, recording_or_complaint, storage_file
from fuzzing import MUTATIONS, VALUES, fuzzed, mutated
from hypothesis import example, given
from hypothesis import strategies as st

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.recordings.bag_writer import STORAGES
from microgripper_control.recordings.layout import Layout, LayoutError, types_of
from microgripper_control.recordings.repair import repair_bag
from microgripper_control.recordings.storage import Topic
from microgripper_control.recordings.write import write_bag

pytestmark = pytest.mark.fuzz

COUNT = 30
START = Recording(
    "run", 1e-3, RECORDING.voltage[:COUNT], RECORDING.measured[:COUNT], RECORDING.voltage[:COUNT]
)
KINDS = ["sensor_msgs/msg/JointState", "diagnostic_msgs/msg/DiagnosticArray", "std_msgs/msg/Empty"]


class Broken:
    """A bag whose files are replaced over and over."""

    def __init__(self, path: Path, storage: str) -> None:
        self.path = path
        write_bag(path, START, storage)
        self.file, self.metadata = storage_file(path), path / "metadata.yaml"
        self.whole, self.told = self.file.read_bytes(), self.metadata.read_text()


@pytest.fixture(scope="module", params=STORAGES)
def bag(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Broken:
    return Broken(tmp_path_factory.mktemp("bags") / "run", request.param)


@fuzzed
@given(mutations=MUTATIONS, with_metadata=st.booleans())
def test_the_storage_file(
    bag: Broken, mutations: list[tuple[str, int, bytes]], with_metadata: bool
) -> None:
    bag.file.write_bytes(mutated(bag.whole, mutations))
    bag.metadata.write_text(bag.told)
    path = bag.path if with_metadata else bag.file
    found = recording_or_complaint(path)
    if found is not None and not found.warnings and bag.file.suffix == ".mcap":
        # Its chunks have checksums. SQLite has none: a value that changed is a value.
        assert agrees(found, START)
        assert len(found) == COUNT
        assert found.setpoint is not None
        np.testing.assert_array_equal(found.setpoint, START.setpoint)


@fuzzed
@given(mutations=MUTATIONS)
def test_repair(bag: Broken, mutations: list[tuple[str, int, bytes]]) -> None:
    bag.file.write_bytes(mutated(bag.whole, mutations))
    bag.metadata.write_text(bag.told)
    before = bag.file.read_bytes()
    try:
        done = repair_bag(bag.path)
    except MicrogripperError as error:
        check_line(str(error), bag.path)
        assert bag.file.read_bytes() == before
        return
    if done.kept is not None:
        assert repair_bag(bag.path).kept is None
        shutil.rmtree(bag.path)
        done.kept.rename(bag.path)
    assert bag.file.read_bytes() == before


@fuzzed
@given(mutations=MUTATIONS)
def test_the_text_of_the_metadata(bag: Broken, mutations: list[tuple[str, int, bytes]]) -> None:
    bag.file.write_bytes(bag.whole)
    bag.metadata.write_bytes(mutated(bag.told.encode(), mutations))
    found = recording_or_complaint(bag.path)
    assert found is None or len(found) == COUNT


@fuzzed
@given(
    key=st.sampled_from(
        ["", "version", "relative_file_paths", "topics_with_message_count", "compression_mode"]
    ),
    value=VALUES,
)
@example(key="relative_file_paths", value=["\0"])
@example(key="relative_file_paths", value=[""])
@example(key="version", value=float("inf"))
def test_the_values_of_the_metadata(bag: Broken, key: str, value: object) -> None:
    bag.file.write_bytes(bag.whole)
    told: dict[str, Any] = yaml.safe_load(bag.told)
    if key:
        told["rosbag2_bagfile_information"][key] = value
    else:
        told["rosbag2_bagfile_information"] = value
    bag.metadata.write_text(yaml.safe_dump(told), encoding="utf-8", errors="replace")
    found = recording_or_complaint(bag.path)
    assert found is None or len(found) == COUNT


@fuzzed
@given(kind=st.sampled_from(KINDS), content=st.binary(max_size=60))
def test_the_layout_of_a_message(kind: str, content: bytes) -> None:
    try:
        layout = Layout.of(b"\0\1\0\0" + content, kind, types_of(Topic("/a", kind)))
    except LayoutError:
        return
    assert layout.size <= 4 + len(content)


@fuzzed
@given(
    lines=st.lists(
        st.sampled_from(["int8 a", "string[999999999] b", "rig/E[4000000000] c", "rig/E[] d",
                         "rig/S[9] e", "int8[9] f", "float64 =", "int8 X=5", "MSG: rig/E",
                         80 * "=", "bool<3"])
        | st.text(max_size=10),
        max_size=8,
    ),
    content=st.binary(max_size=30),
)  # fmt: skip
@example(lines=["rig/E[99999999] c", 80 * "=", "MSG: rig/E", ""], content=b"")
def test_the_definition_of_a_type(lines: list[str], content: bytes) -> None:
    topic = Topic("/a", "rig/msg/S", definition="\n".join(lines))
    try:
        Layout.of(b"\0\1\0\0" + content, topic.type, types_of(topic))
    except LayoutError:
        return
