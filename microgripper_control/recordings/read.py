"""Recordings in, whatever they are stored as."""

from __future__ import annotations

from pathlib import Path

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.files import refuse_pipe
from microgripper_control.core.recording import Recording
from microgripper_control.recordings import mcap, sqlite
from microgripper_control.recordings.bag import ROS1_MAGIC, SUFFIXES
from microgripper_control.recordings.bag_recording import read_bag
from microgripper_control.recordings.clean import cleaned
from microgripper_control.recordings.csv import read_csv
from microgripper_control.recordings.mapping import DEFAULT_MAPPING, Mapping
from microgripper_control.recordings.storage import COMPRESSED


def read_recording(
    path: str | Path, mapping: Mapping = DEFAULT_MAPPING, *, needs_displacement: bool = True
) -> Recording:
    """Read a rosbag2 (a folder, or a bare .mcap or .db3 file) or a CSV.

    Without `needs_displacement` a recording of the voltage alone will do. What had to be mended is
    in the recording's warnings; what cannot be is a MicrogripperError of one line.
    """
    path = Path(path)
    try:
        if not path.exists():
            raise MicrogripperError(f"{path}: does not exist; give a rosbag2 folder or a CSV file")
        refuse_pipe(path)
        is_bag = path.is_dir() or _looks_like_a_bag(path)
    except OSError as error:
        raise MicrogripperError(f"{path}: cannot be read: {error.strerror}") from None
    read = read_bag if is_bag else read_csv
    return cleaned(read(path, mapping, needs_displacement=needs_displacement))


def _looks_like_a_bag(path: Path) -> bool:
    with path.open("rb") as file:
        head = file.read(16)
    heads = (mcap.MAGIC, sqlite.MAGIC, ROS1_MAGIC, COMPRESSED)
    return path.suffix in SUFFIXES or head.startswith(heads)
