# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Read an MCAP file from front to back, as far as it goes."""

import mmap
import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from rodless_lab.bags.decompress import Decompressor, TooLargeError
from rodless_lab.bags.mcap_file.index import FOOTER_LENGTH, MAGIC, McapIndex, Stretch
from rodless_lab.bags.mcap_file.records import (
    LARGEST_TIME,
    MESSAGE,
    McapError,
    Record,
    T,
    find_whole,
    is_chunk,
    is_message,
    is_message_index,
    log_time,
    read_as,
    records,
)

_CHECKSUM = struct.Struct("<I")
_FOOTER = struct.Struct("<BQQQI")

_CUT = "is cut off, or was never closed because its recording was killed"
_DAMAGED_SUMMARY = "has a damaged summary behind its messages"

_NO_LENGTH = "a record of no possible length"

# The first of the kinds that everybody may use for what is their own.
_PRIVATE = 0x80

_HOUR = 3600 * 10**9

_DEFINITIONS = (Opcode.SCHEMA, Opcode.CHANNEL)
# What stands before all data, or behind them.
_ELSEWHERE = (
    Opcode.HEADER,
    Opcode.FOOTER,
    Opcode.CHUNK_INDEX,
    Opcode.ATTACHMENT_INDEX,
    Opcode.STATISTICS,
    Opcode.METADATA_INDEX,
    Opcode.SUMMARY_OFFSET,
)


class McapMessage(NamedTuple):
    """A message as it was recorded, times in ns."""

    channel: int
    sequence: int
    log_time: int
    publish_time: int
    data: bytes


