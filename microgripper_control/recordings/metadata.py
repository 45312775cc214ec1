"""What rosbag2 says of a bag, in its metadata.yaml or inside a storage file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.safe_yaml import load_yaml

METADATA = "metadata.yaml"


@dataclass(frozen=True)
class Metadata:
    """The bag's files in order, whether rosbag2 compressed them, and the messages by topic."""

    files: list[str]
    compressed: bool
    counts: dict[str, int]

    @classmethod
    def read(cls, folder: Path) -> Metadata | None:
        """Those of a bag's folder; None where they are not there or not whole.

        Raises MicrogripperError where they name a file outside of the folder.
        """
        try:
            content = load_yaml((folder / METADATA).read_text(encoding="utf-8"))
            told = content["rosbag2_bagfile_information"]  # type: ignore[index]
            if int(told["version"]) >= 5 and "files" not in told:
                return None  # cut off: from version 5 on it follows the names of the files
            names = [str(name) for name in told["relative_file_paths"]]
            for name in names:
                if _leads_out(name):
                    raise MicrogripperError(
                        f"{folder}: {METADATA} lists {name!r:.80}, outside of the bag; "
                        "not followed: remove it"
                    )
            return cls(
                # Names alone: the first versions of rosbag2 wrote the folder's name before them.
                files=[PurePosixPath(name).name for name in names],
                compressed=str(told.get("compression_mode") or "NONE").upper() != "NONE",
                counts=_counts(told),
            )
        except FileNotFoundError:
            return None
        except (ValueError, TypeError, KeyError, AttributeError, OverflowError):
            return None


def counts_in(text: str) -> dict[str, int]:
    """Messages by topic, as rosbag2 puts them into a storage file; empty if it is not readable."""
    try:
        return _counts(load_yaml(text))
    except (ValueError, TypeError, KeyError, OverflowError):
        return {}


def _counts(told: object) -> dict[str, int]:
    return {
        str(topic["topic_metadata"]["name"]): int(topic["message_count"])
        for topic in told["topics_with_message_count"]  # type: ignore[index]
    }


def _leads_out(name: str) -> bool:
    paths = PurePosixPath(name), PureWindowsPath(name)
    return any(path.is_absolute() or path.drive or ".." in path.parts for path in paths)
