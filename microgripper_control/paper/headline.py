"""Abstract and section 10: the tracking error, against "less than 5 %".

No compensation, feedforward alone, PID alone and the cascade of both; on the plant that the
controller knows, on plants 10 % off, with the paper's sensor of 1 µm resolution, and with values
that were themselves identified through that sensor. Errors are of where the finger really is, not
of what the sensor reads.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from microgripper_control.control.controller import Mode
from microgripper_control.control.identified import Identified
from microgripper_control.control.pid import PidGains
from microgripper_control.control.tuning import default_gains
from microgripper_control.core.signals import Array
from microgripper_control.paper import printed
from microgripper_control.paper.agreement import Kind, Row, Table
from microgripper_control.paper.closed_loop import track
from microgripper_control.paper.experiment import (
    SAMPLE_PERIOD,
    SENSOR,
    with_paper_sensor,
)
from microgripper_control.paper.open_loop import calibrated_gain
from microgripper_control.paper.setpoint import (
    MISMATCH,
    Tracking,
    approached_sine,
    mismatched,
    tracking_error,
)
from microgripper_control.plant.model import Model
from microgripper_control.plant.simulate import simulate

SINE_CYCLES = 3
FREQUENCIES = (0.1, 1.0, 10.0)  # Hz
MAIN = 1.0  # Hz
NONE, FEEDFORWARD, PID, CASCADE, TUNED_PID, TUNED_CASCADE = LAWS = (
    "no compensation",
    "feedforward only",
    "PID only",
    "cascade",
    "PID only, gains of section 8",
    "cascade, gains of section 8",
)
MODES = {
    FEEDFORWARD: Mode.FEEDFORWARD,
    PID: Mode.PID,
    CASCADE: Mode.CASCADE,
    TUNED_PID: Mode.PID,
    TUNED_CASCADE: Mode.CASCADE,
}
NOMINAL, OFF, FIRST, COARSE, IDENTIFIED = CASES = (
    "nominal plant",
    f"plant {100.0 * MISMATCH:g} % off",
    f"plant {100.0 * MISMATCH:g} % off, first cycle ever",
    "1 µm sensor",
    "1 µm sensor, values identified through it",
)
SECTION = "abstract, 10"

Errors = dict[str, dict[str, Tracking]]  # by case and law


@dataclass(frozen=True)
class HeadlineResult:
    """Errors by frequency (Hz), case and law; the runs at the main frequency, which are drawn."""

    reach: tuple[float, float]  # m
    errors: dict[float, Errors]
    time: Array  # s
    setpoint: Array  # m
    runs: dict[str, dict[str, Array]]  # by case and law, m

    def rows(self) -> list[Row]:
        """The cascade in every case against 5 %, and the other laws on the nominal plant."""
        found = self.errors[MAIN]
        low, high = self.reach
        half = 50.0 * printed.SENSOR_RESOLUTION / (high - low)
        remarks = {
            NOMINAL: "the paper gives an upper bound, of an error that it does not define",
            COARSE: f"half a step of the sensor is {half:.2f} % of p-p",
        }
        rows = [
            _row(CASCADE, case, found[case][CASCADE].largest, printed.ERROR, remarks.get(case, ""))
            for case in CASES
        ]
        coarse = found[COARSE][TUNED_CASCADE].largest
        remark = "tuned without the sensor in mind: its steps keep the loop moving"
        rows.append(_row(TUNED_CASCADE, COARSE, coarse, printed.ERROR, remark))
        rows += [_row(law, NOMINAL, found[NOMINAL][law].largest) for law in LAWS[:3]]
        return rows

    def tables(self) -> list[Table]:
        """Every law and case, one table a frequency."""
        low, high = (1e6 * end for end in self.reach)
        note = (
            f"Sine between {low:g} and {high:g} µm, which all these plants reach in cycling, "
            "sampled at 1 kHz; the second and third cycle count. PID and cascade run on the "
            "controller's default gains, integral action with ample margins, or on those of "
            "section 8. 10 % off: d, alpha, beta and gamma of the plant each 10 % more or less "
            "than the controller's values, the worst of the 16 for each law. First cycle ever: "
            "from rest, where some of these plants turn against the voltage at the top, as "
            "section 3 shows for the nominal one."
        )
        return [
            Table(
                f"Tracking error at {frequency:g} Hz, % of peak to peak, rms / largest",
                ("law", *CASES),
                [(law, *(_cell(found[case][law]) for case in CASES)) for law in LAWS],
                note if frequency == FREQUENCIES[0] else "",
            )
            for frequency, found in self.errors.items()
        ]


def _row(law: str, case: str, ours: float, paper: float | None = None, remark: str = "") -> Row:
    what = f"largest error, {law}; {case}"
    return Row(SECTION, what, "% of p-p", ours, paper, remark, ".3f", Kind.BOUND)


def _cell(error: Tracking) -> str:
    return f"{error.rms:.3f} / {error.largest:.3f}"


class _Runner:
    """Runs a law on a rig; the same every time."""

    def __init__(self, plant: Model, gains: PidGains) -> None:
        self._gain = calibrated_gain(plant)
        usual = default_gains(Identified.of(plant), SAMPLE_PERIOD)
        self._gains = {law: gains if law in (TUNED_PID, TUNED_CASCADE) else usual for law in LAWS}

    def run(self, law: str, rig: Model, held: Identified, setpoint: Array) -> Array:
        """Where the finger is, m, under a controller that holds the values `held`."""
        if law != NONE:
            return track(rig, held, MODES[law], setpoint, self._gains[law])
        voltage = np.clip(setpoint / self._gain, *rig.voltage_range)
        late = np.append(0.0, voltage[:-1])  # as the others, which answer one tick later
        return simulate(rig.without([SENSOR]), late, SAMPLE_PERIOD)


def reproduce_headline(
    plant: Model,
    gains: PidGains,
    identified: Identified,
    reach: tuple[float, float],
    progress: Callable[[str], None] = lambda stage: None,
) -> HeadlineResult:
    """Run every law in every case at every frequency.

    `gains` are those of section 8, tried beside the controller's defaults; `identified` are the
    values found with the paper's sensor; `reach` (m) is where the setpoint moves. The 16 plants
    that are off are all run at the main frequency, and the worst for each law again at the others.
    """
    runner = _Runner(plant, gains)
    exact = Identified.of(plant)
    coarse = with_paper_sensor(plant)
    worst = {law: _worst(runner, law, plant, reach, progress) for law in LAWS}
    errors: dict[float, Errors] = {}
    runs: dict[str, dict[str, Array]] = {}
    for frequency in FREQUENCIES:
        progress(f"tracking at {frequency:g} Hz")
        setpoint, first, later = _setpoint(reach, frequency)
        found: Errors = {case: {} for case in CASES}
        for law in LAWS:
            off, off_first = worst[law]
            rigs = {
                NOMINAL: (plant, exact),
                OFF: (off, exact),
                FIRST: (off_first, exact),
                COARSE: (coarse, exact),
                IDENTIFIED: (coarse, identified),
            }
            for case, (rig, held) in rigs.items():
                moved = runner.run(law, rig, held, setpoint)
                span = slice(first, later) if case == FIRST else slice(later, None)
                found[case][law] = tracking_error(setpoint[span], moved[span])
                if frequency == MAIN:
                    runs.setdefault(case, {})[law] = moved
        errors[frequency] = found
    drawn, *_ = _setpoint(reach, MAIN)
    return HeadlineResult(
        reach, errors, SAMPLE_PERIOD * np.arange(len(drawn), dtype=np.float64), drawn, runs
    )


def _setpoint(reach: tuple[float, float], frequency: float) -> tuple[Array, int, int]:
    """The setpoint, m, and the samples at which the first and the second cycle begin."""
    setpoint, start = approached_sine(reach, frequency, SINE_CYCLES, SAMPLE_PERIOD)
    return setpoint, start, start + round(1.0 / (frequency * SAMPLE_PERIOD))


def _worst(
    runner: _Runner,
    law: str,
    plant: Model,
    reach: tuple[float, float],
    progress: Callable[[str], None],
) -> tuple[Model, Model]:
    """The plants that are off on which a law errs most: later on, and in the first cycle."""
    progress(f"plants {100.0 * MISMATCH:g} % off: {law}")
    exact = Identified.of(plant)
    setpoint, first, later = _setpoint(reach, MAIN)
    errors = []
    for rig in mismatched(plant):
        moved = runner.run(law, rig, exact, setpoint)
        settled = tracking_error(setpoint[later:], moved[later:]).largest
        begun = tracking_error(setpoint[first:later], moved[first:later]).largest
        errors.append((settled, begun, rig))
    return max(errors, key=lambda e: e[0])[2], max(errors, key=lambda e: e[1])[2]
