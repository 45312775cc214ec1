"""The simulated rig's parameters, and the rig that they ask for."""

from __future__ import annotations

from dataclasses import replace

from rclpy.node import Node

from microgripper_control.control.limits import VoltageGuard, VoltageLimits
from microgripper_control.core.parameters import Parameter
from microgripper_control.effects.registry import link_named
from microgripper_control.nodes.parameters import (
    MODEL_FILE,
    MODEL_FILE_TEXT,
    declare_flag,
    declare_number,
    declare_numbers,
    declare_text,
    declare_texts,
    model_path,
)
from microgripper_control.nodes.rig_guard import RigGuard
from microgripper_control.plant.model_file import load_model
from microgripper_control.plant.rig import Rig

NOISE = link_named("sensor_noise")
NOISE_PARAMETERS = {"noise_std": "std", "seed": "seed"}  # of the node -> of the link
NUMBERS = (
    Parameter("sample_rate", "Hz", 1000.0, 0.1, 20000.0, "samples a second"),
    Parameter("duration", "s", 0.0, 0.0, 1e7, "end after so much of its own time; 0: never"),
    Parameter("startup_timeout", "s", 60.0, 0.1, 3600.0, "lockstep: longest wait for partners"),
    Parameter("lockstep_timeout", "s", 5.0, 0.01, 3600.0, "lockstep: longest wait for a command"),
)
COMMAND_TIMEOUT = Parameter(
    "command_timeout",
    "s",
    0.06,
    0.0,
    3600.0,
    "wall time: without voltage_command for so long the rig ramps to safe_voltage by itself; "
    "0: it holds the last one",
)
INITIAL_VOLTAGE = Parameter(
    "initial_voltage",
    "V",
    0.0,
    -1e4,
    1e4,
    "at which the rig rests when it begins; clipped to its range, as commands are",
)
GUARD = {"safe_voltage": "safe", "ramp_rate": "ramp_rate"}  # of the node -> of VoltageLimits


def declare(node: Node) -> None:
    """Declare the parameters; the noise not given is the model's, else the link's nominal one."""
    model_file = declare_text(node, "model_file", MODEL_FILE, MODEL_FILE_TEXT)
    declare_flag(node, "lockstep", False, "wait for the command that answers each sample")
    declare_texts(
        node,
        "partners",
        ["controller", "reference"],
        "lockstep: names of the nodes that must get joint_states before it begins",
    )
    declare_numbers(node, (*NUMBERS, COMMAND_TIMEOUT))
    model = load_model(model_path(model_file))
    low, high = model.voltage_range
    rest = min(max(0.0, low), high)
    limits = {parameter.name: parameter for parameter in VoltageLimits.parameters()}
    for name, field in GUARD.items():
        usual = limits[field]
        nominal = rest if field == "safe" else usual.nominal
        declare_number(node, replace(usual, name=name, nominal=nominal))
    declare_number(node, replace(INITIAL_VOLTAGE, nominal=rest))
    settings = model.settings.get(NOISE.name, {})
    for name, key in NOISE_PARAMETERS.items():
        declared = NOISE.parameter(key)
        nominal = settings[key].value if key in settings else declared.nominal
        declare_number(node, replace(declared, name=name, nominal=nominal))


def make_rig(node: Node) -> Rig:
    """The rig that the parameters ask for, compiled; MicrogripperError where there is none."""
    model = load_model(model_path(node.get_parameter("model_file").value))
    for warning in model.warnings:
        node.get_logger().warning(warning)
    noise = {key: node.get_parameter(name).value for name, key in NOISE_PARAMETERS.items()}
    model = model.with_link(NOISE.name, **noise)
    period = 1.0 / node.get_parameter("sample_rate").value
    start = node.get_parameter(INITIAL_VOLTAGE.name).value
    Rig(model, period, start).tick()  # compiles; the one that runs draws its noise afresh
    return Rig(model, period, start)


def make_guard(node: Node, voltage: float) -> RigGuard:
    """The own guard of a rig that stands at `voltage`, V.

    Raises MicrogripperError where its safe voltage is none of the model's.
    """
    low, high = load_model(model_path(node.get_parameter("model_file").value)).voltage_range
    own = {field: node.get_parameter(name).value for name, field in GUARD.items()}
    limits = VoltageLimits(low=low, high=high, rate=own["ramp_rate"], **own)
    period = 1.0 / node.get_parameter("sample_rate").value
    patience = node.get_parameter(COMMAND_TIMEOUT.name).value
    return RigGuard(VoltageGuard(limits, period), patience, voltage)
