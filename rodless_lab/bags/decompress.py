# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Undo compression within bounds: a bag may say anything of its size, memory has an end."""

from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import lz4.frame  # type: ignore[import-untyped]
import zstandard

# Bytes of one chunk, or of one message compressed by itself: rosbag2's chunks hold at most 4 MB.
LARGEST = 256 * 1024 * 1024

# How many times their own size the contents of a bag's files may have. Samples of a rig compress
# tenfold.
RATIO = 1000

_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
_PIECE = 1024 * 1024


class TooLargeError(ValueError):
    """Compressed data that hold more than any bag of a rig does."""


def is_zstd(data: bytes) -> bool:
    """Whether ``data`` are a zstd frame; a message in CDR never begins like one."""
    return data.startswith(_ZSTD_MAGIC)


class Decompressor:
    """Decompresses what one bag holds: at most ``RATIO`` times its files, and ``LARGEST``.

    All its files draw on the same bytes, and so does what is packed within something packed.
    """

    def __init__(self) -> None:
        self._left = LARGEST

    def allow(self, file_size: int) -> None:
        """Allow for a file of the bag, of ``file_size`` bytes as it lies on the disk, once."""
        self._left += RATIO * file_size

    def take(self, size: int, what: str) -> None:
        """Count ``size`` bytes of ``what``; raises :class:`TooLargeError`, which names that."""
        most = min(LARGEST, self._left)
        if size > most:
            raise TooLargeError(f"{what} {size} bytes, more than {most}")
        self._left -= size

    def chunk(self, compression: str, data: bytes, size: int) -> bytes:
        """Return a chunk that declares to hold ``size`` bytes; raises ValueError if it does not."""
        content = self._decompressed(compression, data, size) if compression else data
        if len(content) != size:
            raise ValueError(f"a chunk declares {size} bytes and holds {len(content)}")
        return content

    def message(self, data: bytes) -> bytes:
        """Return a message that has been compressed by itself; raises ValueError."""
        content = _unzstd(data, min(LARGEST, self._left))
        self._left -= len(content)
        return content

    def _decompressed(self, compression: str, data: bytes, size: int) -> bytes:
        self.take(size, "a compressed chunk declares")
        if compression == "zstd":
            return _unzstd(data, size)
        if compression == "lz4":
            # One byte more than declared, to notice it.
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1))
        raise ValueError(f"compression {compression!r} is unknown")

    def file(self, source: Path, target: Path) -> None:
        """Write the contents of a zstd file to ``target``; raises OSError and ValueError."""
        with source.open("rb") as compressed, target.open("wb") as written:
            self._left -= _copy(compressed, written, self._left)


def _unzstd(data: bytes, most: int) -> bytes:
    if not is_zstd(data):
        raise ValueError("not a zstd frame")
    try:
        size = zstandard.frame_content_size(data)
        if size > most:
            raise TooLargeError(f"compressed data declare {size} bytes, more than {most}")
        if size >= 0:
            return bytes(zstandard.ZstdDecompressor().decompress(data))
    except zstandard.ZstdError as error:
        raise ValueError(str(error)) from error
    content = BytesIO()
    _copy(BytesIO(data), content, most)
    return content.getvalue()


def _copy(source: BinaryIO, target: BinaryIO, most: int) -> int:
    """Decompress piece by piece; return the number of bytes."""
    count = 0
    try:
        with zstandard.ZstdDecompressor().stream_reader(
            source, read_across_frames=True, closefd=False
        ) as stream:
            while piece := stream.read(_PIECE):
                count += len(piece)
                if count > most:
                    raise TooLargeError(f"compressed data hold more than {most} bytes")
                target.write(piece)
    except zstandard.ZstdError as error:
        raise ValueError(str(error)) from error
    return count
