from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.recordings.csv import write_csv
from microgripper_control.recordings.mapping import Mapping
from microgripper_control.recordings.read import read_recording

COUNT = 50
HEADER = "time_s,voltage_V,displacement_m"
ROWS = [f"{0.001 * k:.3f},{k},{1e-8 * k:.3e}" for k in range(COUNT)]
VOLTAGE = np.arange(COUNT, dtype=float)


def write(folder: Path, *lines: str) -> Path:
    path = folder / "run.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def complaint(path: Path, *maps: str) -> str:
    with pytest.raises(MicrogripperError) as caught:
        read_recording(path, Mapping.parse(maps))
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(f"{path}: ")
    return str(caught.value)


def test_what_was_written_is_read(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    voltage, displacement, setpoint = rng.standard_normal((3, COUNT))
    setpoint[:4] = np.nan
    recording = Recording("run", 1 / 750, voltage, displacement, setpoint, start=12.5)
    write_csv(tmp_path / "run.csv", recording)
    found = read_recording(tmp_path / "run.csv")
    assert found.name == str(tmp_path / "run.csv")
    assert found.sample_period == pytest.approx(1 / 750, rel=1e-11)
    assert found.start == 12.5
    assert np.array_equal(found.voltage, voltage)
    assert np.array_equal(found.displacement, displacement)
    assert np.array_equal(found.setpoint, setpoint, equal_nan=True)
    assert found.warnings == ()


def test_samples_that_were_filled_in_are_not_written(tmp_path: Path) -> None:
    path = write(tmp_path, HEADER, *ROWS[:20], *ROWS[23:])
    filled = read_recording(path)
    write_csv(tmp_path / "again.csv", filled)
    found = read_recording(tmp_path / "again.csv")
    assert np.array_equal(np.flatnonzero(~found.present), [20, 21, 22])
    assert np.array_equal(found.displacement, filled.displacement)
    assert found.warnings == filled.warnings


def test_readings_that_do_not_count_are_written(tmp_path: Path) -> None:
    voltage, displacement = np.random.default_rng(3).standard_normal((2, COUNT))
    read = np.arange(COUNT) % 7 > 0
    write_csv(tmp_path / "run.csv", Recording("run", 1e-3, voltage, displacement, read=read))
    found = read_recording(tmp_path / "run.csv")
    assert np.array_equal(found.displacement, displacement)


def test_columns_in_any_order_and_further_ones(tmp_path: Path) -> None:
    rows = [f"note {k},{1e-8 * k},{0.001 * k:.3f}, {k}" for k in range(COUNT)]
    path = write(tmp_path, "remark, displacement_m ,time_s,voltage_V", *rows)
    recording = read_recording(path)
    assert np.array_equal(recording.voltage, VOLTAGE)
    assert recording.sample_period == 0.001
    assert recording.setpoint is None


@pytest.mark.parametrize("mark", [";", "\t"])
def test_other_separators(tmp_path: Path, mark: str) -> None:
    path = write(tmp_path, HEADER.replace(",", mark), *(row.replace(",", mark) for row in ROWS))
    assert np.array_equal(read_recording(path).voltage, VOLTAGE)


def test_what_spreadsheets_write(tmp_path: Path) -> None:
    """A byte order mark, quotes, carriage returns, an empty line, a setpoint left out."""
    rows = [f'"{0.001 * k}","{k}",{1e-8 * k},{k if k > 2 else ""}\r' for k in range(COUNT)]
    path = write(tmp_path, f"\ufeff{HEADER},setpoint_m\r", *rows, "\r")
    recording = read_recording(path)
    assert np.array_equal(recording.voltage, VOLTAGE)
    assert recording.setpoint is not None
    assert np.isnan(recording.setpoint[:3]).all()
    assert recording.setpoint[3] == 3.0


@pytest.mark.parametrize("encoding", ["cp1252", "utf-8", "utf-8-sig"])
def test_names_in_the_encoding_of_windows(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "run.csv"
    rows = "\n".join(ROWS)
    path.write_bytes(f"time_s,voltage_V,Größe [µm]\n{rows}\n".encode(encoding))
    recording = read_recording(path, Mapping.parse(["displacement=Größe [µm]*1e-6"]))
    assert recording.displacement == pytest.approx(1e-14 * VOLTAGE)
    assert "it has time_s, voltage_V, Größe [µm]; choose" in complaint(path)


def test_columns_of_other_people(tmp_path: Path) -> None:
    rows = [f"{k},{k},{0.01 * k}" for k in range(COUNT)]
    path = write(tmp_path, "t/ms,amp:in,gauge [um]", *rows)
    maps = ["time=t/ms*1e-3", "voltage=amp:in*20", "displacement=gauge [um]*1e-6"]
    recording = read_recording(path, Mapping.parse(maps))
    assert recording.sample_period == 0.001
    assert np.array_equal(recording.voltage, 20.0 * VOLTAGE)
    assert recording.displacement == pytest.approx(1e-8 * VOLTAGE)


def test_what_separates_the_columns_is_what_there_is_most_of(tmp_path: Path) -> None:
    rows = [f"{row.replace(',', ';')};" for row in ROWS]
    path = write(tmp_path, f"{HEADER.replace(',', ';')};note (x, y)", *rows)
    assert read_recording(path).displacement == pytest.approx(1e-8 * VOLTAGE)


@pytest.mark.parametrize("at_once", [1, 7, 2**24])
def test_cells_beyond_the_header_are_found_in_any_piece_of_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, at_once: int
) -> None:
    monkeypatch.setattr("microgripper_control.core.table.COUNTED_AT_ONCE", at_once)
    path = write(tmp_path, HEADER, *ROWS[:30], f"{ROWS[30]},7", "", *ROWS[31:], "")
    assert "line 32: 4 cells, the header in line 1 has 3; " in complaint(path)
    assert len(read_recording(write(tmp_path, HEADER, *ROWS))) == COUNT


def test_commas_in_quoted_text_are_no_cells(tmp_path: Path) -> None:
    path = write(tmp_path, f"{HEADER},note", *(f'{row},"a, b"' for row in ROWS))
    assert np.array_equal(read_recording(path).voltage, VOLTAGE)


def test_a_comma_at_the_end_of_each_row_is_no_cell(tmp_path: Path) -> None:
    path = write(tmp_path, HEADER, *(f"{row}," for row in ROWS))
    assert read_recording(path).displacement == pytest.approx(1e-8 * VOLTAGE)


def test_a_recording_of_the_voltage_alone(tmp_path: Path) -> None:
    path = write(tmp_path, "time_s,voltage_V", *(row.rsplit(",", 1)[0] for row in ROWS))
    assert read_recording(path, needs_displacement=False).displacement is None
    assert "no column 'displacement_m'" in complaint(path)


def test_missing_rows_are_told(tmp_path: Path) -> None:
    path = write(tmp_path, HEADER, *ROWS[:20], *ROWS[23:])
    recording = read_recording(path)
    assert len(recording) == COUNT
    assert recording.warnings[0].startswith("missing samples: 3")


def test_wrong_columns_are_listed_with_the_remedy(tmp_path: Path) -> None:
    path = write(tmp_path, "time_s,force_N,displacement_m", *ROWS)
    assert complaint(path) == (
        f"{path}: no column 'voltage_V'; it has time_s, force_N, displacement_m; "
        "choose one with --map voltage=COLUMN"
    )
    assert "no column 'f'" in complaint(path, "voltage=f")
    assert "no column 'r'" in complaint(path, "voltage=force_N", "setpoint=r")


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ([], "line 1 is blank; expected a header such as time_s,voltage_V,displacement_m"),
        (["", HEADER, *ROWS], "line 1 is blank; expected a header such as time_s,"),
        (["# rig 7", HEADER, *ROWS], "line 2: 3 cells, the header in line 1 has 1; line 1 should"),
        ([HEADER], "0 samples; at least 10 are needed"),
        ([HEADER, *ROWS[:9]], "9 samples; at least 10 are needed"),
        (ROWS, "line 1 has numbers where the names of the columns should be"),
        ([f"{HEADER},voltage_V", *ROWS], "2 columns are named 'voltage_V'"),
        ([HEADER, *ROWS[:7], "0.007,off,1", *ROWS[8:]], "line 9: 'off' in column 'voltage_V'"),
        ([HEADER, *ROWS[:7], "0.007,,1", *ROWS[8:]], "line 9: '' in column 'voltage_V'"),
        ([HEADER, *ROWS[:7], "0.007,1", *ROWS[8:]], "line 9: 2 cells, none in column"),
        ([HEADER, *ROWS[:7], "0.007,nan,1", *ROWS[8:]], "voltage is nan at sample 7"),
        ([HEADER, *ROWS[:7], "0.007,1,-inf", *ROWS[8:]], "displacement is -inf at sample 7"),
        ([HEADER, *ROWS[:7], "inf,1,1", *ROWS[8:]], "time is inf at sample 7"),
        ([HEADER, *ROWS, *ROWS], "time runs backwards at sample 50, from 0.049 s to 0 s"),
        (
            [HEADER, *(f"{k},{k},5,0{k % 10}" for k in range(20))],
            "line 2: 4 cells, the header in line 1 has 3; line 1 should be such as time_s,",
        ),
        ([HEADER, "s,V,m", *ROWS], "line 2: 's' in column 'time_s' is not a number"),
        ([HEADER, *ROWS[:7], "0.007,1_0,1", *ROWS[8:]], "line 9: '1_0' in column 'voltage_V'"),
        (
            [line.replace(",", ";").replace(".", ",") for line in (HEADER, *ROWS)],
            "line 2: '0,000' in column 'time_s' is not a number; numbers have decimal points, no",
        ),
        (
            [HEADER, *ROWS[:7], f"0.007,7{ROWS[8]}", *ROWS[9:]],
            "line 9: 4 cells, the header in line 1 has 3; repair the line, and numbers have decim",
        ),
        ([HEADER, *ROWS[:7], "0.007,0,5,0,1", *ROWS[8:]], "line 9: 5 cells, the header in line 1"),
    ],
)
def test_bad_input_gets_one_clear_line(tmp_path: Path, lines: list[str], expected: str) -> None:
    assert expected in complaint(write(tmp_path, *lines))


