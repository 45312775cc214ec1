"""Who writes into a folder says so, and who would write there as well asks."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

from microgripper_control.core.errors import MicrogripperError


class FolderLock:
    """Keeps a folder from all others that lock it, until `close` or the death of the process.

    Raises MicrogripperError where another has it, with what to do then as its `remedy`. A file
    system that knows no locks grants all.
    """

    def __init__(self, folder: Path, remedy: str = "stop the recorder first") -> None:
        self._handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.close()
            raise MicrogripperError(f"{folder}: is being written; {remedy}") from None
        except OSError:
            pass

    def close(self) -> None:
        """Let others have it; once."""
        os.close(self._handle)
