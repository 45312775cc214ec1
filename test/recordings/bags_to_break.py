"""A good bag, and what happens to bags."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.recording import Recording
from microgripper_control.recordings.read import read_recording

COUNT = 200
RECORDING = Recording(
    "run",
    1e-3,
    np.arange(COUNT) + 1.0,
    1e-9 * (np.arange(COUNT) + 1.0),
    1e-9 * (np.arange(COUNT) + 2.0),
)


def storage_file(bag: Path) -> Path:
    (file,) = [file for file in bag.iterdir() if file.suffix in (".mcap", ".db3")]
    return file


def damaged(bag: Path, folder: Path, content: bytes) -> Path:
    """A copy of the bag with another storage file."""
    copy = folder / "run"
    if not copy.exists():
        shutil.copytree(bag, copy)
    storage_file(copy).write_bytes(content)
    return copy


def files_in(folder: Path) -> dict[str, bytes]:
    """The contents of all files below a folder."""
    return {
        str(file.relative_to(folder)): file.read_bytes()
        for file in folder.rglob("*")
        if file.is_file()
    }


def recording_or_complaint(path: Path) -> Recording | None:
    """None if there is one clear line instead."""
    try:
        found = read_recording(path)
    except MicrogripperError as error:
        check_line(str(error), path)
        return None
    return found


def check_line(line: str, path: Path) -> None:
    """One line for a terminal, which names the file."""
    assert line.isprintable()
    assert str(path) in line


def agrees(found: Recording, recording: Recording = RECORDING) -> bool:
    """Whether one recording is the beginning of the other."""
    count = len(found)
    return (
        count <= len(recording)
        and np.array_equal(found.voltage, recording.voltage[:count])
        and np.array_equal(found.measured, recording.measured[:count])
    )
