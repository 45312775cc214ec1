"""The controller's parameters, and the control law that they ask for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from rclpy.node import Node

from microgripper_control.control.controller import Controller, Mode
from microgripper_control.control.feedforward import InverseKind
from microgripper_control.control.identified import Identified
from microgripper_control.control.limits import VoltageLimits
from microgripper_control.control.pid import PidGains
from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.parameters import Parameter
from microgripper_control.nodes.parameters import (
    MODEL_FILE,
    MODEL_FILE_TEXT,
    check_choice,
    declare_flag,
    declare_number,
    declare_numbers,
    declare_text,
    declare_texts,
    model_path,
)
from microgripper_control.nodes.setpoint_intake import OutOfReach, SetpointIntake, StreamLoss
from microgripper_control.plant.model_file import load_model

SAMPLE_RATE = Parameter("sample_rate", "Hz", 1000.0, 0.1, 20000.0, "of the plant")
WAITS = (
    Parameter(
        "setpoint_wait", "1", 0.5, 0.0, 1.0, "wall time: longest wait for a setpoint, in samples"
    ),
    Parameter("lockstep_timeout", "s", 5.0, 0.01, 3600.0, "lockstep: longest wait for a setpoint"),
)
FEEDBACK_TIMEOUT = Parameter(
    "feedback_timeout",
    "s",
    0.06,
    0.002,
    60.0,
    "wall time: without fresh joint_states for so long, ramp to safe_voltage",
)
APPLY_TIMEOUT = Parameter(
    "apply_timeout",
    "s",
    0.02,
    1e-3,
    60.0,
    "wall time: longest way of a voltage to the plant and back",
)
APPLY_TOLERANCE = Parameter(
    "apply_tolerance", "V", 1.0, 1e-6, 1e4, "wall time: how well the plant reports what it applies"
)
SETPOINT_TIMEOUT = Parameter(
    "setpoint_timeout",
    "s",
    0.2,
    0.0,
    60.0,
    "wall time: a stream of setpoints has stopped; 0: never",
)
OUT_OF_REACH, STREAM_LOSS = "setpoint_out_of_reach", "setpoint_loss"
LIMITS = {  # parameter of the node -> field of VoltageLimits
    "voltage_min": "low",
    "voltage_max": "high",
    "voltage_rate": "rate",
    "safe_voltage": "safe",
    "ramp_rate": "ramp_rate",
}
GAINS = tuple(parameter.name for parameter in PidGains.parameters())
ON_MEASUREMENT = "derivative_on_measurement"
LIVE = frozenset({"mode", "model_file", ON_MEASUREMENT, *GAINS})  # may change while it runs
NAMES = (*LIVE, *LIMITS, "inverse", SAMPLE_RATE.name)


@dataclass(frozen=True)
class ControllerSettings:
    """What the parameters say, checked: MicrogripperError names what is wrong with them."""

    mode: Mode
    inverse: InverseKind
    identified: Identified
    limits: VoltageLimits
    gains: PidGains
    sample_period: float  # s

    @classmethod
    def of(
        cls, values: Mapping[str, Any], identified: Identified | None = None
    ) -> ControllerSettings:
        """Of the values of the parameters NAMES; the model file is read unless it is known."""
        check_choice("mode", values["mode"], [mode.value for mode in Mode])
        check_choice("inverse", values["inverse"], [kind.value for kind in InverseKind])
        settings = cls(
            mode=Mode(values["mode"]),
            inverse=InverseKind(values["inverse"]),
            identified=identified or load_identified(values["model_file"]),
            limits=VoltageLimits(**{field: values[name] for name, field in LIMITS.items()}),
            gains=PidGains(**{name: values[name] for name in (*GAINS, ON_MEASUREMENT)}),
            sample_period=1.0 / values[SAMPLE_RATE.name],
        )
        settings.controller()  # checks what only together is wrong
        return settings

    def controller(self) -> Controller:
        """A controller at rest."""
        return Controller(
            self.identified,
            self.sample_period,
            limits=self.limits,
            gains=self.gains,
            mode=self.mode,
            inverse=self.inverse,
        )

    def compile(self) -> None:
        """Run every law once, so that no sample waits for the compiler."""
        for mode in Mode:
            controller = replace(self, mode=mode).controller()
            controller.start(self.limits.safe)
            for command in self.limits.low, 1e-6, 2e-6:
                controller.step(command, 0.0, self.limits.safe)

    def change(self, controller: Controller, before: ControllerSettings) -> None:
        """Bring a running controller from the settings before to these, where they may change."""
        if self.identified != before.identified:
            controller.set_identified(self.identified)
        if self.gains != before.gains:
            controller.set_gains(self.gains)
        controller.set_mode(self.mode)


def load_identified(model_file: str) -> Identified:
    """The values that a controller needs of the model in a file, its delays, lags and modes too."""
    model = load_model(model_path(model_file))
    material, mechanics = model.values("bouc_wen"), model.values("second_order")
    return Identified.from_values(
        material, mechanics, model.voltage_range, model.dead_time, model.ringing
    )


def declare(node: Node) -> None:
    """Declare all parameters of the controller."""
    _declare_law(node)
    declare_flag(node, "lockstep", False, "wait for the setpoint of each sample")
    declare_flag(node, "await_setpoint", True, "lockstep: false to use the newest setpoint")
    declare_texts(
        node,
        "partners",
        ["plant_simulator"],
        "lockstep: names of the nodes that must get voltage_command before it begins",
    )
    declare_numbers(
        node, (*WAITS, FEEDBACK_TIMEOUT, APPLY_TIMEOUT, APPLY_TOLERANCE, SETPOINT_TIMEOUT)
    )
    declare_text(
        node,
        OUT_OF_REACH,
        OutOfReach.CLAMP.value,
        "what to do with setpoints that cannot be reached; either way they are reported",
        choices=[one.value for one in OutOfReach],
    )
    declare_text(
        node,
        STREAM_LOSS,
        StreamLoss.HOLD.value,
        "when a stream of setpoints stops: hold the last one, or return to safe_voltage",
        choices=[one.value for one in StreamLoss],
    )


def make_intake(node: Node) -> SetpointIntake:
    """What takes setpoints in as the parameters say; in lockstep it waits for them, and no stop."""
    lockstep = node.get_parameter("lockstep").value
    return SetpointIntake(
        OutOfReach(node.get_parameter(OUT_OF_REACH).value),
        StreamLoss(node.get_parameter(STREAM_LOSS).value),
        0.0 if lockstep else node.get_parameter(SETPOINT_TIMEOUT.name).value,
    )


def _suited(
    identified: Identified, sample_period: float
) -> tuple[Controller, MicrogripperError | None]:
    """A controller with what suits a model; where no gains do, one without, and why."""
    try:
        return Controller(identified, sample_period), None
    except MicrogripperError as error:
        return Controller(identified, sample_period, gains=PidGains(ki=0.0)), error


def _declare_law(node: Node) -> None:
    """Declare the parameters NAMES; limits and gains not given are those that suit the model."""
    mode, kind = Mode.CASCADE, InverseKind.EXACT
    declare_text(
        node, "mode", mode.value, "control law; live", choices=[mode.value for mode in Mode]
    )
    declare_text(
        node,
        "inverse",
        kind.value,
        "how the feedforward inverts the model",
        choices=[kind.value for kind in InverseKind],
    )
    name = declare_text(node, "model_file", MODEL_FILE, f"{MODEL_FILE_TEXT}; live")
    rate = declare_number(node, SAMPLE_RATE)
    suited, fault = _suited(load_identified(name), 1.0 / rate)
    limits = {parameter.name: parameter for parameter in VoltageLimits.parameters()}
    for name, field in LIMITS.items():
        nominal = getattr(suited.guard.limits, field)
        declare_number(node, replace(limits[field], name=name, nominal=nominal))
    declare_numbers(
        node,
        (replace(gain, nominal=getattr(suited.gains, gain.name)) for gain in PidGains.parameters()),
    )
    if fault and not any(node.get_parameter(gain).value for gain in ("kp", "ki", "kd")):
        raise fault
    declare_flag(
        node,
        ON_MEASUREMENT,
        suited.gains.derivative_on_measurement,
        "differentiate the displacement, not the error: a step of the setpoint does not kick",
    )
