# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Write a rosbag2 bag in MCAP storage, without rosbag2."""

import errno
import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path

from rodless_base.atomic_write import cannot_be_written, removal_of_new
from rodless_base.closing import Closing
from rodless_base.file_path import file_path
from rodless_lab.bags.being_written import locked
from rodless_lab.bags.decompress import Decompressor, is_zstd
from rodless_lab.bags.description_check import READ_ANYHOW, RECOVER, other_counts
from rodless_lab.bags.mcap_file.index import McapIndex
from rodless_lab.bags.mcap_file.reader import McapReader
from rodless_lab.bags.mcap_file.records import McapError
from rodless_lab.bags.mcap_file.writer import McapWriter
from rodless_lab.bags.message_definition import message_definition
from rodless_lab.bags.metadata import (
    METADATA_FILE,
    BagError,
    BagTopic,
    FileContents,
    information_text,
    is_plain,
    is_within,
    memory_for,
    storage_files,
    write_metadata,
)
from rodless_lab.bags.recorded_topics import Profiles, recorded_topics

# Where rosbag2 looks in the storage file for its own description of the bag.
_METADATA_RECORD = "rosbag2"


class BagWriter(Closing):
    """A bag under construction at ``path``, a folder that must not exist yet.

    What a crash leaves is what :meth:`flush` has handed over; :func:`recover_bag` makes a bag of
    it. ``metadata.yaml`` is written by :meth:`close`: a bag without it was never closed.
    ``failure`` is why the bag cannot be written any more, if so.
    """

    def __init__(self, path: str | Path) -> None:
        """Create the folder; raises :class:`BagError`."""
        self.path = file_path(path, BagError)
        self._channels: dict[str, int] = {}
        self._was_in_place = False  # as it was closed
        self.failure: BagError | None = None
        file = f"{Path(os.path.realpath(self.path)).name}_0.mcap"
        self._remove_folders = removal_of_new(self.path)
        try:
            self.path.mkdir(parents=True)
        except FileExistsError as error:
            raise BagError(f"{path}: exists already; a bag is never written over") from error
        except OSError as error:
            self._remove_folders()
            raise BagError(cannot_be_written(path, error)) from error
        try:
            self._file = McapWriter(self.path / file)
            self._file.add_metadata(*_description([_contents(file, self._file.index, Profiles())]))
        except OSError as error:
            # What is no bag is not in the way of the next try.
            with suppress(OSError):  # a name too long, or a folder without the right to write
                (self.path / file).unlink()
            self._remove_folders()
            raise BagError(cannot_be_written(path, error)) from error

    def add_topic(self, topic: BagTopic) -> None:
        """Announce a topic, with the definition of its type as installed here.

        Raises :class:`BagError` for one whose messages are not all of its type and in CDR, which
        they would be labelled as.
        """
        topic.check_readable()
        definition = message_definition(topic.type_name)
        self._channels[topic.name] = self._file.add_channel(
            topic.name,
            topic.type_name,
            definition.encoding,
            definition.text,
            {
                "offered_qos_profiles": topic.qos_text,
                "topic_type_hash": topic.type_hash or definition.type_hash,
            },
        )

    def write(
        self, topic: str, data: bytes, log_time: int, publish_time: int, sequence: int = 0
    ) -> None:
        """Add a message in CDR, times in ns; raises :class:`BagError` when the disk is full.

        Raises struct.error for times that the file has no room for.
        """
        channel = self._channels[topic]
        self._attempt(self._file.add_message, channel, log_time, publish_time, data, sequence)

    def flush(self) -> None:
        """Put all messages so far out of a crash's reach; raises :class:`BagError`.

        So it does for a bag that is no longer where it was begun.
        """
        self._attempt(self._file.flush)
        if not self._file.is_in_place:
            self.failure = BagError(_gone(self.path))
            raise self.failure

    def _attempt(self, action: Callable[..., None], *arguments: object) -> None:
        """Turn a failure to write into the end of writing."""
        if self.failure is not None:
            raise self.failure
        try:
            action(*arguments)
        except OSError as error:
            self.failure = BagError(f"{self.path}: cannot be written any more: {error.strerror}")
            raise self.failure from error

    @property
    def counts(self) -> Mapping[str, int]:
        """Messages in the bag by topic: those flushed so far, or after ``close`` all."""
        return _counts(self._file.index)

    def close(self) -> None:
        """End the bag so that it opens, if need be at the cost of its last messages.

        ``failure`` says afterwards whether the bag is whole. To close it again does nothing.
        """
        if self._file.closed:
            return
        with suppress(BagError):
            self.flush()
        self._was_in_place = self._file.is_in_place
        with self._file:
            try:
                given_up = _finish(self.path, self._file, Profiles())
            except BagError as error:
                self.failure = error
            else:
                if given_up and self.failure is None:
                    self.failure = BagError(
                        f"{self.path}: no room for the end of its file: the last {given_up} "
                        "messages were given up for it"
                    )

    def remove(self) -> None:
        """Remove a closed bag that never began, so that it is not in the way of the next try.

        Nothing is removed but what was made for it, nor what has come in its place.
        """
        if not self._was_in_place:
            return
        for file in (self._file.name, METADATA_FILE):
            with suppress(OSError):
                (self.path / file).unlink()
        self._remove_folders()


