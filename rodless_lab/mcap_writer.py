"""Write an MCAP file so that it can be ended wherever the writing stops."""

import os
import struct
import zlib
from collections import Counter
from pathlib import Path
from types import TracebackType

from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    Header,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
)

from rodless_lab.mcap_index import MAGIC, McapIndex, Stretch, encoded

# Bytes of messages a chunk holds before it is written: what a kill loses at most, beside time.
CHUNK_SIZE = 64 * 1024

_MESSAGE = struct.Struct("<BQHIQQ")
_MESSAGE_FIXED = _MESSAGE.size - 9


class McapWriter:
    """An MCAP file of the profile ``ros2`` under construction.

    mcap's own writer cannot go on after a failed write. This one takes a write that failed back,
    so that on a full disk everything before it can still be ended with a summary; :meth:`resume`
    does the same for a file whose writer was killed.
    """

    def __init__(self, path: Path) -> None:
        """Begin a new file; raises OSError."""
        self._begin(path, "xb", McapIndex())
        self._append(MAGIC + encoded([Header(profile="ros2", library="rodless_lab")]))

    @classmethod
    def resume(cls, path: Path, index: McapIndex) -> "McapWriter":
        """Go on behind what ``index`` lists, throwing away what stands after it."""
        writer = cls.__new__(cls)
        writer._begin(path, "r+b", index)
        return writer

    def _begin(self, path: Path, mode: str, index: McapIndex) -> None:
        self.name = path.name
        self.index = index
        self._file = path.open(mode, buffering=0)
        self._chunk = bytearray()
        self._chunk_entries: dict[int, list[tuple[int, int]]] = {}

    def add_channel(
        self, topic: str, schema_name: str, encoding: str, text: str, metadata: dict[str, str]
    ) -> int:
        """Add a topic of CDR messages; channels of one ``schema_name`` share its schema."""
        schema = self._schema(schema_name, encoding, text)
        channel = Channel(
            id=len(self.index.channels) + 1,
            topic=topic,
            message_encoding="cdr",
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
        """Add a message, times in ns; raises OSError when a full chunk cannot be written."""
        entry = (log_time, len(self._chunk))
        self._chunk_entries.setdefault(channel, []).append(entry)
        length = _MESSAGE_FIXED + len(data)
        self._chunk += _MESSAGE.pack(
            Opcode.MESSAGE, length, channel, sequence, log_time, publish_time
        )
        self._chunk += data
        if len(self._chunk) >= CHUNK_SIZE:
            self.flush()

    def flush(self) -> None:
        """Hand everything added so far to the operating system.

        Raises OSError when that fails; the messages since the last flush are lost then, and
        the file ends as it did before.
        """
        if not self._chunk_entries:
            return
        entries, self._chunk_entries = self._chunk_entries, {}
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

    def _append_chunk(self, chunk: Chunk, entries: dict[int, list[tuple[int, int]]]) -> None:
        start = self.index.end
        content = encoded([chunk])
        length = len(content)
        offsets = {}
        for channel, listed in entries.items():
            offsets[channel] = start + len(content)
            content += encoded([MessageIndex(channel_id=channel, records=listed)])
        self._append(content)
        index = ChunkIndex(
            chunk_length=length,
            chunk_start_offset=start,
            compression="",
            compressed_size=len(chunk.data),
            message_end_time=chunk.message_end_time,
            message_index_length=len(content) - length,
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
        record = encoded([Metadata(metadata=text, name=name)])
        place = MetadataIndex(offset=end, length=len(record), name=name)
        self._append(record + self.index.tail(end + len(record), place))
        # Should it have to be repeated, it goes to the same place, behind the messages.
        self.index.end = end
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file as it is."""
        self._file.close()

    def __enter__(self) -> "McapWriter":
        return self

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        self.close()

    def _append(self, data: bytes) -> None:
        """Write all of ``data`` at the end, or raise OSError and leave the file as it was."""
        self._file.seek(self.index.end)
        self._file.truncate()
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[self._file.write(rest) or 0 :]
        except OSError:
            self._file.truncate(self.index.end)
            raise
        self.index.end += len(data)
