# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Read rosbag2's SQLite storage through the library rosbags, which knows all its versions."""

from collections.abc import Iterator
from pathlib import Path

from rodless_lab.bags.decompress import Decompressor, TooLargeError
from rodless_lab.bags.metadata import CDR, BagError, BagTopic

# What a message takes beside its content, in bytes.
MESSAGE_SIZE = 100

_EXTRA = "reading SQLite needs the package rosbags: pip install 'rodless_sim[bags]'"


def sqlite_messages(
    file: Path, decompressor: Decompressor
) -> Iterator[tuple[BagTopic, int, int, bytes]]:
    """Yield topic, log time, publish time (ns; one and the same here) and data of each message.

    Raises :class:`BagError`, also where rosbags is missing.
    """
    try:
        from rosbags.rosbag2 import Reader  # noqa: PLC0415  # an extra
    except ImportError as error:
        raise BagError(f"{file}: {_EXTRA}") from error
    try:
        with Reader(file) as reader:
            topics = {
                one.id: BagTopic(
                    one.topic, one.msgtype, encoding=getattr(one.ext, "serialization_format", CDR)
                )
                for one in reader.connections
            }
            if not all(isinstance(one.name, str) for one in topics.values()):
                raise BagError("a topic's name is no text")
            for count, (connection, time, data) in enumerate(reader.messages()):
                # SQLite keeps what it finds in a damaged row, of whatever type.
                if type(time) is not int or not isinstance(data, bytes | memoryview):
                    raise BagError(f"message {count} has no time or content")
                # A table can compute its columns, and joined to another be larger than its file.
                decompressor.take(len(data) + MESSAGE_SIZE, f"message {count} has")
                yield topics[connection.id], time, time, bytes(data)
    except MemoryError:  # no damage
        raise
    except TooLargeError as error:
        raise BagError(f"{file}: is too large: {error}") from error
    except Exception as error:  # whatever a decoder trips over
        fault = str(error).partition("\n")[0]
        raise BagError(f"{file}: not a bag in SQLite, or damaged ({fault})") from error