class McapReader:
    """A file's messages in the order they were written, and its index when they have been read.

    ``complete`` says that the file was ended properly; otherwise it has been cut after
    ``index.end``, as a killed recording leaves it, or what stands there is no summary: ``unended``
    says which. ``last_chunk`` lists log time (ns) and place of each message in the last chunk, by
    channel.
    """

    def __init__(self, path: Path, decompressor: Decompressor) -> None:
        self._path = path
        self._decompressor = decompressor
        self.index = McapIndex()
        self.unended = _CUT
        self.last_chunk: dict[int, list[tuple[int, int]]] = {}
        # Before the first message: of an unknown kind, and built as one.
        self._doubtful: Record | None = None

    @property
    def complete(self) -> bool:
        """Whether the file was ended properly."""
        return not self.unended

    def messages(self) -> Iterator[McapMessage]:
        """Yield every message; raises :class:`McapError` and OSError."""
        with self._path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise McapError("is not an MCAP file, or cut within its first bytes")
            with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
                yield from self._messages(content)

    def _messages(self, content: mmap.mmap) -> Iterator[McapMessage]:
        self.index.end = len(MAGIC)
        for record in records(content, len(MAGIC)):
            try:
                if record.opcode == Opcode.DATA_END:
                    _check_data(content, record)
                    if content[-len(MAGIC) :] != MAGIC:
                        return
                    self._check_count(content, record)
                    whole = _is_summary_whole(content, record.end)
                    self.unended = "" if whole else _DAMAGED_SUMMARY
                    return
                yield from self._messages_in(record)
            except MemoryError:  # no damage
                raise
            except Exception as error:  # whatever a decoder trips over
                wrong = "is too large" if isinstance(error, TooLargeError) else "is damaged"
                raise McapError(f"{wrong} at byte {record.start}: {error}") from error
            self.index.end = record.end
        if len(content) > len(MAGIC) and content[-len(MAGIC) :] == MAGIC:
            # It was closed, so nothing is cut off.
            whole = self.index.end == len(content) - len(MAGIC)
            what = "it lacks the end of its data" if whole else _NO_LENGTH
            raise McapError(f"is damaged at byte {self.index.end}: {what}")
        behind = find_whole(content, self.index.end, self.index.channels)
        if behind is not None:
            raise McapError(
                f"is damaged at byte {self.index.end}: {_NO_LENGTH}, with a whole one behind it at "
                f"byte {behind}"
            )

    def _check_count(self, content: mmap.mmap, end: Record) -> None:
        """Raise :class:`McapError` where the file says that it has more messages, or fewer."""
        found = self.index.counts.total()
        for record in records(content, end.end):
            if record.opcode == Opcode.STATISTICS:
                try:
                    wanted = read_as(Statistics.read, record.content).message_count
                except Exception:  # damaged itself
                    return
                if wanted != found:
                    raise McapError(f"holds {found} messages, its statistics {wanted}")

    def _messages_in(self, record: Record) -> Iterator[McapMessage]:
        if record.opcode == 0:
            raise McapError("a record of no kind")
        if record.opcode == Opcode.CHUNK:
            yield from self._messages_in_chunk(record)
        elif record.opcode == Opcode.MESSAGE:
            if self._last_chunk_index is not None and is_message_index(record.content):
                raise McapError("the index of a chunk that calls itself a message")
            message = self._message(record.content)
            self._count_loose(record.start, message)
            yield message
        elif record.opcode == Opcode.MESSAGE_INDEX:
            self._add_message_index(record)
        elif record.opcode == Opcode.METADATA:
            name = read_as(Metadata.read, record.content).name
            length = record.end - record.start
            self.index.metadata.append(MetadataIndex(record.start, length, name))
        elif record.opcode in _DEFINITIONS:
            self._add_definition(record)
        elif record.opcode in _ELSEWHERE and record.start > len(MAGIC):
            raise McapError(f"a record of kind {record.opcode:#04x} among the data")
        elif is_chunk(record.content):
            raise McapError(f"a chunk that calls itself a record of kind {record.opcode:#04x}")
        elif record.opcode != Opcode.ATTACHMENT and is_message(record.content, self.index.channels):
            self._doubt(record)

    def _messages_in_chunk(self, record: Record) -> Iterator[McapMessage]:
        chunk = read_as(Chunk.read, record.content)
        if not is_chunk(record.content):
            raise McapError("a chunk whose records are longer or shorter than it says")
        content = self._decompressor.chunk(chunk.compression, chunk.data, chunk.uncompressed_size)
        if chunk.uncompressed_crc not in (0, zlib.crc32(content)):
            raise McapError("the checksum of a chunk is wrong")
        entries: dict[int, list[tuple[int, int]]] = {}
        end = 0
        for inner in records(content, 0):
            end = inner.end
            if inner.opcode == Opcode.MESSAGE:
                message = self._message(inner.content)
                entries.setdefault(message.channel, []).append((message.log_time, inner.start))
                yield message
            elif inner.opcode in _DEFINITIONS:
                self._add_definition(inner)
            elif inner.opcode < _PRIVATE or not chunk.uncompressed_crc:
                raise McapError(f"a record of kind {inner.opcode:#04x} in a chunk")
        if end != len(content):
            raise McapError("a chunk whose last record has no possible length")
        index = ChunkIndex(
            chunk_length=record.end - record.start,
            chunk_start_offset=record.start,
            compression=chunk.compression,
            compressed_size=len(chunk.data),
            message_end_time=chunk.message_end_time,
            message_index_length=0,
            message_index_offsets={},
            message_start_time=chunk.message_start_time,
            uncompressed_size=chunk.uncompressed_size,
        )
        counts = Counter({channel: len(listed) for channel, listed in entries.items()})
        self.last_chunk = entries
        self.index.stretches.append(
            Stretch(record.start, index.message_start_time, index.message_end_time, counts, index)
        )

    def _message(self, content: bytes) -> McapMessage:
        channel, sequence, logged, published = MESSAGE.unpack_from(content)
        if (time := max(logged, published)) > LARGEST_TIME:
            raise McapError(f"a message of {time} ns, later than ROS can express (2**63 ns)")
        if channel not in self.index.channels:
            raise McapError(f"holds a message of the unknown channel {channel}")
        return McapMessage(channel, sequence, logged, published, content[MESSAGE.size :])

    def _add_message_index(self, record: Record) -> None:
        index = self._last_chunk_index
        if index is None:
            raise McapError("the index of a chunk, behind none")
        channel = read_as(MessageIndex.read, record.content).channel_id
        index.message_index_offsets[channel] = record.start
        index.message_index_length += record.end - record.start

    def _doubt(self, record: Record) -> None:
        """Refuse a record of an unknown kind, built as a message, among those without chunk.

        Before all of them it is compared with the first.
        """
        if not self.index.stretches:
            self._doubtful = record
            return
        last = self.index.stretches[-1]
        if last.index is None:
            _refuse_lost_message(record, last.first_time, last.last_time)

    @property
    def _last_chunk_index(self) -> ChunkIndex | None:
        """That of the chunk that came last, None behind messages without one and before all."""
        stretches = self.index.stretches
        return stretches[-1].index if stretches else None

    def _count_loose(self, start: int, message: McapMessage) -> None:
        time, stretches = message.log_time, self.index.stretches
        if not stretches and self._doubtful is not None:
            _refuse_lost_message(self._doubtful, time, time)
        if not stretches or self._last_chunk_index is not None:
            stretches.append(Stretch(start, time, time, Counter()))
        stretch = stretches[-1]
        stretch.counts[message.channel] += 1
        stretch.first_time = min(stretch.first_time, time)
        stretch.last_time = max(stretch.last_time, time)

    def _add_definition(self, record: Record) -> None:
        if record.opcode == Opcode.SCHEMA:
            schema = read_as(Schema.read, record.content)
            _define(self.index.schemas, schema.id, schema, "schema")
        else:
            channel = read_as(Channel.read, record.content)
            _define(self.index.channels, channel.id, channel, "channel")


