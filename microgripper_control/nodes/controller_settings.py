"""The controller's parameters, and the control law that they ask for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

from rclpy.node import Node

from microgripper_control.control.controller import Controller, Mode
from microgripper_control.control.feedforward import InverseKind
from microgripper_control.control.identified import Identified
from microgripper_control.control.limits import VoltageLimits
from microgripper_control.control.pid import PidGains
from microgripper_control.control.tuning import ACTING, gains_for, loop_margins
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
    given_parameters,
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
GAINS = frozenset(parameter.name for parameter in PidGains.parameters())
ON_MEASUREMENT = "derivative_on_measurement"
LIVE = frozenset({"mode", "model_file", ON_MEASUREMENT, *GAINS})  # may change while it runs
NAMES = (*LIVE, *LIMITS, "inverse", SAMPLE_RATE.name)
_loop_margins = lru_cache(maxsize=1)(loop_margins)  # milliseconds, in which a loop would wait


@dataclass(frozen=True)
class ControllerSettings:
    """What the parameters say, checked: MicrogripperError names what is wrong with them."""

    mode: Mode
    inverse: InverseKind
    identified: Identified
    limits: VoltageLimits
    gains: PidGains
    sample_period: float  # s
    given: frozenset[str] = GAINS  # the gains that somebody asked for

    @classmethod
    def of(
        cls,
        values: Mapping[str, Any],
        given: frozenset[str],
        identified: Identified | None = None,
    ) -> ControllerSettings:
        """Of the values of the parameters NAMES; the model file is read unless it is known.

        Of the gains those `given` count; the others are what suits the model and the sample rate.
        """
        check_choice("mode", values["mode"], [mode.value for mode in Mode])
        check_choice("inverse", values["inverse"], [kind.value for kind in InverseKind])
        identified = identified or load_identified(values["model_file"])
        period = 1.0 / values[SAMPLE_RATE.name]
        asked = {name: values[name] for name in (*given, ON_MEASUREMENT)}
        settings = cls(
            mode=Mode(values["mode"]),
            inverse=InverseKind(values["inverse"]),
            identified=identified,
            limits=VoltageLimits(**{field: values[name] for name, field in LIMITS.items()}),
            gains=gains_for(identified, period, asked),
            sample_period=period,
            given=given,
        )
        settings.controller()  # checks what only together is wrong
        return settings

    @cached_property
    def warning(self) -> str:
        """What is wrong with them and yet allowed; empty if nothing is."""
        acting = any(getattr(self.gains, name) for name in ACTING)
        if not acting or self.mode not in (Mode.PID, Mode.CASCADE):
            return ""
        if _loop_margins(self.identified, self.gains, self.sample_period).gain > 0.0:
            return ""
        gains = ", ".join(f"{name} = {getattr(self.gains, name):g}" for name in ACTING)
        return f"by the model the loop is unstable with {gains}"

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
    """The values that a controller needs of the model in a file."""
    return Identified.of(load_model(model_path(model_file)))


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


def given_gains(node: Node) -> frozenset[str]:
    """The gains that whoever started the node has given."""
    return given_parameters(node) & GAINS


def _declare_law(node: Node) -> None:
    """Declare the parameters NAMES; limits not given are those that suit the model."""
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
    usual = Controller(load_identified(name), 1.0 / rate, gains=PidGains()).guard.limits
    limits = {parameter.name: parameter for parameter in VoltageLimits.parameters()}
    for name, field in LIMITS.items():
        nominal = getattr(usual, field)
        declare_number(node, replace(limits[field], name=name, nominal=nominal))
    declare_numbers(node, PidGains.parameters())
    declare_flag(
        node,
        ON_MEASUREMENT,
        PidGains.derivative_on_measurement,
        "differentiate the displacement, not the error: a step of the setpoint does not kick",
    )
