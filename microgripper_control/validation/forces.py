"""The force laws by number, so that one compiled solve can hold any of them together.

Each law is `law(numbers, old, new, x0, v0, x1, v1, step) -> force`: the force (N) on the moving
mass at the end of a step over which it went from x0 to x1 (m) and from v0 to v1 (m/s). `old` is the
law's state before the step and `new` is where it writes the state after it; it may be called for
several trials of one step. The first state is what the law carries beyond x, in m: the finger's own
motion.
"""

from __future__ import annotations

from microgripper_control.core.compiled import compiled
from microgripper_control.validation.block import Array
from microgripper_control.validation.effects import (
    contact,
    extra_resonance,
    friction,
    nonlinear_stiffness,
    restoring_force_hysteresis,
)
from microgripper_control.validation.effects.kinds import (
    ELASTO_PLASTIC,
    FINGER,
    GRAESSER,
    HERTZ,
    IWAN,
    MAXWELL_SLIP,
    RELEASE,
    STICKY,
    TENSION,
)

FORCE_NUMBERS = 32  # room for the coefficients of one law
FORCE_STATES = 16  # and for its state

_hertz = contact.hunt_crossley
_sticky = contact.sticky_object
_finger = extra_resonance.finger
_elasto_plastic = friction.elasto_plastic
_maxwell_slip = friction.maxwell_slip
_tension = nonlinear_stiffness.tension
_release = nonlinear_stiffness.release
_iwan = restoring_force_hysteresis.iwan
_graesser = restoring_force_hysteresis.graesser_cozzarelli


@compiled
def total_force(
    kinds: Array,
    numbers: Array,
    old: Array,
    new: Array,
    x0: float,
    v0: float,
    x1: float,
    v1: float,
    step: float,
) -> float:
    """The sum of all forces at the end of the step, N; writes every law's new state."""
    total = 0.0
    for i in range(len(kinds)):
        kind, p, s, t = int(kinds[i]), numbers[i], old[i], new[i]
        if kind == HERTZ:
            total += _hertz(p, s, t, x0, v0, x1, v1, step)
        elif kind == STICKY:
            total += _sticky(p, s, t, x0, v0, x1, v1, step)
        elif kind == ELASTO_PLASTIC:
            total += _elasto_plastic(p, s, t, x0, v0, x1, v1, step)
        elif kind == MAXWELL_SLIP:
            total += _maxwell_slip(p, s, t, x0, v0, x1, v1, step)
        elif kind == TENSION:
            total += _tension(p, s, t, x0, v0, x1, v1, step)
        elif kind == RELEASE:
            total += _release(p, s, t, x0, v0, x1, v1, step)
        elif kind == IWAN:
            total += _iwan(p, s, t, x0, v0, x1, v1, step)
        elif kind == GRAESSER:
            total += _graesser(p, s, t, x0, v0, x1, v1, step)
        elif kind == FINGER:
            total += _finger(p, s, t, x0, v0, x1, v1, step)
    return total
