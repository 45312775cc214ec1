"""Setpoints from CSV files, good and bad."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from microgripper_control.control.setpoints import Recorded, read_recorded
from microgripper_control.core.errors import MicrogripperError

Write = Callable[[str | bytes], Path]


@pytest.fixture
def csv(tmp_path: Path) -> Write:
    def write(content: str | bytes) -> Path:
        path = tmp_path / "setpoint.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def test_gives_the_columns_samples_at_its_own_rate(csv: Write) -> None:
    points = np.random.default_rng(0).standard_normal(1000)
    rows = "".join(f"{5.0 + 1e-3 * k:.6f},{p!r}\n" for k, p in enumerate(points.tolist()))
    signal = read_recorded(csv("time_s,voltage_V\n" + rows))
    np.testing.assert_array_equal(signal.samples(1000, 1e-3), points)
    assert signal.at(517, 1e-3) == points[517]
    assert signal.at(5000, 1e-3) == points[-1]


def test_holds_each_value_until_the_next(csv: Write) -> None:
    signal = read_recorded(csv("\ufeffx, time_s ,y\n1,0,10\n2,0.25,20\n\n3,1,30\n"), "y")
    np.testing.assert_array_equal(signal.samples(6, 0.2), [10, 10, 20, 20, 20, 30])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "is empty; expected a header such as time_s,setpoint_m"),
        ("time_s,voltage_V\n", "has no rows; at least one is needed"),
        (
            "t,voltage_V\n0,1\n",
            "no columns named 'time_s' where one is needed; it has t, voltage_V",
        ),
        ("time_s,a,b\n0,1,2\n", "choose a column of a, b"),
        ("time_s,a\n0,1\n1\n", "line 3: 1 cells, none in column 'a'; complete or remove it"),
        ("time_s,a\n0,1\n1,x\n", "line 3: 'x' in column 'a' is not a number"),
        ("time_s,a\n0,1\n1,inf\n", "row 2: a is inf"),
        ("time_s,a\n0,1\n1,2\n1,3\n", "row 3: time_s must rise"),
        (
            "time_s;a\n0;1\n1;2,5\n",
            "line 3: '2,5' in column 'a' is not a number; numbers have decimal points, no commas",
        ),
        (b"\xff\xfe\x00\x80", "is neither a rosbag2 nor a CSV in UTF-8"),
    ],
)
def test_a_bad_file_gives_one_line_that_names_it(
    csv: Write, content: str | bytes, message: str
) -> None:
    path = csv(content)
    with pytest.raises(MicrogripperError) as error:
        read_recorded(path)
    assert str(error.value) == f"{path}: {message}"


def test_a_missing_file_or_column_is_named(csv: Write, tmp_path: Path) -> None:
    with pytest.raises(MicrogripperError, match=r"nowhere\.csv: cannot be read: No such file"):
        read_recorded(tmp_path / "nowhere.csv")
    with pytest.raises(
        MicrogripperError, match="no columns named 'c' where one is needed; it has time_s, a, b"
    ):
        read_recorded(csv("time_s,a,b\n0,1,2\n"), "c")


def test_times_and_points_go_together() -> None:
    with pytest.raises(MicrogripperError, match="2 times for 1 points"):
        Recorded(np.zeros(2), np.zeros(1))
