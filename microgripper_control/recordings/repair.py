"""A bag that was not closed, or was damaged, made whole again: its index and its metadata.

What can be read is written into a new bag beside it, which takes the damaged one's place once it is
complete, read back and on disk. The damaged one is kept under another name: at no instant is the
only copy at stake, and a repair that was cut off can be begun again.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.core.folder_lock import FolderLock
from microgripper_control.recordings.bag import Bag
from microgripper_control.recordings.bag_writer import STORAGES, BagWriter
from microgripper_control.recordings.storage import COMPRESSED, Topic

KEPT = ".damaged"  # added to the name of the bag that was repaired
STEP = 20_000  # messages between reports of progress

OnProgress = Callable[[str], None]


@dataclass(frozen=True)
class Repair:
    """What there is in the bag now, by topic, what was lost, and where the damaged bag is kept.

    `kept` is None where the bag was whole: then nothing was done.
    """

    bag: Path
    messages: dict[str, int]
    lost: tuple[str, ...] = ()
    kept: Path | None = None


def repair_bag(path: str | Path, progress: OnProgress = lambda stage: None) -> Repair:
    """Make a bag's folder whole; one that is whole is left as it is.

    Raises MicrogripperError where nothing of it can be read, it is being recorded, the original of
    an earlier repair is in the way, or the new bag cannot be written; then nothing has changed.
    """
    path = Path(os.path.realpath(path))
    kept, workshop = path.with_name(path.name + KEPT), path.with_name(f".{path.name}.repairing")
    try:
        if not path.exists() and kept.is_dir():
            kept.rename(path)  # a repair was cut off between its last two steps
        if path.is_file():
            raise MicrogripperError(
                f"{path}: is one file of a bag; give its folder, or put it into a folder of its own"
            )
        if not path.is_dir():
            raise MicrogripperError(f"{path}: does not exist")
        with closing(FolderLock(path)), Bag(path) as bag:
            shutil.rmtree(workshop, ignore_errors=True)  # of a repair that was cut off
            found = _count(bag, progress)
            if not bag.warnings:
                return Repair(path, found)
            if kept.exists():
                raise MicrogripperError(
                    f"{kept}: is there already, the original of an earlier repair; move it away"
                )
            messages, left_out = _replace(bag, path, kept, workshop, progress)
            return Repair(path, messages, (*bag.warnings, *left_out), kept)
    except OSError as error:
        raise MicrogripperError(f"{path}: cannot be repaired: {error.strerror}") from None


def _count(bag: Bag, progress: OnProgress) -> dict[str, int]:
    """Read everything, which also shows what is missing."""
    counts = dict.fromkeys((topic.name for topic in bag.topics), 0)
    for block in bag.blocks(bag.topics):
        if block.message(0).startswith(COMPRESSED):  # a new bag would say that they are not
            raise MicrogripperError(
                f"{bag.path}: its messages are compressed by rosbag2; decompress them first"
            )
        counts[block.topic.name] += len(block)
        progress(f"{sum(counts.values())} messages read")
    return counts


def _replace(
    bag: Bag, path: Path, kept: Path, workshop: Path, progress: OnProgress
) -> tuple[dict[str, int], list[str]]:
    """Write the new bag and put it in the old one's place."""
    workshop.mkdir()
    try:
        fresh = workshop / path.name
        written, left_out = _copy(bag, fresh, progress)
        with Bag(fresh) as copy:
            if _count(copy, progress) != written or copy.warnings:
                raise MicrogripperError(f"{path}: what was written is not read back; bad disk?")
        for file in (*fresh.iterdir(), fresh):
            _sync(file)
        path.rename(kept)
        try:
            fresh.rename(path)
        except OSError:
            kept.rename(path)
            raise
        _sync(path.parent)
    finally:
        shutil.rmtree(workshop, ignore_errors=True)
    return written, left_out


def _copy(bag: Bag, fresh: Path, progress: OnProgress) -> tuple[dict[str, int], list[str]]:
    """Write what can be read of a bag into a new one; the messages by topic, what was left out."""
    if bag.storage not in STORAGES:
        raise MicrogripperError(f"{bag.path}: is compressed by rosbag2; decompress it first")
    left_out: list[str] = []
    with BagWriter(fresh, bag.storage) as writer:
        topics = [topic for topic in bag.topics if _announce(writer, topic, left_out)]
        written = {topic.name: 0 for topic in topics}
        for number, (topic, at, content) in enumerate(bag.messages(topics)):
            writer.write(topic.name, at, content)
            written[topic.name] += 1
            if number % STEP == 0:
                progress(f"{number} messages written")
    return written, left_out


def _announce(writer: BagWriter, topic: Topic, left_out: list[str]) -> bool:
    """Add a topic to the new bag; whether that could be done."""
    for qos in dict.fromkeys((topic.qos, "")):
        try:
            writer.add_topic(
                topic.name, topic.type, qos, encoding=topic.encoding, definition=topic.definition
            )
        except MicrogripperError as error:
            left_out.append(str(error).removeprefix(f"{writer.path}: "))
        else:
            return True
    left_out.append(f"{topic} was left out")
    return False


def _sync(path: Path) -> None:
    """Wait until a file, or a folder's list of files, is on disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