def _define(known: dict[int, T], number: int, found: T, kind: str) -> None:
    """Add what ``found`` defines; raises :class:`McapError` where the number means another.

    Messages before it and behind it would be of two topics, or of two types. It may be repeated.
    """
    if known.setdefault(number, found) != found:
        raise McapError(f"{kind} {number} is defined a second time, as another one")


def _refuse_lost_message(record: Record, first: int, last: int) -> None:
    """Raise :class:`McapError` where ``record`` is as old as messages from first to last (ns)."""
    if first - _HOUR <= log_time(record.content) <= last + _HOUR:
        kind = f"{record.opcode:#04x}"
        raise McapError(f"a message at byte {record.start} calls itself a record of kind {kind}")


def _is_summary_whole(content: mmap.mmap, start: int) -> bool:
    """Whether the footer stands where it must, and its checksum is that of a summary.

    Without a checksum, whether one record follows another up to the footer. The summary begins at
    offset ``start``; a footer without one says 0.
    """
    place = len(content) - len(MAGIC) - _FOOTER.size
    if place < start:
        return False
    opcode, length, begin, _, wanted = _FOOTER.unpack_from(content, place)
    if (opcode, length) != (Opcode.FOOTER, FOOTER_LENGTH) or begin not in (0, start):
        return False
    if not wanted:
        return any(record.start == place for record in records(content, start))
    end = place + _FOOTER.size - _CHECKSUM.size
    with memoryview(content) as whole, whole[start if begin else place : end] as summary:
        return bool(zlib.crc32(summary) == wanted)


def _check_data(content: mmap.mmap, end: Record) -> None:
    """Raise :class:`McapError` where the file has a checksum of all its data, and another one."""
    (wanted,) = _CHECKSUM.unpack_from(end.content)
    if not wanted:
        return
    with memoryview(content) as whole, whole[: end.start] as data:
        found = zlib.crc32(data)
    if found != wanted:
        raise McapError("the checksum of all data before is wrong")
