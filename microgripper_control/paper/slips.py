"""The paper's slips: what it prints that cannot be meant, or cannot follow, each checked here."""

from __future__ import annotations

from microgripper_control.paper import printed
from microgripper_control.paper.behaviour import BehaviourResult
from microgripper_control.paper.inverse import InverseResult
from microgripper_control.paper.linear_plant import LinearPlantResult
from microgripper_control.paper.linearised import LinearisedResult


def found_slips(
    behaviour: BehaviourResult,
    inverse: InverseResult,
    linearised: LinearisedResult,
    linear_plant: LinearPlantResult,
) -> list[str]:
    """One paragraph a slip, with the recomputed numbers."""
    b1, b0 = printed.NUMERATOR
    a0 = printed.DENOMINATOR[-1]
    plain = linear_plant.without_flexure
    low, high = linearised.frequency_range
    asked = linear_plant.implied_k2
    d = behaviour.model.value("bouc_wen", "d")
    k, k_s = (behaviour.model.value("second_order", name) for name in ("k", "k_s"))
    return [
        'Section 5 gives k_s "N-s/m"; it is a stiffness, N/m.',
        '(16) writes de(t)/t for de(t)/dt; "(12)" numbers two equations; (5) repeats (4).',
        "Tables 1 and 2 give beta and gamma no unit; with n = 1 they are per volt of travel, 1/V. "
        "Table 2 writes all symbols in capitals, so that B is both the damping and beta.",
        f"(15) leaves k_s out, though (4) has it. With k_s the coefficient of s is "
        f"{linear_plant.with_flexure.denominator[2]:.4g} instead of {plain.denominator[2]:.4g}, "
        f"and the static gain {k / (k + k_s):.4f} of what it is without.",
        f"(15) does not follow from the printed k1 and k2: b0 is {plain.numerator[1]:.4g} and a0 "
        f"{plain.denominator[3]:.4g}; printed are {b0:.4g} and {a0:.4g}. Their ratio should be d = "
        f"{d:.4e} m/V and is {b0 / a0:.4e}, so that no k2 gives both.",
        f"The printed slow pole, {printed.SLOW_POLE:g}, is k2 itself and asks for "
        f"{asked['slow pole = k2']:.4f} instead of {printed.K2:g}; the printed zero, "
        f"{printed.ZERO:g}, asks for {asked['zero = k2 d/(d - k1)']:.4f}. From the printed k2 the "
        f"zero is {plain.zero:.4f}; the ratio b0/b1 as printed gives {-b0 / b1:.4f}.",
        f"The printed fast poles, {1e-3 * printed.FAST_POLE.real:.2f} ± "
        f"{1e-3 * printed.FAST_POLE.imag:.3f}i (10^3 rad/s), are those of the rounded coefficients "
        f"printed in (15), {1e-3 * linear_plant.printed_fast_pole.real:.3f} ± "
        f"{1e-3 * linear_plant.printed_fast_pole.imag:.3f}i; Table 1 gives "
        f"{1e-3 * plain.fast_pole.real:.3f} ± {1e-3 * plain.fast_pole.imag:.3f}i.",
        "k2 is in proportion to the drive's frequency, which the paper does not give. The printed "
        f"k2 asks for {low:.2f} to {high:.2f} Hz, depending on the course of the voltage. A "
        "rate-independent hysteresis has no such coefficient: the linearised model holds at the "
        "frequency it was fitted at.",
        "Table 1 has beta + gamma < 0: on rising voltage h grows exponentially and the operator is "
        f"not bounded. A settled cycle turns non-monotone at {behaviour.table_1.safe_span:.1f} V "
        f"unipolar and {0.5 * behaviour.table_1.safe_span:.1f} V bipolar. On the very first cycle "
        f"that happens from {behaviour.table_1.first_rise:.1f} V on, below the 160 V of the "
        f"experiment: by {1e9 * behaviour.counter_motion:.2f} nm, which its sensor cannot show.",
        f"The model moves {1e6 * behaviour.stroke:.1f} µm at 160 V; the actuator's maker gives "
        "about 140 µm over 170 V. The displacement of the model is not that of the actuator's "
        "head, or d has another reference; the paper does not say.",
        "Section 4 divides a force on the flexure's sides by a displacement of its head, at right "
        "angles to it. That is not the stiffness that the stack works against, as (4) uses it.",
        "Table 2 differs from Table 1 about as much as the 1 µm resolution of the sensor alone "
        "can make the inverse model's parameters differ (here, with the sensor's zero on its grid, "
        + ", ".join(f"{name} {inverse.paper.values[name]:.4f}" for name in printed.TABLE_2)
        + "). It need not say anything of the actuator.",
    ]
