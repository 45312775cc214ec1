"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TextIO

from microgripper_control.core.errors import MicrogripperError


def make_folder(path: str | Path) -> Path:
    """Make a folder, with those above it, if it is not there.

    MicrogripperError if that fails or nothing can be written into it.
    """
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except OSError as error:
        raise MicrogripperError(f"{path}: cannot be made or written: {error.strerror}") from None
    return path


def check_place(path: str | Path, given: Iterable[str | Path] = ()) -> None:
    """Check that a file can be written later, in a folder that may be made then.

    MicrogripperError if it cannot take that name, or if the file would replace one of the `given`
    that it is made from.
    """
    path = _behind(Path(path))
    if any(os.path.realpath(path) == os.path.realpath(one) for one in given):
        raise MicrogripperError(f"{path}: would overwrite what is read; give another name")
    missing = _missing(path.parent)
    make_folder(path.parent)
    for made in missing:  # nothing is left behind if there will be nothing to write
        with suppress(OSError):
            made.rmdir()
    try:
        folder, taken = path.is_dir(), path.exists() and not path.is_file()
    except OSError as error:  # too long a name
        raise MicrogripperError(f"{path}: cannot be written: {error.strerror}") from None
    if taken:
        kind = "a folder" if folder else "no regular file"
        raise MicrogripperError(f"{path}: is {kind}; give the name of a file")


def refuse_pipe(path: Path) -> None:
    """Raise MicrogripperError where a path names neither a file nor a folder: it is read twice."""
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise MicrogripperError(
            f"{path}: is a pipe or a device, and it is read more than once; save it to a file first"
        )


def _missing(folder: Path) -> list[Path]:
    """A folder and those above it, as far as they are not there."""
    try:
        return [path for path in (folder, *folder.parents) if not path.exists()]
    except OSError:
        return []  # told where it is made


def _behind(path: Path) -> Path:
    """What a link points to, which is written while the link stays; else the path itself."""
    try:
        return Path(os.path.realpath(path)) if path.is_symlink() else path
    except OSError:
        return path  # told where it is written


def _mode(path: Path) -> int:
    """Who may read and write a file: as it was, or as the process makes new ones."""
    if path.exists():
        return path.stat().st_mode & 0o777
    mask = os.umask(0o077)
    os.umask(mask)
    return 0o666 & ~mask


@contextmanager
def written_whole(path: str | Path) -> Iterator[TextIO]:
    """Yield a text file that takes its name only when it is complete and on disk.

    Parent folders are made. Raises MicrogripperError where the place cannot be written.
    """
    path = Path(path)
    try:
        path = _behind(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise MicrogripperError(f"{path}: cannot be written: {error.strerror}") from None
    temporary = Path(name)
    try:
        # Names of files that are not UTF-8 come as lone surrogates.
        with os.fdopen(handle, "w", encoding="utf-8", errors="backslashreplace") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        temporary.chmod(_mode(path))
        temporary.replace(path)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise MicrogripperError(f"{path}: cannot be written: {error.strerror}") from None
        raise
