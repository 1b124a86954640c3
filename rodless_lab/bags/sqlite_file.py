# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Read rosbag2's SQLite storage, whose tables of topics and messages all its versions share."""

import os
import shutil
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from rodless_base.one_line import in_one_line
from rodless_lab.bags.decompress import Decompressor, TooLargeError
from rodless_lab.bags.metadata import BagError, BagTopic

# What a message takes in memory beside its content, in bytes.
MESSAGE_SIZE = 100

# What SQLite keeps beside a file that was not closed: messages of its end, or the way back from
# half a change.
BESIDE = ("-wal", "-journal")


class DamagedError(ValueError):
    """A file whose rest cannot be read."""


def sqlite_messages(
    file: Path, decompressor: Decompressor
) -> Iterator[tuple[BagTopic, int, int, bytes]]:
    """Yield topic, log time, publish time (ns; one and the same here) and data of each message.

    In the order in which they were recorded. Raises :class:`BagError`, and DamagedError once there
    are messages.
    """
    has_some = False
    try:
        with _opened(file, decompressor) as database:
            topics = _topics(database, decompressor)
            # By its number and not by its time, which a reset of the plant sets back.
            rows = database.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY rowid")
            for count, (topic, time, data) in enumerate(rows):
                # SQLite keeps what it finds in a damaged row, of whatever type.
                if type(time) is not int or not isinstance(data, bytes):
                    raise BagError(f"message {count} has no time or content")
                if topic not in topics:
                    raise BagError(f"message {count} is of no topic that the file names")
                decompressor.take(len(data) + MESSAGE_SIZE, f"message {count} has")
                yield topics[topic], time, time, data
                has_some = True
    except TooLargeError as error:
        raise BagError(f"{file}: is too large: {error}") from error
    except (sqlite3.Error, BagError, OverflowError) as error:
        if has_some:
            raise DamagedError(f"is damaged ({in_one_line(str(error))})") from error
        raise BagError(
            f"{file}: not a bag in SQLite, or damaged ({in_one_line(str(error))})"
        ) from error


def left_beside(file: Path) -> list[Path]:
    """Return the files beside ``file`` that SQLite has not yet made a part of it."""
    real = file.resolve()  # SQLite, too, goes by where a link leads
    beside = [real.with_name(real.name + ending) for ending in BESIDE]
    return [one for one in beside if one.is_file() and one.stat().st_size > 0]


@contextmanager
def _opened(file: Path, decompressor: Decompressor) -> Iterator[sqlite3.Connection]:
    """Open a file without a change to its folder; what is left beside it is read with a copy.

    So is one that ends within a page: the rest of that would be read as zeros, of messages, too.
    """
    others = left_beside(file)
    if not others and not _beyond_whole_pages(file):
        with _connected(f"{file.resolve().as_uri()}?mode=ro&immutable=1") as database:
            yield database
        return
    with tempfile.TemporaryDirectory() as folder:
        real = file.resolve()
        for one in others:
            decompressor.allow(one.stat().st_size)
        for one in (real, *others):
            _copy(one, Path(folder, one.name))
        copy = Path(folder, real.name)  # which grows no more, as the file may
        os.truncate(copy, copy.stat().st_size - _beyond_whole_pages(copy))
        with _connected(copy.as_uri()) as database:
            yield database


def _beyond_whole_pages(file: Path) -> int:
    """Return how many bytes ``file`` has of a page whose rest is missing; the header has the size.

    Source: SQLite, Database File Format, 1.3.2.
    """
    with file.open("rb") as stream:
        header = stream.read(18)
    stated = int.from_bytes(header[16:18], "big")
    page = 65536 if stated == 1 else stated
    return file.stat().st_size % page if page else 0


def _copy(file: Path, copy: Path) -> None:
    try:
        shutil.copyfile(file, copy)
    except OSError as error:
        raise BagError(
            f"{file}: no copy of {file.stat().st_size} bytes could be made in {copy.parent.parent} "
            f"to read it from ({error.strerror}); set TMPDIR to where there is room"
        ) from error


@contextmanager
def _connected(address: str) -> Iterator[sqlite3.Connection]:
    with closing(sqlite3.connect(address, uri=True)) as database:
        # Nothing of a stranger's is run: views and columns call functions.
        database.execute("PRAGMA trusted_schema=OFF")
        # Without it none of a file is read whose end is missing. Nothing is written all the same.
        database.execute("PRAGMA writable_schema=ON")
        yield database


def _topics(database: sqlite3.Connection, decompressor: Decompressor) -> dict[int, BagTopic]:
    """Return the topics by their number; raises BagError and sqlite3.Error."""
    # A virtual one is none: its rows are computed.
    tables = database.execute(
        "SELECT name FROM sqlite_master WHERE type = 'table' AND sql NOT LIKE 'CREATE VIRTUAL%'"
    )
    if not {name for (name,) in tables} >= {"topics", "messages"}:
        raise BagError("it lacks rosbag2's tables")
    for name in ("topics", "messages"):
        # What is computed has no bound, in time or in memory.
        if any(hidden for *_, hidden in database.execute(f"PRAGMA table_xinfo({name})")):
            raise BagError(f"its table of {name} computes a column")
    topics = {}
    for row in database.execute("SELECT id, name, type, serialization_format FROM topics"):
        number, *texts = row
        if not all(isinstance(text, str) for text in texts):
            raise BagError("a topic's name is no text")
        # What a column is by default stands in the file once, and in each row.
        decompressor.take(sum(map(len, texts)) + MESSAGE_SIZE, "a topic has names of")
        if number in topics:
            raise BagError("two of its topics have one number")
        name, type_name, encoding = texts
        topics[number] = BagTopic(name, type_name, encoding=encoding)
    return topics
