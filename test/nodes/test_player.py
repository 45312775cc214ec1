from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from running_nodes import Start, Watcher
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from microgripper_control.core.recording import Recording
from microgripper_control.plant.model import nominal_model
from microgripper_control.plant.simulate import Initial, simulate
from microgripper_control.recordings.bag_writer import BagWriter
from microgripper_control.recordings.csv import write_csv
from microgripper_control.recordings.read import read_recording
from microgripper_control.recordings.write import write_bag

pytestmark = pytest.mark.ros

VOLTAGE = 70.0 + 50.0 * np.cos(2.0 * np.pi * np.arange(500) / 250.0)


@pytest.fixture
def recording() -> Recording:
    displacement = simulate(nominal_model(), VOLTAGE, 1e-3, initial=Initial.FIRST_SAMPLE)
    return Recording("made", 1e-3, VOLTAGE, displacement, setpoint=displacement + 1e-8)


def test_what_is_played_can_be_recorded_again(
    start: Start, watcher: Watcher, tmp_path: Path, recording: Recording
) -> None:
    write_bag(tmp_path / "bag", recording)
    recorder = start("recorder", out="again")
    player = start("player", recording="bag", rate=2, partners=["recorder"])
    assert player.ended() == 0
    assert "1000 messages played" in player.log
    assert recorder.stop() == 0
    again = read_recording(tmp_path / "again")
    for quantity in ("voltage", "displacement", "setpoint"):
        np.testing.assert_array_equal(getattr(again, quantity), getattr(recording, quantity))


def test_whoever_listens_already_gets_it_from_the_first_message_on(
    start: Start, tmp_path: Path, recording: Recording
) -> None:
    """Without a partner named: what is sent before it has found anybody is lost to all."""
    write_bag(tmp_path / "bag", recording)
    recorder = start("recorder", out="again")
    recorder.until_it_says("ready")
    assert start("player", recording="bag").ended() == 0
    assert recorder.stop() == 0
    np.testing.assert_array_equal(read_recording(tmp_path / "again").measured, recording.measured)


def test_an_empty_bag_has_nothing_to_play(start: Start, tmp_path: Path) -> None:
    BagWriter(tmp_path / "bag").close()
    player = start("player", recording="bag")
    assert player.ended() != 0
    assert "bag: has no messages; record it again" in player.log


def test_chosen_topics_in_their_own_time(
    start: Start, watcher: Watcher, tmp_path: Path, recording: Recording
) -> None:
    write_bag(tmp_path / "bag", recording)
    states = watcher.messages(JointState, "joint_states")
    setpoints = watcher.messages(Float64, "setpoint")
    player = start("player", recording="bag", topics=["setpoint"], partners=["watcher"])
    watcher.until(lambda: len(setpoints) == len(recording), "all setpoints")
    assert player.ended() == 0
    assert recording.setpoint is not None
    np.testing.assert_array_equal([s.data for s in setpoints], recording.setpoint)
    assert not states


@pytest.mark.parametrize("kind", ["bag", "csv"])
def test_a_plant_gets_the_recorded_voltages_sample_by_sample(
    start: Start, tmp_path: Path, recording: Recording, kind: str
) -> None:
    file = tmp_path / f"recorded.{kind}"
    (write_bag if kind == "bag" else write_csv)(file, recording)
    recorder = start("recorder", out="again")
    player = start(
        "player", recording=str(file), pace="samples", partners=["plant_simulator", "recorder"]
    )
    plant = start(
        "plant_simulator",
        lockstep=True,
        partners=["player", "recorder"],
        noise_std=0,
        initial_voltage=VOLTAGE[0],
        duration=0.5,
    )
    assert plant.ended() == 0
    assert player.ended() == 0
    assert recorder.stop() == 0
    again = read_recording(tmp_path / "again")
    np.testing.assert_array_equal(again.voltage, recording.voltage)
    np.testing.assert_array_equal(again.measured, recording.measured)


def test_a_plant_of_another_rate_is_refused(
    start: Start, tmp_path: Path, recording: Recording
) -> None:
    """Every fifth voltage of a recording at 5 kHz would reach a plant at 1 kHz."""
    fast = replace(recording, sample_period=2e-4)
    write_csv(tmp_path / "fast.csv", fast)
    player = start("player", recording="fast.csv", pace="samples", partners=["plant_simulator"])
    start("plant_simulator", lockstep=True, partners=["player"], lockstep_timeout=2)
    assert player.ended() == 2
    assert "the plant samples at 1000 Hz, the recording at 5000 Hz" in player.log
