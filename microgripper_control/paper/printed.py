"""The numbers that the paper prints as its results, to compare with and to compute nothing from.

Table 1 is an input; it stands with the links that use it (effects/material, effects/mechanics).
The paper's k1 and k2 appear as an input once: where equation (15) is checked against them.
"""

from __future__ import annotations

from types import MappingProxyType

STIFFNESS = 8.2e5  # N/m, section 4; the paper says N-s/m in section 5
LARGEST_FORCE = 120.0  # N, fig. 3
SENSOR_RESOLUTION = 1e-6  # m, section 5

TABLE_2 = MappingProxyType({"alpha": 0.0877, "beta": 0.0147, "gamma": -0.0205})

K1 = 2.3e-8  # m/V, section 7
K2 = -0.533  # 1/s, section 7

# Equation (15): highest power of s first.
NUMERATOR = (1.598e3, 1.045e3)
DENOMINATOR = (1.0, 3.947e4, 1.316e10, 7.276e9)
ZERO = -0.653  # rad/s
SLOW_POLE = -0.55288  # rad/s
FAST_POLE = complex(-19.73e3, 113.006e3)  # rad/s

SLOPE = 1.0  # of fig. 17
ERROR = 5.0  # %, abstract and section 10, with PID and hysteresis compensation
