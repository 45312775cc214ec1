"""The loop that the controllers are tested in, and plants that differ from what they hold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.control.controller import Controller
from microgripper_control.control.identified import Identified
from microgripper_control.core.signals import Array
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import Plant

PERTURBED = [
    *(("bouc_wen", name) for name in ("d", "alpha", "beta", "gamma")),
    *(("second_order", name) for name in ("m", "b", "k", "k_s")),
]


def identified_from(model: Model) -> Identified:
    return Identified.from_values(
        model.values("bouc_wen"), model.values("second_order"), model.voltage_range
    )


def perturbed(model: Model, signs: Sequence[float], by: float = 0.1) -> Model:
    """Every parameter of the paper's plant off by a share, upwards or downwards."""
    pairs = zip(PERTURBED, signs, strict=True)
    return model.with_values({key: model.value(*key) * (1.0 + by * sign) for key, sign in pairs})


def drive(
    model: Model, controller: Controller, setpoint: Array, sample_period: float = 1e-3
) -> tuple[Array, Array]:
    """Run the loop from rest in the sampled-data convention; displacement, m, and voltage, V."""
    plant = Plant(model, sample_period)
    displacement, voltage = np.empty(len(setpoint)), np.empty(len(setpoint))
    answer = controller.start(0.0)
    for k, wanted in enumerate(setpoint):
        displacement[k] = plant.read()
        voltage[k] = answer
        plant.write(answer)
        answer = controller.step(wanted, displacement[k], voltage[k])
    return displacement, voltage
