"""Section 7, equations (10)-(15): the linear plant, its transfer function, its zero and its poles.

With v = h - k1 u and the state (x, x', v),

    x'' = -(k + k_s)/m x - b/m x' - k/m v + k (d - k1)/m u,        v' = k2 v + k1 k2 u.

The paper leaves k_s out here, though (4) has it; both are computed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import control
import numpy as np

from microgripper_control.control.identified import Identified
from microgripper_control.control.linearised import Linearised
from microgripper_control.paper import printed
from microgripper_control.paper.agreement import Row, Table

SECTION = "7, (15)"
TOUCHED = 1e-3  # relative change


@dataclass(frozen=True)
class TransferFunction:
    """x/u in m/V: coefficients with the highest power of s first, zero and poles in rad/s."""

    numerator: tuple[float, ...]
    denominator: tuple[float, ...]
    zero: float
    slow_pole: float
    fast_pole: complex  # the one above the real axis


@dataclass(frozen=True)
class LinearPlantResult:
    """(15) from the printed k1 and k2, without and with k_s, and from k1 and k2 fitted here."""

    without_flexure: TransferFunction
    with_flexure: TransferFunction
    fitted: TransferFunction
    implied_k2: dict[str, float]  # 1/s, by the printed number that asks for it
    printed_fast_pole: complex  # rad/s, of the rounded coefficients printed in (15)

    def rows(self) -> list[Row]:
        """The printed numbers of (15) against those of the printed k1 and k2.

        With k_s only those that it touches.
        """
        rows = []
        for label, found in (
            ("without k_s", self.without_flexure),
            ("with k_s", self.with_flexure),
        ):
            for what, unit, paper, ours, plain, remark in zip(
                QUANTITIES,
                UNITS,
                PRINTED,
                _numbers(found),
                _numbers(self.without_flexure),
                REMARKS,
                strict=True,
            ):
                if found is self.without_flexure:
                    rows.append(Row(SECTION, f"{what}, {label}", unit, ours, paper, remark, ".5g"))
                elif abs(ours - plain) > TOUCHED * abs(plain):
                    rows.append(Row(SECTION, f"{what}, {label}", unit, ours, paper, form=".5g"))
        return rows

    def tables(self) -> list[Table]:
        """All versions of (15) beside each other, and what k2 the printed numbers ask for."""
        columns = [PRINTED, *map(_numbers, (self.without_flexure, self.with_flexure, self.fitted))]
        return [
            Table(
                "Equation (15), its zero and its poles",
                (
                    "",
                    "unit",
                    "printed",
                    "k1, k2 printed, no k_s",
                    "the same, with k_s",
                    "k1, k2 fitted here, with k_s",
                ),
                [
                    (what, unit, *(f"{column[i]:.5g}" for column in columns))
                    for i, (what, unit) in enumerate(zip(QUANTITIES, UNITS, strict=True))
                ],
                "x/u = (b1 s + b0) / (s^3 + a2 s^2 + a1 s + a0)",
                (0, 1),
            ),
            Table(
                "The k2 that each printed number asks for",
                ("printed", "k2, 1/s"),
                [(name, f"{value:.4f}") for name, value in self.implied_k2.items()],
                "One k2 should serve them all.",
            ),
        ]


QUANTITIES = ("b1", "b0", "a2", "a1", "a0", "zero", "slow pole", "fast poles, real part",
              "fast poles, imaginary part")  # fmt: skip
UNITS = ("m/(V s^2)", "m/(V s^3)", "1/s", "1/s^2", "1/s^3", "rad/s", "rad/s", "rad/s", "rad/s")
PRINTED = (
    *printed.NUMERATOR,
    *printed.DENOMINATOR[1:],
    printed.ZERO,
    printed.SLOW_POLE,
    printed.FAST_POLE.real,
    printed.FAST_POLE.imag,
)
REMARKS = (
    "",
    "slip: does not follow from the printed k2",
    "",
    "",
    "slip: does not follow from the printed k2",
    "slip: follows neither from the printed k2 nor from the one that the pole asks for",
    "slip: the pole is k2 itself",
    "",
    "of the printed, rounded coefficients",
)


def state_space(identified: Identified, linear: Linearised, *, flexure: bool) -> control.StateSpace:
    """Equations (12)-(14): u (V) to x (m); with or without k_s."""
    v = identified
    stiffness = v.k + v.k_s if flexure else v.k
    a = [[0.0, 1.0, 0.0], [-stiffness / v.m, -v.b / v.m, -v.k / v.m], [0.0, 0.0, linear.k2]]
    b = [[0.0], [v.k * (v.d - linear.k1) / v.m], [linear.k1 * linear.k2]]
    return control.ss(a, b, [[1.0, 0.0, 0.0]], [[0.0]])


def transfer_function(
    identified: Identified, linear: Linearised, *, flexure: bool
) -> TransferFunction:
    """Equation (15): the transfer function of `state_space`, m/V."""
    system = state_space(identified, linear, flexure=flexure)
    rational = control.tf(system)
    denominator = np.real(rational.den[0][0])
    numerator = np.real(rational.num[0][0]) / denominator[0]
    poles = system.poles()
    slow = poles[np.argmin(np.abs(poles))]
    fast = poles[np.argmax(poles.imag)]
    return TransferFunction(
        tuple(map(float, numerator[-2:])),
        tuple(map(float, denominator / denominator[0])),
        float(np.real(system.zeros()[0])),
        float(slow.real),
        complex(fast),
    )


def reproduce_linear_plant(identified: Identified, fitted: Linearised) -> LinearPlantResult:
    """Compute (15) three times and ask the printed numbers for their k2."""
    as_printed = Linearised(printed.K1, printed.K2)
    gain = identified.k * identified.d / identified.m
    _, b0 = printed.NUMERATOR
    _, a2, a1, a0 = printed.DENOMINATOR
    return LinearPlantResult(
        without_flexure=transfer_function(identified, as_printed, flexure=False),
        with_flexure=transfer_function(identified, as_printed, flexure=True),
        fitted=transfer_function(identified, fitted, flexure=True),
        implied_k2={
            "k2 itself": printed.K2,
            "b0 = -k2 d k/m": -b0 / gain,
            "a0 = -k2 k/m": -a0 * identified.m / identified.k,
            "slow pole = k2": printed.SLOW_POLE,
            "zero = k2 d/(d - k1)": printed.ZERO * (1.0 - printed.K1 / identified.d),
        },
        printed_fast_pole=complex(-a2 / 2.0, math.sqrt(a1 - a2**2 / 4.0)),
    )


def _numbers(found: TransferFunction) -> tuple[float, ...]:
    return (
        *found.numerator,
        *found.denominator[1:],
        found.zero,
        found.slow_pole,
        found.fast_pole.real,
        found.fast_pole.imag,
    )
