"""`microgripper repair` as its users type it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from microgripper_control.core.recording import Recording
from microgripper_control.recordings.write import write_bag

Run = Callable[..., Any]


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    write_bag(tmp_path / "run", Recording("run", 1e-3, np.arange(20.0), np.arange(20.0)))
    (tmp_path / "run" / "metadata.yaml").unlink()
    return tmp_path / "run"


def test_once_and_again(microgripper: Run, broken: Path) -> None:
    done = microgripper("repair", broken)
    assert done.status == 0
    assert done.out == (
        f"{broken} is whole again: 20 of /microgripper/joint_states\n"
        f"the damaged bag is kept: {broken}.damaged\n"
    )
    assert "warning" in done.err
    again = microgripper("repair", broken)
    assert (again.status, again.err) == (0, "")
    assert again.out == f"{broken} is whole: 20 of /microgripper/joint_states\n"


def test_for_machines(microgripper: Run, broken: Path) -> None:
    found = json.loads(microgripper("repair", broken, "--json").out)
    assert found == {
        "schema": "microgripper-repair/1",
        "bag": str(broken),
        "repaired": True,
        "messages": {"/microgripper/joint_states": 20},
        "lost": ["metadata.yaml is missing or damaged; the storage files were read"],
        "kept": f"{broken}.damaged",
    }
    assert json.loads(microgripper("repair", broken, "--json").out)["repaired"] is False


def test_what_is_no_bag(microgripper: Run, tmp_path: Path) -> None:
    done = microgripper("repair", tmp_path / "nothing")
    assert (done.status, done.out) == (2, "")
    assert done.err == f"microgripper: {tmp_path}/nothing: does not exist\n"
