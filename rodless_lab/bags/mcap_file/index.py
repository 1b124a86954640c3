# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What an MCAP file holds, chunk by chunk, and the summary that stands at its end."""

import struct
import zlib
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    McapRecord,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

MAGIC = b"\x89MCAP0\r\n"

# Length of a footer's content: two offsets and a checksum.
FOOTER_LENGTH = 20


@dataclass
class Stretch:
    """A part of the file that holds messages: a chunk with its message indexes.

    It begins at offset ``start``; ``counts`` are the messages of each channel, times are log
    times in ns. Messages that stand outside any chunk make a stretch with no ``index``.
    """

    start: int
    first_time: int
    last_time: int
    counts: Counter[int]
    index: ChunkIndex | None = None


@dataclass
class McapIndex:
    """Schemas, channels and stretches of a file, as far as it has been written or read.

    ``end`` is the offset behind the last whole record of the data section, ``metadata`` lists
    the metadata records before it.
    """

    end: int = 0
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    stretches: list[Stretch] = field(default_factory=list)
    metadata: list[MetadataIndex] = field(default_factory=list)

    @property
    def counts(self) -> Counter[int]:
        """Messages by channel."""
        counts: Counter[int] = Counter()  # a sum of them would copy all for each stretch
        for stretch in self.stretches:
            counts.update(stretch.counts)
        return counts

    @property
    def first_time(self) -> int | None:
        """Earliest log time (ns)."""
        return min((stretch.first_time for stretch in self.stretches), default=None)

    @property
    def last_time(self) -> int | None:
        """Latest log time (ns)."""
        return max((stretch.last_time for stretch in self.stretches), default=None)

    def drop_last(self, count: int) -> bool:
        """Forget as many of the last stretches; return False where there is none."""
        dropped = self.stretches[-count:]
        if not dropped:
            return False
        del self.stretches[-count:]
        self.end = dropped[0].start
        return True

    def tail(self, offset: int, metadata: MetadataIndex | None = None) -> bytes:
        """Return what ends a file whose data section stops at ``offset``, up to the last byte.

        ``metadata`` is one more metadata record, behind the stretches.
        """
        data_end = encoded([DataEnd(data_section_crc=0)])
        start = offset + len(data_end)
        groups: list[tuple[Opcode, list[McapRecord]]] = [
            (Opcode.SCHEMA, list(self.schemas.values())),
            (Opcode.CHANNEL, list(self.channels.values())),
            (Opcode.STATISTICS, [self._statistics(metadata)]),
            (Opcode.CHUNK_INDEX, [s.index for s in self.stretches if s.index is not None]),
            (Opcode.METADATA_INDEX, list(self._metadata(metadata))),
        ]
        summary, offsets = b"", []
        for opcode, records in groups:
            content = encoded(records)
            if content:
                offsets.append(
                    SummaryOffset(
                        group_opcode=opcode,
                        group_start=start + len(summary),
                        group_length=len(content),
                    )
                )
            summary += content
        offset_start = start + len(summary)
        summary += encoded(offsets)
        # The checksum covers the summary and the footer up to the checksum itself.
        opening = struct.pack("<BQQQ", Opcode.FOOTER, FOOTER_LENGTH, start, offset_start)
        footer = Footer(
            summary_start=start,
            summary_offset_start=offset_start,
            summary_crc=zlib.crc32(opening, zlib.crc32(summary)),
        )
        return data_end + summary + encoded([footer]) + MAGIC

    def _metadata(self, last: MetadataIndex | None) -> list[MetadataIndex]:
        return [*self.metadata, *([last] if last is not None else [])]

    def _statistics(self, last: MetadataIndex | None) -> Statistics:
        counts = self.counts
        return Statistics(
            attachment_count=0,
            channel_count=len(self.channels),
            channel_message_counts=dict(counts),
            chunk_count=sum(stretch.index is not None for stretch in self.stretches),
            message_count=counts.total(),
            message_end_time=self.last_time or 0,
            message_start_time=self.first_time or 0,
            metadata_count=len(self._metadata(last)),
            schema_count=len(self.schemas),
        )


def encoded(records: Iterable[McapRecord]) -> bytes:
    """Return records as they stand in a file."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]
