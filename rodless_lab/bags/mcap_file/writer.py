# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Write an MCAP file so that it can be ended wherever the writing stops."""

import errno
import os
import struct
import zlib
from collections import Counter
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
)

from rodless_base.closing import Closing
from rodless_base.forked import left_to_parent
from rodless_lab.bags.file_lock import lock_to_write
from rodless_lab.bags.mcap_file.index import MAGIC, McapIndex, Stretch, encoded
from rodless_lab.bags.metadata import CDR

# Bytes of messages a chunk holds before it is written: what a kill loses at most, beside time.
CHUNK_SIZE = 64 * 1024

_MESSAGE = struct.Struct("<BQHIQQ")
_MESSAGE_FIXED = _MESSAGE.size - 9
LARGEST_SEQUENCE = 2**32 - 1

# Log time (ns) and place in its chunk of each message, by channel.
Entries = dict[int, list[tuple[int, int]]]


class McapWriter(Closing):
    """An MCAP file of the profile ``ros2`` under construction.

    mcap's own writer cannot go on after a failed write. This one takes a write that failed back,
    so that on a full disk everything before it can still be ended with a summary; :meth:`resume`
    does the same for a file whose writer was killed.
    """

    def __init__(self, path: Path) -> None:
        """Begin a new file, which no other process may change; raises OSError."""
        self._begin(path, "x+b", McapIndex())
        if not lock_to_write(self._file.fileno()):
            raise OSError(errno.EBUSY, "another process writes there", str(path))
        self._append(MAGIC + encoded([Header(profile="ros2", library="rodless_lab")]))

    @classmethod
    def resume(cls, path: Path, index: McapIndex, last_chunk: Entries) -> "McapWriter":
        """Go on behind what ``index`` lists; what is written takes the place of what stands there.

        ``last_chunk`` lists the messages of the last chunk, whose own index may have been cut: it
        comes with the end of the file. The file is to be locked before ``index`` is made. Raises
        OSError.
        """
        writer = cls.__new__(cls)
        writer._begin(path, "r+b", index)
        chunk = index.stretches[-1].index if index.stretches else None
        if chunk is not None and chunk.message_index_offsets.keys() != last_chunk.keys():
            index.end = chunk.chunk_start_offset + chunk.chunk_length
            writer._owed, chunk.message_index_offsets = _message_indexes(index.end, last_chunk)
            chunk.message_index_length = len(writer._owed)
        return writer

    @property
    def is_in_place(self) -> bool:
        """Whether the file is still where it was begun: it may have been removed, or moved."""
        try:
            return os.path.samestat(os.fstat(self._file.fileno()), self._path.stat())
        except OSError:
            return False

    def _begin(self, path: Path, mode: str, index: McapIndex) -> None:
        self.name, self._path = path.name, path.absolute()
        self.index = index
        self._file = path.open(mode, buffering=0)
        left_to_parent(self)
        self._chunk = bytearray()
        self._entries: Entries = {}
        # What the last chunk lacks.
        self._owed = b""

    def add_channel(
        self, topic: str, schema_name: str, encoding: str, text: str, metadata: dict[str, str]
    ) -> int:
        """Add a topic of CDR messages; channels of one ``schema_name`` share its schema."""
        schema = self._schema(schema_name, encoding, text)
        channel = Channel(
            id=len(self.index.channels) + 1,
            topic=topic,
            message_encoding=CDR,
            metadata=metadata,
            schema_id=schema.id,
        )
        self.index.channels[channel.id] = channel
        self._chunk += encoded([channel])
        return channel.id

    def _schema(self, name: str, encoding: str, text: str) -> Schema:
        for known in self.index.schemas.values():
            if known.name == name:
                return known
        number = len(self.index.schemas) + 1
        schema = Schema(id=number, data=text.encode(), encoding=encoding, name=name)
        self.index.schemas[number] = schema
        self._chunk += encoded([schema])
        return schema

    def add_message(
        self, channel: int, log_time: int, publish_time: int, data: bytes, sequence: int = 0
    ) -> None:
        """Add a message, times in ns; raises OSError when a full chunk cannot be written.

        The format has room for 32 bits of the ``sequence``; a publisher's counter has 64. Raises
        struct.error for other numbers that it has no room for; nothing is added then.
        """
        length = _MESSAGE_FIXED + len(data)
        lowest = sequence & LARGEST_SEQUENCE
        fixed = _MESSAGE.pack(Opcode.MESSAGE, length, channel, lowest, log_time, publish_time)
        entry = (log_time, len(self._chunk))
        self._entries.setdefault(channel, []).append(entry)
        self._chunk += fixed
        self._chunk += data
        if len(self._chunk) >= CHUNK_SIZE:
            self.flush()

    def flush(self) -> None:
        """Hand everything added so far to the operating system.

        Raises OSError when that fails; the messages since the last flush are lost then, and
        the file ends as it did before.
        """
        if not self._entries:
            return
        entries, self._entries = self._entries, {}
        content, self._chunk = bytes(self._chunk), bytearray()
        times = [time for listed in entries.values() for time, _ in listed]
        chunk = Chunk(
            compression="",
            data=content,
            message_start_time=min(times),
            message_end_time=max(times),
            uncompressed_crc=zlib.crc32(content),
            uncompressed_size=len(content),
        )
        self._append_chunk(chunk, entries)

    def _append_chunk(self, chunk: Chunk, entries: Entries) -> None:
        start = self.index.end
        if os.fstat(self._file.fileno()).st_size != start:
            raise OSError(errno.EBUSY, "another program has changed its file", str(self._path))
        content = encoded([chunk])
        indexes, offsets = _message_indexes(start + len(content), entries)
        self._append(content + indexes)
        index = ChunkIndex(
            chunk_length=len(content),
            chunk_start_offset=start,
            compression="",
            compressed_size=len(chunk.data),
            message_end_time=chunk.message_end_time,
            message_index_length=len(indexes),
            message_index_offsets=offsets,
            message_start_time=chunk.message_start_time,
            uncompressed_size=chunk.uncompressed_size,
        )
        counts = Counter({channel: len(listed) for channel, listed in entries.items()})
        self.index.stretches.append(
            Stretch(start, chunk.message_start_time, chunk.message_end_time, counts, index)
        )

    def add_metadata(self, name: str, text: dict[str, str]) -> None:
        """Write a metadata record before the first message; raises OSError."""
        record = encoded([Metadata(metadata=text, name=name)])
        place = MetadataIndex(offset=self.index.end, length=len(record), name=name)
        self._append(record)
        self.index.metadata.append(place)

    def finish(self, name: str, text: dict[str, str]) -> None:
        """Write a last metadata record and the summary; may be repeated after an OSError."""
        end = self.index.end
        offset = end + len(self._owed)
        record = encoded([Metadata(metadata=text, name=name)])
        place = MetadataIndex(offset=offset, length=len(record), name=name)
        self._append(self._owed + record + self.index.tail(offset + len(record), place))
        # Should it have to be repeated, it goes to the same place, behind the messages.
        self.index.end = end

    @property
    def closed(self) -> bool:
        """Whether nothing can be written any more."""
        return self._file.closed

    def close(self) -> None:
        """Close the file as it is."""
        self._file.close()

    def leave_to_parent(self) -> None:
        """Let go: the file is its parent's, which others wait for."""
        self._file.close()

    def _append(self, data: bytes) -> None:
        """Write ``data`` as the end of the file, or raise OSError and leave the file as it was.

        What a kill has left there is cut off last: where the disk is full or a file may not be as
        long, its bytes could not be written again.
        """
        descriptor, end = self._file.fileno(), self.index.end
        size = os.fstat(descriptor).st_size
        replaced = os.pread(descriptor, len(data), end)
        written, rest = 0, memoryview(data)
        try:
            while written < len(data):
                written += os.pwrite(descriptor, rest[written:], end + written)
            os.ftruncate(descriptor, end + len(data))
        except OSError:
            os.pwrite(descriptor, replaced[:written], end)
            if os.fstat(descriptor).st_size != size:
                os.ftruncate(descriptor, size)
            raise
        self.index.end += len(data)


def _message_indexes(start: int, entries: Entries) -> tuple[bytes, dict[int, int]]:
    """Return the message indexes that stand from offset ``start``, and their offsets."""
    content, offsets = b"", {}
    for channel, listed in entries.items():
        offsets[channel] = start + len(content)
        content += _message_index(channel, listed)
    return content, offsets


def _message_index(channel: int, listed: list[tuple[int, int]]) -> bytes:
    """Return mcap's MessageIndex record in one go: field by field it takes as long as recording."""
    numbers = [number for entry in listed for number in entry]
    size = 8 * len(numbers)
    return struct.pack(
        f"<BQHI{len(numbers)}Q", Opcode.MESSAGE_INDEX, 6 + size, channel, size, *numbers
    )
