"""The paper's hysteresis, equation (3), integrated along the voltage.

    dh/du = alpha d - beta sgn(du) h - gamma |h|          w = d u - h

The equation knows no time, so the classical Runge-Kutta method runs in u, in strides that keep its
error below a picometre. `w` is what the stack would move without the flexure, in m.
"""

from __future__ import annotations

import numpy as np

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array

LONGEST_STRIDE = 0.5  # V
AT_KINK = 16  # strides that replace one in which h changes its sign


@compiled
def runge_kutta(alpha_d: float, toward: float, gamma: float, h: float, du: float) -> float:
    """h after one stride du; `toward` is beta in the direction of du."""
    s1 = alpha_d - toward * h - gamma * abs(h)
    a = h + 0.5 * du * s1
    s2 = alpha_d - toward * a - gamma * abs(a)
    a = h + 0.5 * du * s2
    s3 = alpha_d - toward * a - gamma * abs(a)
    a = h + du * s3
    s4 = alpha_d - toward * a - gamma * abs(a)
    return h + du / 6.0 * (s1 + 2.0 * s2 + 2.0 * s3 + s4)


@compiled
def along_voltage(
    alpha_d: float, beta: float, gamma: float, h: float, begin: float, end: float
) -> float:
    """Return h (m) after the voltage went from `begin` to `end` one way; alpha d in m/V."""
    if end == begin:
        return h
    strides = 1 + int(abs(end - begin) / LONGEST_STRIDE)
    du = (end - begin) / strides
    toward = beta if du > 0.0 else -beta
    for _ in range(strides):
        after = runge_kutta(alpha_d, toward, gamma, h, du)
        if after * h < 0.0:  # |h| has a kink within the stride
            after = h
            for _ in range(AT_KINK):
                after = runge_kutta(alpha_d, toward, gamma, after, du / AT_KINK)
        h = after
    return h


@compiled
def march_hysteresis(numbers: Array, state: Array, voltage: Array, free: Array) -> None:
    """Write w for each voltage; `numbers` d, alpha, beta, gamma; `state` h and the last voltage."""
    d, alpha_d, beta, gamma = numbers[0], numbers[1] * numbers[0], numbers[2], numbers[3]
    h, u = state[0], state[1]
    for j in range(len(voltage)):
        h = along_voltage(alpha_d, beta, gamma, h, u, voltage[j])
        u = voltage[j]
        free[j] = d * u - h
    state[0], state[1] = h, u


def free_course(numbers: tuple[float, float, float, float], voltage: Array) -> Array:
    """Return w after each voltage, from h = 0 at 0 V."""
    free = np.empty_like(voltage)
    march_hysteresis(np.array(numbers), np.zeros(2), voltage, free)
    return free
