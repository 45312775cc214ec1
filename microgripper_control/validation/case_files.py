"""A case as files: what the diagnosing process gets in one folder, the truth elsewhere."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from microgripper_control.core.files import written_whole
from microgripper_control.validation.base import Actuator
from microgripper_control.validation.case import Case
from microgripper_control.validation.law import Taken

MODEL = "model.yaml"
JOB = "job.json"
COLUMNS = "time_s,voltage_V,displacement_m"
EXPONENT = 1.0  # n, of equation (2)
UNITS = {
    "bouc_wen": {
        "d": "m/V",
        "alpha": "1",
        "beta": "1/(V*m^(n-1))",
        "gamma": "1/(V*m^(n-1))",
        "n": "1",
    },
    "second_order": {"m": "kg", "b": "N*s/m", "k": "N/m", "k_s": "N/m"},
}


def write_case(case: Case, folder: str | Path, seal: str | Path) -> None:
    """Write recordings, nominal model and job into `folder`, and the truth to the file `seal`.

    The folder holds `recording_1.csv` ..., `heldout_1.csv` ..., `model.yaml` and `job.json`, which
    names them and the `--hold` that a laboratory would know; nothing in it tells the effect. Files
    appear whole or not at all; MicrogripperError where a place cannot be written.
    """
    folder = Path(folder)
    for taken in case.recordings:
        _write_recording(taken, folder / f"{taken.name}.csv")
    with written_whole(folder / MODEL) as file:
        yaml.safe_dump(nominal_model(case.actuator), file, sort_keys=False)
    job = {
        "model": MODEL,
        "recordings": [f"{one.name}.csv" for one in case.recordings if not one.heldout],
        "heldout": [f"{one.name}.csv" for one in case.recordings if one.heldout],
        "hold": case.hold,
    }
    for path, content in ((folder / JOB, job), (Path(seal), case.truth.plain())):
        with written_whole(path) as file:
            json.dump(content, file, indent=1)
            file.write("\n")


def nominal_model(actuator: Actuator) -> dict[str, Any]:
    """The user's model: the nominal numbers and no effect, as microgripper-model/1."""
    return {
        "schema": "microgripper-model/1",
        "name": "APA120S",
        "voltage": {"low": actuator.low, "high": actuator.high, "unit": "V"},
        "nominal": {
            link: {
                name: {"value": float(getattr(actuator.base, name, EXPONENT)), "unit": unit}
                for name, unit in units.items()
            }
            for link, units in UNITS.items()
        },
    }


def _write_recording(taken: Taken, path: Path) -> None:
    with written_whole(path) as file:
        file.write(COLUMNS + "\n")
        table = np.column_stack([taken.time, taken.voltage, taken.measured])
        np.savetxt(file, table, fmt=("%.9f", "%.10g", "%.12g"), delimiter=",")