@pytest.mark.parametrize("content", [b"\0\1\2\3" * 100, b"\xff\xfe" + HEADER.encode("utf-16-le")])
def test_what_is_no_text(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "run.csv"
    path.write_bytes(content)
    assert "is neither a rosbag2 nor a CSV in UTF-8" in complaint(path)


def test_a_quote_that_the_header_leaves_open_does_no_harm(tmp_path: Path) -> None:
    rows = [f"{1e-3 * k},{k},{k}" for k in range(20000)]  # more than the longest field of a CSV
    assert len(read_recording(write(tmp_path, f'{HEADER},"open', *rows))) == len(rows)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    assert "does not exist" in complaint(tmp_path / "no.csv")


def test_a_csv_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    recording = Recording("run", 1e-3, VOLTAGE)
    with pytest.raises(MicrogripperError, match="cannot be written"):
        write_csv(Path("/dev/null/run.csv"), recording)
    write_csv(tmp_path / "out" / "run.csv", recording)
    assert [file.name for file in (tmp_path / "out").iterdir()] == ["run.csv"]


@pytest.mark.parametrize("cut", range(1, 18))
def test_a_last_line_that_was_cut_off_is_left_out(tmp_path: Path, cut: int) -> None:
    """Wherever a logger was killed; 3.95e-06 without its end would be metres."""
    rows = [f"{1e-3 * k:.3f},{k},{1e-7 * k:.5e}" for k in range(40)]
    path = tmp_path / "killed.csv"
    path.write_text("time_s,voltage_V,displacement_m\n" + "\n".join(rows)[:-cut])
    recording = read_recording(path)
    assert len(recording) == 39
    assert recording.measured.max() < 1e-5
    assert recording.warnings == ("the last line is cut off: it was left out",)


@pytest.mark.parametrize("cut", range(3, 17))
def test_a_number_without_its_end_is_left_out(tmp_path: Path, cut: int) -> None:
    """81.0 without its last digits is 8."""
    k = np.arange(395)
    rows = [f"{1e-3 * k:.3f},{75 + 70 * np.sin(k / 50):.2f},{80 + k % 3:.1f}" for k in k.tolist()]
    path = tmp_path / "killed.csv"
    path.write_text("time_s,voltage_V,gauge_um\n" + "\n".join(rows)[:-cut])
    recording = read_recording(path, Mapping.parse(["displacement=gauge_um*1e-6"]))
    assert len(recording) == 394
    assert recording.warnings == ("the last line is cut off: it was left out",)


@pytest.mark.parametrize("end", ["", "\n"])
def test_what_a_logger_appends_meanwhile_does_no_harm(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, end: str
) -> None:
    """Its last line is cut off as it is read, whether or not it is complete right after that."""
    rows = [f"{1e-3 * k:.3f},{k},{80 + k % 3}" for k in range(40)]
    path = tmp_path / "growing.csv"
    path.write_text("\n".join(["time_s,voltage_V,displacement_m", *rows[:-1], ""]))
    loadtxt = np.loadtxt

    def appended(text: str) -> None:
        with path.open("a") as file:
            file.write(text)

    def slowly(*given: object, **named: object) -> object:
        appended(rows[-1][:-1])
        found = loadtxt(*given, **named)
        appended(end)
        return found

    monkeypatch.setattr(np, "loadtxt", slowly)
    recording = read_recording(path)
    assert len(recording) == 39
    assert recording.measured.min() == 80.0


def test_a_whole_last_line_needs_no_end(tmp_path: Path) -> None:
    rows = [f"{1e-3 * k:.3f},{k},{1e-7 * k:.5e}" for k in range(40)]
    path = tmp_path / "whole.csv"
    path.write_text("time_s,voltage_V,displacement_m\n" + "\n".join(rows))
    recording = read_recording(path)
    assert len(recording) == 40
    assert recording.warnings == ()


def test_text_with_line_breaks_in_the_last_row(tmp_path: Path) -> None:
    rows = [f"{1e-3 * k:.3f},{k},{1e-7 * k:.5e},ok" for k in range(40)]
    rows[-1] = rows[-1].replace("ok", '"long\nnote, with, many, commas, in it"')
    path = tmp_path / "notes.csv"
    path.write_text("\n".join(["time_s,voltage_V,displacement_m,note", *rows, ""]))
    assert len(read_recording(path)) == 40


def test_a_pipe_is_refused_before_anything_is_read_from_it(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    with pytest.raises(MicrogripperError, match=r"is a pipe or a device, .* save it to a file"):
        read_recording(tmp_path / "pipe.csv")


def test_decimal_commas_behind_a_first_row_of_whole_numbers(tmp_path: Path) -> None:
    rows = ["0,0,0", *(f"{k},{k},5,1,25" for k in range(1, 40))]
    path = tmp_path / "commas.csv"
    path.write_text("\n".join(["time_s,voltage_V,displacement_m", *rows, ""]))
    with pytest.raises(MicrogripperError, match=r"the last line: 5 cells, .* decimal points"):
        read_recording(path)


def test_a_setpoint_of_another_name_may_be_missing_as_well(tmp_path: Path) -> None:
    rows = [f"{1e-3 * k:.3f},{k},{k}e-7,{'' if k < 5 else k}" for k in range(40)]
    path = tmp_path / "run.csv"
    path.write_text("\n".join(["time_s,voltage_V,displacement_m,ref", *rows, ""]))
    recording = read_recording(path, Mapping.parse(["setpoint=ref*1e-7"]))
    assert recording.setpoint is not None
    assert np.count_nonzero(np.isnan(recording.setpoint)) == 5