def recover_bag(path: str | Path) -> int:
    """End a bag whose recording was killed, in place, so that it opens again.

    Only the cut end of its files is thrown away; a bag that was closed stays as it is, and so does
    a file for whose end there is no room. Returns the number of messages. Raises :class:`BagError`,
    also for a bag damaged before its end, in another storage than MCAP, compressed, with a file
    that leads out of its folder, that is still being recorded, or that was closed and has other
    messages than its description says.
    """
    bag = file_path(path, BagError)
    if not bag.is_dir():
        raise BagError(f"{path}: not the folder of a bag")
    files = storage_files(bag)
    for file in files:
        _check_ours(bag, file)
    _check_within(bag, bag / METADATA_FILE)
    with ExitStack() as locks:
        for file in files:
            _lock(file, locks)
        decompressor, profiles = Decompressor(), Profiles()
        readers = {}
        for file in files:
            with memory_for(file):
                readers[file] = _scanned(file, decompressor, profiles)
        try:
            done = _ended(bag, readers, profiles)
        except OSError as error:
            left = "no message is lost; where that is mended, try again"
            raise BagError(f"{cannot_be_written(path, error)}; {left}") from error
    return sum(sum(contents.counts.values()) for contents in done)


def _ended(bag: Path, readers: Mapping[Path, McapReader], profiles: Profiles) -> list[FileContents]:
    """End the files that are not complete, and describe the bag; raises OSError."""
    done: list[FileContents] = []
    for file, reader in readers.items():
        if not reader.complete:
            with McapWriter.resume(file, reader.index, reader.last_chunk) as writer:
                contents = _contents(file.name, reader.index, profiles)
                writer.finish(*_description([*done, contents]))
        done.append(_contents(file.name, reader.index, profiles))
    closed_before = all(reader.complete for reader in readers.values())
    if closed_before and (bag / METADATA_FILE).is_file():
        _check_described(bag, list(readers), done)
    else:
        write_metadata(bag, done)
    return done


def _check_described(bag: Path, files: Sequence[Path], contents: Iterable[FileContents]) -> None:
    """Refuse a bag that was closed, and has other messages than were written then."""
    counts: Counter[str] = Counter()
    for one in contents:
        counts.update(one.counts)
    differ = other_counts(bag, files, counts, RECOVER)
    if differ:
        raise BagError(f"{bag}: {differ}")


def _check_ours(bag: Path, file: Path) -> None:
    """Refuse a file that this does not write, or that is somebody else's."""
    if not is_plain(file):
        raise BagError(f"{bag}: {file.name} is not plain MCAP; `ros2 bag reindex` may help")
    _check_within(bag, file)


def _check_within(bag: Path, file: Path) -> None:
    if not is_within(bag, file):
        way = "; remove that link" if file.name == METADATA_FILE else ""  # it holds no message
        raise BagError(f"{bag}: {file.name} leads out of the bag, to {file.resolve()}{way}")


def _lock(file: Path, locks: ExitStack) -> None:
    try:
        locks.enter_context(locked(file))
    except OSError as error:
        raise BagError(f"{file}: cannot be read: {error.strerror}") from error


def _scanned(file: Path, decompressor: Decompressor, profiles: Profiles) -> McapReader:
    reader = McapReader(file, decompressor)
    try:
        decompressor.allow(file.stat().st_size)
        for message in reader.messages():
            if is_zstd(message.data):
                # Its description must say so, and how it was compressed is not known here.
                raise BagError("holds messages compressed one by one; try `ros2 bag reindex`")
        # Before anything is changed.
        recorded_topics(reader.index, profiles)
    except BagError as error:
        raise BagError(f"{file}: {error}") from error
    except McapError as error:  # to end it there would cost what stands behind
        left = f"nothing is changed; {READ_ANYHOW} reads what can be read"
        raise BagError(f"{file}: {error}; {left}") from error
    except OSError as error:
        raise BagError(f"{file}: cannot be read: {error.strerror}") from error
    return reader


def _finish(bag: Path, writer: McapWriter, profiles: Profiles) -> int:
    """Write the end of the storage file and ``metadata.yaml``, dropping messages to make room.

    Returns how many. None is dropped for what no room helps: the file then ends with all of them.
    """
    recorded = writer.index.counts.total()
    stretches = 1  # twice as many each time: one at a time would take hours after a day
    while True:
        files = [_contents(writer.name, writer.index, profiles)]
        try:
            writer.finish(*_description(files))
            if not writer.is_in_place:
                raise BagError(_gone(bag))
            write_metadata(bag, files)
        except OSError as error:
            if _has_other_cause(bag, error) or not writer.index.drop_last(stretches):
                raise BagError(
                    f"{cannot_be_written(error.filename or bag, error)}; where that is mended, "
                    f"`rodless recover {bag}` ends the bag"
                ) from error
            stretches *= 2
        else:
            return recorded - writer.index.counts.total()


def _has_other_cause(bag: Path, error: OSError) -> bool:
    """Whether an ``error`` comes from anything but messages that take the room of the end."""
    if error.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return True
    room = os.statvfs(bag)
    # No further file can be made, however short the others are. Some file systems count none.
    return room.f_files > 0 and room.f_favail == 0


def _gone(bag: Path) -> str:
    return (
        f"{bag}: was removed or moved while it was recorded; "
        "`rodless recover` ends it where it is now"
    )


def _description(files: list[FileContents]) -> tuple[str, dict[str, str]]:
    return _METADATA_RECORD, {"serialized_metadata": information_text(files)}


def _contents(name: str, index: McapIndex, profiles: Profiles) -> FileContents:
    return FileContents(
        name=name,
        first_time=index.first_time,
        last_time=index.last_time,
        topics=recorded_topics(index, profiles),
        counts=_counts(index),
    )


def _counts(index: McapIndex) -> dict[str, int]:
    """Return how many messages each topic has, also where that is none."""
    counts = {channel.topic: 0 for channel in index.channels.values()}
    # A topic may have several channels, where others have written the file.
    for number, count in index.counts.items():
        counts[index.channels[number].topic] += count
    return counts
