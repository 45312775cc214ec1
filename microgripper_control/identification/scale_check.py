"""Whether the recordings move as far as the model, and the same way: if not, a unit is wrong.

If they do not move with it at all, what was recorded is another column, or a dead sensor.
No rig is off by a factor of three: micrometres were read as metres, a controller's output as the
amplifier's, or the sensor looks from the other side. A fit would follow, and call it mistuned.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from microgripper_control.core.quantities import number
from microgripper_control.core.recording import Recording
from microgripper_control.core.signals import Array
from microgripper_control.identification.confidence import independent_samples
from microgripper_control.identification.nuisance import Conditions
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

FAR = 3.0  # times as far as the model, or as little
ALIKE = 0.5  # correlation with the model, or with its opposite: of less none can be sure
CHANCE = 3.0  # standard deviations of the correlation of signals that have nothing in common


def scale_warnings(
    nominal: Model, recordings: Sequence[Recording], conditions: Conditions
) -> list[str]:
    """One line if what was measured goes another way than the model, or far more or less.

    Or if it does not go with the model at all.
    """
    measured = [_centred(one.measured) for one in recordings]
    foretold = [_centred(_foretold(nominal, one, conditions)) for one in recordings]
    shown, said = np.concatenate(measured), np.concatenate(foretold)
    sizes = float(np.linalg.norm(shown)), float(np.linalg.norm(said))
    if not 0.0 < sizes[0] * sizes[1] < np.inf:
        return []
    alike, ratio = float(said @ shown) / (sizes[0] * sizes[1]), sizes[0] / sizes[1]
    if alike < -ALIKE:
        return [
            "the recordings go down where the model goes up: if the sensor looks from the other "
            "side, read them with --map displacement=NAME*-1"
        ]
    if abs(alike) < min(ALIKE, CHANCE * _by_chance(measured, foretold)):
        return [
            "the recordings do not move with the voltage: make sure that the sensor sees the rig, "
            "and that --map displacement=NAME names what it shows"
        ]
    if alike < ALIKE or 1.0 / FAR < ratio < FAR:
        return []
    return [
        f"the recordings move {number(ratio)} times as far as the model: make sure of the units of "
        "voltage and displacement, or read them with --map QUANTITY=NAME*FACTOR"
    ]


def _by_chance(measured: Sequence[Array], foretold: Sequence[Array]) -> float:
    """The standard deviation of the correlation of signals without relation, by recordings.

    It is that of as many samples as the one that changes faster has independent ones.
    """
    pairs = zip(measured, foretold, strict=True)
    independent = sum(
        max(independent_samples([one]), independent_samples([other])) for one, other in pairs
    )
    return float(1.0 / np.sqrt(independent))


def _foretold(nominal: Model, recording: Recording, conditions: Conditions) -> Array:
    """What the model as given says, m, whatever the recording began with."""
    hold, initial = conditions.hold, conditions.initial
    return simulate(nominal, recording.voltage, recording.sample_period, hold=hold, initial=initial)


def _centred(signal: Array) -> Array:
    centred: Array = signal - signal.mean()
    return centred
