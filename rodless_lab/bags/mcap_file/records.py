# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The records of an MCAP file one by one, and whether whole ones stand where none should."""

import mmap
import re
import struct
from collections.abc import Callable, Collection, Container, Iterator
from io import BytesIO
from typing import NamedTuple, TypeVar

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode

Content = mmap.mmap | bytes | memoryview

_HEAD = struct.Struct("<BQ")
MESSAGE = struct.Struct("<HIQQ")
_INDEX = struct.Struct("<HI")
_PAIR = 16  # log time and offset
_TIMES = struct.Struct("<QQ")

# Times, size and checksum come before the name of a chunk's compression, and the length of its
# records behind it.
_BEFORE_NAME = 28
_LENGTH = struct.Struct("<I")
_LONG_LENGTH = struct.Struct("<Q")
_MESSAGE_HEAD = bytes([Opcode.MESSAGE])
_COMPRESSIONS = (b"", b"lz4", b"zstd")

# Chunks and their indices, or messages without one, shorter than a terabyte.
_LIKELY = re.compile(rb"(?=[\x05-\x07].{5}\0\0\0)", re.DOTALL)

# In ns; ROS counts them with a sign.
LARGEST_TIME = 2**63 - 1

T = TypeVar("T")


class McapError(ValueError):
    """The file is not MCAP, or is damaged or too large where the text says."""


class Record(NamedTuple):
    """A record, with where it starts and ends."""

    opcode: int
    start: int
    content: bytes
    end: int


class _Place(NamedTuple):
    """Where a record of which kind stands: its head, its content, and what follows it."""

    opcode: int
    start: int
    begin: int
    end: int


def records(content: mmap.mmap | bytes, start: int) -> Iterator[Record]:
    """Yield the whole records from offset ``start``; stop before one that is cut."""
    for opcode, place, begin, end in _places(content, start):
        yield Record(opcode, place, content[begin:end], end)


def _places(content: Content, start: int) -> Iterator[_Place]:
    """Where the whole records from offset ``start`` stand."""
    size = len(content)
    while start + _HEAD.size <= size:
        opcode, length = _HEAD.unpack_from(content, start)
        begin = start + _HEAD.size
        end = begin + length
        if end > size:
            return
        yield _Place(opcode, start, begin, end)
        start = end


def read_as(read: Callable[[ReadDataStream], T], content: bytes) -> T:
    """Return what ``read`` finds in a record; raises :class:`McapError` where something is left."""
    stream = BytesIO(content)
    found = read(ReadDataStream(stream))
    left = len(content) - stream.tell()
    if left:
        raise McapError(f"a record with {left} bytes too many")
    return found


def is_chunk(content: bytes | memoryview) -> bool:
    """Whether ``content`` is built as that of a chunk, whatever its record calls itself."""
    for name in _COMPRESSIONS:
        start = _BEFORE_NAME + _LENGTH.size + len(name) + _LONG_LENGTH.size
        if len(content) < start:
            continue
        told = _LENGTH.pack(len(name)) + name + _LONG_LENGTH.pack(len(content) - start)
        if content[_BEFORE_NAME:start] == told:
            return True
    return False


def is_message_index(content: bytes | memoryview) -> bool:
    """Whether ``content`` is built as that of a message index: a channel, and pairs of numbers."""
    if len(content) < _INDEX.size:
        return False
    _, length = _INDEX.unpack_from(content)
    return bool(length == len(content) - _INDEX.size and length % _PAIR == 0)


def find_whole(content: mmap.mmap | bytes, start: int, channels: Collection[int]) -> int | None:
    """Return where a whole chunk, its index or a message stands behind ``start``, None for nowhere.

    What was cut off has nothing behind it, but for the messages within a chunk.
    """
    # Places that look like one overlap: a copy of each would take the square of the file's size.
    with memoryview(content) as view:
        return _find_whole(view, start, channels)


def _find_whole(content: memoryview, start: int, channels: Collection[int]) -> int | None:
    in_chunk = content[start : start + 1] == bytes([Opcode.CHUNK])
    times = _chunk_times(content, start) if in_chunk else None
    for likely in _LIKELY.finditer(content, start + 1):
        found = next(_places(content, likely.start()), None)
        if found is None:
            continue
        inside = content[found.begin : found.end]
        if found.opcode == Opcode.CHUNK:
            is_whole = is_chunk(inside)
        elif found.opcode == Opcode.MESSAGE_INDEX:
            is_whole = times is not None and _is_index_within(inside, *times)
        else:
            is_whole = not in_chunk and _are_messages(content, found, channels)
        if is_whole:
            return found.start
    return None


def _chunk_times(content: memoryview, start: int) -> tuple[int, int] | None:
    """Return from when to when (ns) the messages are of a chunk that begins at ``start``."""
    begin = start + _HEAD.size
    if begin + _TIMES.size > len(content):
        return None
    first, last = _TIMES.unpack_from(content, begin)
    return first, last


def _is_index_within(content: memoryview, first: int, last: int) -> bool:
    """Whether ``content`` is that of an index of a chunk of such times (ns), and has an entry."""
    if len(content) < _INDEX.size + _PAIR or not is_message_index(content):
        return False
    time, _ = _TIMES.unpack_from(content, _INDEX.size)
    return bool(first <= time <= last)


def _are_messages(content: memoryview, found: _Place, channels: Collection[int]) -> bool:
    """Whether ``found`` and what follows it are messages, one of them of ``channels`` if any are.

    Where none is known yet, what is damaged stands before them; that of the other may have been
    damaged. Zeros are no message: pictures have many.
    """
    following = next(_places(content, found.end), None)
    # What follows may be cut itself.
    if following is None and content[found.end : found.end + 1] not in (b"", _MESSAGE_HEAD):
        return False
    both = [found] if following is None else [found, following]
    if not all(place.opcode == Opcode.MESSAGE for place in both):
        return False
    inside = [content[place.begin : place.end] for place in both]
    if not all(is_message(one) and log_time(one) for one in inside):
        return False
    return not channels or any(is_message(one, channels) for one in inside)


def is_message(content: bytes | memoryview, channels: Container[int] | None = None) -> bool:
    """Whether ``content`` may be that of a message, of one of ``channels`` where they are given."""
    if len(content) < MESSAGE.size:
        return False
    channel, _, *times = MESSAGE.unpack_from(content)
    return max(times) <= LARGEST_TIME and (channels is None or channel in channels)


def log_time(content: bytes | memoryview) -> int:
    """Return when (ns) a message was recorded whose record has ``content``."""
    return int(MESSAGE.unpack_from(content)[2])
