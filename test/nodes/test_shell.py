from __future__ import annotations

import signal
from pathlib import Path

import pytest
from running_nodes import Start

from microgripper_control.nodes import shell
from microgripper_control.nodes.controller import ControllerNode
from microgripper_control.nodes.diagnoser import Diagnoser
from microgripper_control.nodes.identifier import Identifier
from microgripper_control.nodes.plant_simulator import PlantSimulator
from microgripper_control.nodes.player import Player
from microgripper_control.nodes.recorder import Recorder
from microgripper_control.nodes.reference import Reference
from microgripper_control.nodes.shell import Shell, run

pytestmark = pytest.mark.ros

BAD = [
    (PlantSimulator, ["sample_rate:=-5"], "sample_rate = -5 is outside its range 0.1 .. 20000 Hz"),
    (PlantSimulator, ["model_file:=nowhere.yaml"], "nowhere.yaml: cannot be read"),
    (PlantSimulator, ["lockstep:=7"], "'lockstep' to '7' of type 'INTEGER', expecting type 'BOOL'"),
    (PlantSimulator, ["noise_std:=much"], "noise_std: 'much' is not a number"),
    (ControllerNode, ["kp:=-1"], "kp = -1 is outside its range"),
    (ControllerNode, ["mode:=sideways"], "mode: 'sideways' is none of open_loop, feedforward"),
    (ControllerNode, ["voltage_max:=200"], "exceed the model's voltage range 0 .. 160 V"),
    (ControllerNode, ["safe_voltage:=155", "voltage_max:=150"], "safe = 155 V must lie within"),
    (Reference, ["shape:=circle"], "shape: 'circle' is none of step, staircase"),
    (Reference, ["frequency:=-1"], "frequency = -1 is outside its range"),
    (Reference, ["shape:=csv", "file:=nowhere.csv"], "nowhere.csv: cannot be read"),
    (Reference, ["shape:=csv"], "file is empty: name a CSV, -p file:=PATH"),
    (Reference, ["segments:=[a]"], "a.length: a segment needs one"),
    (Reference, ["shape:=multisine", "highest:=900"], "end below 500 Hz"),
    (Recorder, ["out:=."], "exists already"),
    (Recorder, ["storage:=tape"], "storage: 'tape' is none of mcap, sqlite3"),
    (Player, [], "recording is empty"),
    (Player, ["recording:=nowhere"], "nowhere: does not exist"),
    (Diagnoser, ["window:=1"], "window = 1 is outside its range 2 .. 600 s"),
    (Diagnoser, ["model_file:=nowhere.yaml"], "nowhere.yaml: cannot be read"),
    (Identifier, [], "recordings is empty"),
    (Identifier, ["recordings:=[nowhere]"], "nowhere: does not exist"),
    (PlantSimulator, [":=5"], "parameter override"),
]


@pytest.mark.parametrize(("make", "given", "message"), BAD, ids=lambda value: str(value)[:40])
def test_bad_input_gets_one_line_and_exit_status_2(
    ros_domain: dict[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    make: type[Shell],
    given: list[str],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    before = signal.getsignal(signal.SIGTERM)
    words = ["--ros-args", *(word for one in given for word in ("-p", one))]
    status, _, err = asked(monkeypatch, capfd, *words, make=make)
    assert status == 2
    # The last line: the middleware may have had something to say before.
    (line,) = err.splitlines()[-1:]
    assert message in line
    assert not list(tmp_path.glob("[!r]*")), "half-written files"
    assert signal.getsignal(signal.SIGTERM) == before


def asked(
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    *words: str,
    make: type[Shell] = ControllerNode,
) -> tuple[object, str, str]:
    """The exit status of a node that is called with words of no node, and what it prints."""
    monkeypatch.setattr(shell, "end_within", lambda seconds, status: None)  # this process goes on
    with pytest.raises(SystemExit) as ending:
        run(make, list(words))
    printed = capfd.readouterr()
    return ending.value.code, printed.out, printed.err


def test_asked_for_help_it_says_what_its_parameters_are_and_does_nothing(
    ros_domain: dict[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    status, out, err = asked(monkeypatch, capfd, "--help", "--ros-args", "-p", "kp:=-1")
    assert status == 0
    assert out.startswith("usage: controller --ros-args")
    assert (
        "  voltage_rate (now 20000.0)\n      fastest change while controlling, V/s; 1 .. 1e+09"
        in out
    )
    assert "qos_overrides" not in out
    assert "kp = -1 is outside its range" in err
    assert "ready" not in err


@pytest.mark.parametrize(
    "make",
    [PlantSimulator, ControllerNode, Reference, Recorder, Player, Diagnoser, Identifier],
)
def test_help_is_had_without_parameters_and_leaves_nothing_behind(
    ros_domain: dict[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    make: type[Shell],
) -> None:
    monkeypatch.chdir(tmp_path)
    status, out, _ = asked(monkeypatch, capfd, "--help", make=make)
    assert status == 0
    assert out.startswith("usage: ")
    assert [path.name for path in tmp_path.iterdir()] in ([], ["ros_log"])


def test_help_is_about_the_parameters_that_are_asked_for(
    ros_domain: dict[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    words = ("--help", "--ros-args", "-p", "segments:=[wave]", "-p", "wave.length:=2.0")
    status, out, _ = asked(monkeypatch, capfd, *words, make=Reference)
    assert status == 0
    assert "  wave.frequency (now 1.0)\n" in out
    words = ("--help", "--ros-args", "-p", "shape:=multisine")
    status, out, _ = asked(monkeypatch, capfd, *words, make=Reference)
    assert status == 0
    assert "  shape (now 'multisine')\n" in out
    assert "  highest (now " in out


def test_a_word_that_no_node_knows_is_refused(
    ros_domain: dict[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    status, _, err = asked(monkeypatch, capfd, "sideways")
    assert status == 2
    assert err.endswith("unknown argument 'sideways'; see --help\n")


def test_a_parameter_that_it_has_not_is_told(start: Start) -> None:
    controller = start("controller", voltage_mx=60.0, kp=5)
    controller.until_it_says("ready")
    assert "voltage_mx: there is no such parameter, it is ignored" in controller.log
    assert "did you mean voltage_max?" in controller.log
    assert "kp:" not in controller.log


def test_every_node_ends_by_signal_with_exit_status_0(
    hangup: None, start: Start, tmp_path: Path
) -> None:
    save = tmp_path / "wave.csv"
    save.write_text("time_s,voltage_V\n" + "".join(f"{k / 1000},{k % 50}\n" for k in range(100)))
    nodes = [
        start("plant_simulator"),
        start("controller"),
        start("reference"),
        start("recorder"),
        start("diagnoser"),
        start("player", recording=str(save), pace="samples", partners=["nobody"]),
    ]
    for node in nodes:
        node.until_it_says("starting")
    for number, node in enumerate(nodes):
        asked = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)[number % 3]
        assert node.stop(asked) == 0, node.name
