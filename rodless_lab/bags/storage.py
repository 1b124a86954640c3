# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What one storage file of a bag holds, whichever storage and compression rosbag2 used."""

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from rodless_lab.bags.being_written import still_written, writer_of
from rodless_lab.bags.decompress import Decompressor, is_zstd
from rodless_lab.bags.mcap_file.reader import McapReader
from rodless_lab.bags.mcap_file.records import McapError
from rodless_lab.bags.metadata import COMPRESSED, BagError, BagTopic, memory_for
from rodless_lab.bags.recorded_topics import Profiles, RecordedTopics
from rodless_lab.bags.sqlite_file import left_beside, sqlite_messages
from rodless_lab.bags.written_order import in_order

Times = npt.NDArray[np.int64]


@dataclass
class Recorded:
    """The messages of one topic in the order they were recorded, times in ns."""

    topic: BagTopic
    log_time: list[int] = field(default_factory=list)
    publish_time: list[int] = field(default_factory=list)
    payloads: list[bytes] = field(default_factory=list)
    compressed: bool = False  # message by message
    latest: BagTopic | None = None  # of the last message, as its file has it

    def note_type(self, topic: BagTopic) -> None:
        """Take note of the type that messages are of from here on: a name may have several."""
        self.latest = topic
        if not self.payloads:
            self.topic = topic
        elif topic.form not in (self.topic.form, *self.topic.other_types):
            self.topic = replace(self.topic, other_types=(*self.topic.other_types, topic.form))

    def add(self, log_time: int, publish_time: int, data: bytes) -> None:
        """Add a message."""
        self.log_time.append(log_time)
        self.publish_time.append(publish_time)
        self.payloads.append(data)

    def sort(self) -> None:
        """Undo what rosbag2's threads do: which message is compressed first is written first."""
        places = in_order(self.log_time)
        self.log_time = [self.log_time[place] for place in places]
        self.publish_time = [self.publish_time[place] for place in places]
        self.payloads = [self.payloads[place] for place in places]


@dataclass
class Storage:
    """What a bag's files hold: topics by name, and the first fault of a file, if there is one.

    The rest of that file is missing then. ``damaged`` is a bag of which more is wrong than a cut
    end; ``under_way`` says which process is still writing a file, if one is. All files draw on one
    ``decompressor``, and repeat each other's ``profiles``.
    """

    recorded: dict[str, Recorded] = field(default_factory=dict)
    fault: str = ""
    damaged: bool = False
    under_way: str = ""
    decompressor: Decompressor = field(default_factory=Decompressor)
    profiles: Profiles = field(default_factory=Profiles)

    @property
    def counts(self) -> dict[str, int]:
        """Messages by topic."""
        return {name: len(one.payloads) for name, one in self.recorded.items()}

    def of(self, topic: BagTopic) -> Recorded:
        """Return what there is of ``topic``, of whatever type."""
        found = self.recorded.get(topic.name)
        if found is None:
            found = self.recorded[topic.name] = Recorded(topic)
        return found

    def note_damage(self, fault: str) -> None:
        """Take note that the rest of a file cannot be read."""
        self.fault = self.fault or fault
        self.damaged = True


def read_storage(file: Path, into: Storage) -> None:
    """Add the contents of ``file`` (MCAP or SQLite, compressed or not); raises :class:`BagError`.

    Where it is damaged, ``into.fault`` says so.
    """
    try:
        into.decompressor.allow(file.stat().st_size)
        with memory_for(file):
            _read_any(file, into)
    except OSError as error:
        raise BagError(f"{file}: cannot be read: {error.strerror or error}") from error
    except BagError as error:
        raise BagError(str(error) if str(file) in str(error) else f"{file}: {error}") from error
    except ValueError as error:
        into.note_damage(f"{file.name} {error}")


def _read_any(file: Path, into: Storage) -> None:
    if file.suffix == COMPRESSED:
        with tempfile.TemporaryDirectory() as folder:
            plain = Path(folder, file.stem)
            into.decompressor.file(file, plain)
            _read_plain(plain, into)
        return
    try:
        _read_plain(file, into)
    except BagError:
        raise
    except ValueError as error:  # or half written
        into.note_damage(f"{file.name} {error}")
    if into.fault or file.suffix != ".mcap":  # no other storage says that it is whole
        _look_who_writes(file, into)


def _look_who_writes(file: Path, into: Storage) -> None:
    """Take note of who is still writing ``file``, which may be whole for the moment."""
    writer = writer_of(file)
    if writer:
        into.fault = into.under_way = f"{file.name} {still_written(writer)}"


def _read_plain(file: Path, into: Storage) -> None:
    decompressor, is_mcap = into.decompressor, file.suffix == ".mcap"
    messages = _mcap(file, into) if is_mcap else sqlite_messages(file, decompressor)
    for topic, log_time, publish_time, data in messages:
        recorded = into.of(topic)
        if topic is not recorded.latest:
            recorded.note_type(topic)
        compressed = is_zstd(data)
        recorded.compressed |= compressed
        recorded.add(log_time, publish_time, decompressor.message(data) if compressed else data)
    for beside in () if is_mcap else left_beside(file):
        into.fault = into.fault or (
            f"{file.name} was never closed: {beside.name} is still beside it; "
            f"`sqlite3 {file.name} 'PRAGMA journal_mode=DELETE'` makes one file of both"
        )


def _mcap(file: Path, into: Storage) -> Iterator[tuple[BagTopic, int, int, bytes]]:
    reader = McapReader(file, into.decompressor)
    topics = RecordedTopics(reader.index, into.profiles)
    try:
        for message in reader.messages():
            yield topics[message.channel], message.log_time, message.publish_time, message.data
        if not reader.complete:
            into.fault = into.fault or f"{file.name} {reader.unended}"
    except McapError as error:
        into.note_damage(f"{file.name} {error}")
    for topic in map(topics.__getitem__, reader.index.channels):
        into.of(topic)
