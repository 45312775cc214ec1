"""Hysteresis whose rising and falling branches differ by more than beta and gamma give.

    w_a = w - (tilt u + bulge u^2 + skew h) h

The paper's h, which is what the loop is made of, counts more in one part of the range than in
another: `tilt` opens the loop towards one end, `bulge` in the middle or at both ends, `skew`
weights the two branches, on which h differs, unequally. No state is added: the way counts, not the
speed. The generalised Bouc-Wen equations put such terms into h' (Zhu and Wang delta u sgn(u'), Song
and Der Kiureghian the signs of products of u, u' and h). Put beside h they leave its closed form
alone; what they take up of another asymmetry depends on it: 20 to 90 % of it in seven that were
tried.
"""

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.core.parameters import Parameter
from microgripper_control.core.quantities import percent
from microgripper_control.core.signals import FREE, HYSTERESIS, VOLTAGE, Array, Timing
from microgripper_control.effects.base import Link, Prepared, Scales, Stage, Values

USUAL_H = 0.05  # of the stroke: h of the usual piezo


@compiled
def kernel(coefficients: Array, state: Array, bus: Array) -> None:
    tilt, bulge, skew = coefficients[0, 0], coefficients[0, 1], coefficients[0, 2]
    for j in range(bus.shape[1]):
        u, h = bus[VOLTAGE, j], bus[HYSTERESIS, j]
        bus[FREE, j] -= ((tilt + bulge * u) * u + skew * h) * h


def prepare(values: Values, timing: Timing, levels: Array) -> Prepared:
    """No state."""
    coefficients = np.array([[values["tilt"], values["bulge"], values["skew"]]])
    bus = levels[:, None].copy()
    kernel(coefficients, np.zeros(0), bus)
    levels[FREE] = bus[FREE, 0]
    return Prepared(coefficients, np.zeros(0), timing.ramped)


def starts(scales: Scales) -> Sequence[Values]:
    """Each of the three ways by itself, a tenth of h at the largest voltage."""
    largest = max(abs(volts) for volts in scales.voltage)
    off = {"tilt": 0.0, "bulge": 0.0, "skew": 0.0}
    sizes = {"tilt": 0.1 / largest, "bulge": 0.1 / largest**2, "skew": 2.0 / scales.stroke}
    return [off | {name: size} for name, size in sizes.items()]


def says(values: Values, scales: Scales) -> str:
    u = np.linspace(*scales.voltage, 50)[:, None]
    h = USUAL_H * scales.stroke * np.array([-1.0, 1.0])
    weight = (values["tilt"] + values["bulge"] * u) * u + values["skew"] * h
    return (
        "the hysteresis is lopsided: it counts up to "
        f"{percent(float(np.ptp(weight)))} more in one part of the loop than in another"
    )


LINK = Link(
    name="asymmetric_hysteresis",
    stage=Stage.MATERIAL,
    order=10,
    title="asymmetric hysteresis",
    source="after Zhu and Wang 2012 (paper, reference [20]); Song and Der Kiureghian 2006",
    parameters=(
        Parameter("tilt", "1/V", 1e-3, -0.1, 0.1, "growth of the loop with voltage", 0.0),
        Parameter("bulge", "1/V^2", 1e-5, -1e-2, 1e-2, "growth with its square", 0.0),
        Parameter("skew", "1/m", 5e4, -1e8, 1e8, "growth with h itself", 0.0),
    ),
    prepare=prepare,
    kernel=kernel,
    starts=starts,
    says=says,
)
