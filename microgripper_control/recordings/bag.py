"""A rosbag2: a folder with a metadata.yaml and storage files, or one storage file by itself."""

from __future__ import annotations

import heapq
import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from types import TracebackType

import numpy as np

from microgripper_control.core.errors import MicrogripperError
from microgripper_control.recordings import mcap, sqlite
from microgripper_control.recordings.library import LibraryBag
from microgripper_control.recordings.mcap import McapFile
from microgripper_control.recordings.metadata import METADATA, Metadata
from microgripper_control.recordings.sqlite import SqliteFile
from microgripper_control.recordings.storage import COMPRESSED, Block, StorageFile, Topic

SUFFIXES = (".mcap", ".db3")
PACKED = ".zstd"  # behind them, where rosbag2 compressed the file
ROS1_MAGIC = b"#ROSBAG"

Message = tuple[Topic, int, bytes]  # its topic, when it was received (ns since 1970), its content


class Bag:
    """A bag that is open for reading; a context manager.

    `topics` are in the order of their names. `warnings` is complete when the messages were read: it
    says what could not be. Raises MicrogripperError where there is nothing to read.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._notes: list[str] = []
        self._files: list[StorageFile] = []
        self._counts: Counter[str] = Counter()  # messages that were written, by topic
        try:
            if self.path.is_dir():
                self._open_folder()
            else:
                self._files.append(_open_file(self.path))
        except OSError as error:
            self.close()
            raise MicrogripperError(f"{self.path}: cannot be read: {error.strerror}") from None
        except MicrogripperError:
            self.close()
            raise
        if not self._counts:
            for file in self._files:
                self._counts.update(file.counts)
        found = dict.fromkeys(topic for file in self._files for topic in file.topics)
        self.topics = tuple(sorted(found, key=lambda topic: (topic.name, topic.type)))
        lost = {*+self._counts} - {topic.name for topic in found}
        self._notes.extend(self._shortage(name, 0) for name in sorted(lost))

    def __enter__(self) -> Bag:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def storage(self) -> str:
        """rosbag2's name of its format, that of its first file."""
        return self._files[0].storage

    @property
    def warnings(self) -> tuple[str, ...]:
        """What was found missing so far."""
        return (*self._notes, *(file.damage for file in self._files if file.damage))

    def close(self) -> None:
        """Let go of the files."""
        for file in self._files:
            file.close()

    def blocks(self, topics: Collection[Topic]) -> Iterator[Block]:
        """The messages of some topics, those of each near the order of receipt."""
        found = dict.fromkeys(topics, 0)
        for file in self._files:
            for block in file.blocks(topics):
                found[block.topic] += len(block)
                yield block
        for topic, count in found.items():
            if count < self._counts[topic.name]:
                note = self._shortage(topic.name, count)
                self._notes = [*(old for old in self._notes if old != note), note]

    def _shortage(self, name: str, count: int) -> str:
        return f"{name}: {count} of {self._counts[name]} messages are there"

    def messages(self, topics: Collection[Topic]) -> Iterator[Message]:
        """Topic, time of receipt (ns since 1970) and content of each message.

        In order of time as far as they are read together: of MCAP those of a chunk, one chunk after
        the other; of SQLite, whose topics are read side by side, those of all topics.
        """
        if any(file.storage == "sqlite3" for file in self._files):
            return _merged(self._messages_of([topic]) for topic in topics)
        return self._messages_of(topics)

    def _messages_of(self, topics: Collection[Topic]) -> Iterator[Message]:
        """The messages of some topics in one pass: blocks of other topics each are together."""
        place = {topic: index for index, topic in enumerate(topics)}
        together: list[Block] = []
        for block in self.blocks(topics):
            if together and place[block.topic] <= place[together[-1].topic]:
                yield from _merged(map(_messages_in, together))
                together = []
            together.append(block)
        yield from _merged(map(_messages_in, together))

    def _open_folder(self) -> None:
        metadata = Metadata.read(self.path)
        if metadata is not None:
            self._counts.update(metadata.counts)
        if metadata is not None and metadata.compressed:
            self._files.append(LibraryBag(self.path))
            return
        present = self._all_files() if metadata is None else self._listed_files(metadata)
        for file in present:
            try:
                self._files.append(_open_file(file, listed=metadata is not None))
            except MicrogripperError as error:
                if len(present) == 1:
                    raise
                self._notes.append(str(error))
        if not self._files:
            raise MicrogripperError(f"{self.path}: {'; '.join(self._notes)}")

    def _all_files(self) -> list[Path]:
        """The storage files of a folder without metadata, at least one."""
        present = _storage_files(self.path)
        if not present:
            raise MicrogripperError(
                f"{self.path}: is not a rosbag2: no {METADATA} and no .mcap or .db3 file in it"
            )
        self._notes.append(f"{METADATA} is missing or damaged; the storage files were read")
        return present

    def _listed_files(self, metadata: Metadata) -> list[Path]:
        """The storage files that the metadata lists and that are there, at least one."""
        listed = [self.path / name for name in metadata.files]
        lost = [file.name for file in listed if not file.is_file()]
        present = [file for file in listed if file.is_file()]
        others = [file.name for file in _storage_files(self.path) if file not in listed]
        if not present:
            names = ", ".join(lost) or "no storage file"
            remedy = f"; remove {METADATA} to read {', '.join(others)}" if others else ""
            raise MicrogripperError(f"{self.path}: {METADATA} lists {names}: not there{remedy}")
        self._notes.extend(f"{name} is listed in {METADATA} but not there" for name in lost)
        self._notes.extend(
            f"{name} is in the folder but not listed in {METADATA}: not read" for name in others
        )
        return present


def _merged(rows: Iterable[Iterator[Message]]) -> Iterator[Message]:
    return heapq.merge(*rows, key=lambda row: row[1])


def _messages_in(block: Block) -> Iterator[Message]:
    for index in np.argsort(block.received, kind="stable"):
        yield block.topic, int(block.received[index]), block.message(index)


def _open_file(path: Path, *, listed: bool = False) -> StorageFile:
    if not path.exists():
        raise MicrogripperError(f"{path}: does not exist")
    try:
        with path.open("rb") as file:
            head = file.read(max(len(mcap.MAGIC), len(sqlite.MAGIC)))
        if head.startswith(mcap.MAGIC):
            return McapFile(path)
        if head.startswith(sqlite.MAGIC):
            return SqliteFile(path, closed=listed)
    except OSError as error:
        raise MicrogripperError(f"{path}: cannot be read: {error.strerror}") from None
    if not head:
        raise MicrogripperError(f"{path}: is empty")
    if head.startswith(COMPRESSED):
        raise MicrogripperError(
            f"{path}: is compressed; unpack it with zstd -d {path.name} -o {path.stem}"
        )
    if head.startswith(ROS1_MAGIC):
        raise MicrogripperError(f"{path}: is a bag of ROS 1; convert it with rosbags-convert")
    raise MicrogripperError(f"{path}: is neither MCAP nor SQLite: not a rosbag2")


def _storage_files(folder: Path) -> list[Path]:
    """Those in a bag's folder in their order; of one that was unpacked what came out of it."""
    files = {file for file in folder.iterdir() if file.name.removesuffix(PACKED).endswith(SUFFIXES)}
    packed = {file.with_name(file.name + PACKED) for file in files}
    return sorted(files - packed, key=_natural_order)


def _natural_order(file: Path) -> list[tuple[int, str]]:
    """Sorts bag_2 before bag_10."""
    parts = re.findall(r"(\d+)|(\D+)", file.name)
    return [(int(number or 0), text) for number, text in parts]
