# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Read a rosbag2 bag into arrays."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from rodless_base.columns import Columns
from rodless_base.constants import SECONDS_PER_NANOSECOND
from rodless_base.file_path import file_path
from rodless_base.one_line import listed
from rodless_lab.bags.description_check import (
    READ_ANYHOW,
    RECOVER,
    can_be_recovered,
    left_out,
    other_counts,
)
from rodless_lab.bags.message_definition import message_class
from rodless_lab.bags.metadata import (
    METADATA_FILE,
    SQLITE,
    BagError,
    BagTopic,
    is_plain,
    is_within,
    memory_for,
    storage_files,
)
from rodless_lab.bags.storage import Recorded, Storage, Times, read_storage

Array = npt.NDArray[Any]

# From so many numbers on, a table of arrays that are padded to one length may be at most so many
# times as large as they are.
LARGE_TABLE = 10_000_000
LARGEST_PADDING = 10

MOST_COLUMNS = 10_000  # of a table that is saved


@dataclass(frozen=True)
class TopicMessages(Columns):
    """The messages of one topic in the order they were recorded; times in ns.

    Message objects and arrays are made when first asked for. As columns, the messages are log time,
    stamp where the type has one, and each field of numbers; arrays of k numbers become the columns
    ``name[0]`` to ``name[k-1]``.

    Examples
    --------
    >>> voltage = read_bag("run1")["/valve/voltage"]
    >>> len(voltage), voltage.topic.type_name, list(voltage.columns())
    (101, 'std_msgs/msg/Float64', ['time', 'data'])
    """

    topic: BagTopic
    log_time: Times
    publish_time: Times
    payloads: Sequence[bytes]

    def __len__(self) -> int:
        return len(self.payloads)

    @property
    def time(self) -> npt.NDArray[np.float64]:
        """Log times in seconds."""
        return self.log_time.astype(np.float64) * 1e-9

    @cached_property
    def messages(self) -> list[Any]:
        """Messages as objects of their ROS type; raises :class:`BagError`."""
        name = self.topic.type_name
        if not name:
            raise BagError(
                f"{self.topic.name}: the bag does not say of which type its messages are, so they "
                "cannot be read"
            )
        self.topic.check_readable()
        try:
            kind = message_class(name)
        except (ImportError, AttributeError) as error:
            raise BagError(f"{self.topic.name}: its type {name} is not installed") from error
        with memory_for(self.topic.name):
            return [self._message(place, kind) for place in range(len(self))]

    def _message(self, place: int, kind: type[Any]) -> Any:
        # Here, so that the commands that read bags show their help without ROS.
        from rclpy.serialization import deserialize_message  # noqa: PLC0415

        try:
            return deserialize_message(self.payloads[place], kind)
        except (MemoryError, Warning):  # not its fault; somebody may have made errors of warnings
            raise
        except Exception as error:  # rclpy raises whatever the middleware reports
            raise BagError(
                f"{self.topic.name}: message {place} is no {self.topic.type_name}"
            ) from error

    def __repr__(self) -> str:
        """Show the topic and how many messages it has, not what is in them."""
        return f"<{self.topic.name}: {len(self)} of {self.topic.type_name or 'no type'}>"

    @cached_property
    def stamp_time(self) -> npt.NDArray[np.int64]:
        """Stamps of the headers in ns; raises :class:`BagError` for a type without."""
        # Here, as it loads ROS, which messages have by now.
        from rodless_base.ros.topics import stamp_nanoseconds  # noqa: PLC0415

        if self.messages and not hasattr(self.messages[0], "header"):
            raise BagError(f"{self.topic.name}: {self.topic.type_name} has no header")
        times = [stamp_nanoseconds(message.header.stamp) for message in self.messages]
        return np.array(times, dtype=np.int64)

    @cached_property
    def repeated(self) -> npt.NDArray[np.bool_]:
        """Which messages are the one before to the byte, as a lock-step plant repeats them.

        None where there are no stamps: a reading may well be that of before. Raises as
        :attr:`stamp_time`.
        """
        if not self.stamp_time.any():
            return np.zeros(len(self), dtype=np.bool_)
        same = [one == before for before, one in pairwise(self.payloads)]
        return np.array([False, *same], dtype=np.bool_)

    @property
    def stamp(self) -> npt.NDArray[np.float64]:
        """Stamps of the headers in seconds, which of the wall clock resolve 0.2 µs; raises so."""
        return self.stamp_time.astype(np.float64) * SECONDS_PER_NANOSECOND

    @cached_property
    def fields(self) -> Mapping[str, Array]:
        """Numeric fields by (dotted) name: shape (n,), or (n, k) for arrays of k numbers.

        Where arrays differ in length, the shorter ones end in NaN. Texts, lists of messages and
        the header are left out. Raises :class:`BagError`; to take a field does so where a long
        array among short ones makes a table that is out of proportion.
        """
        names = _numeric_fields(self.messages[0]) if self.messages else ()
        return _Fields(self.topic.name, self.messages, tuple(names))

    def columns(self) -> dict[str, Array]:
        """Return log time, stamps and fields, shape (n,) each.

        Raises :class:`BagError`, also for arrays that make too many columns.
        """
        columns = {"time": self.time}
        if self.messages and hasattr(self.messages[0], "header"):
            columns["stamp"] = self.stamp
        for name, values in self.fields.items():
            if values.ndim == 1:
                columns[name] = values
            elif values.shape[1] > MOST_COLUMNS:
                raise BagError(
                    f"{self.topic.name}: {name} is an array of {values.shape[1]} numbers, too many "
                    f"for columns ({MOST_COLUMNS}); take it as .fields[{name!r}]"
                )
            else:
                columns |= {f"{name}[{k}]": column for k, column in enumerate(values.T)}
        return columns

    def units(self) -> dict[str, str]:
        """Return the units of the columns: seconds; a field's own is not recorded."""
        return {name: "s" if name in ("time", "stamp") else "" for name in self.columns()}

    def at(self, places: Sequence[int]) -> "TopicMessages":
        """Return the messages at ``places``."""
        if len(places) == len(self):
            return self
        found = TopicMessages(
            self.topic,
            self.log_time[list(places)],
            self.publish_time[list(places)],
            [self.payloads[place] for place in places],
        )
        # They need not be read again.
        vars(found)["messages"] = [self.messages[place] for place in places]
        return found

    def restarts(self) -> list[int]:
        """Return the places where log time goes backwards, as a reset of the plant makes it."""
        return [int(place) + 1 for place in np.flatnonzero(np.diff(self.log_time) < 0)]


class _Fields(Mapping[str, Array]):
    """The fields of messages by name, each made when it is first asked for."""

    def __init__(self, topic: str, messages: Sequence[Any], names: Sequence[str]) -> None:
        self._topic = topic
        self._messages = messages
        self._columns: dict[str, Array | None] = dict.fromkeys(names)

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __getitem__(self, name: str) -> Array:
        column = self._columns[name]
        if column is None:
            with memory_for(f"{self._topic}: {name}"):
                column = self._columns[name] = self._column(name)
        return column

    def _column(self, name: str) -> Array:
        values = [_value(message, name) for message in self._messages]
        if not _is_numbers(values[0]):
            return np.array(values)
        lengths = [len(value) for value in values]
        longest = max(lengths)
        if min(lengths) == longest:
            return np.array(values)
        size = len(values) * longest
        if size > LARGE_TABLE and size > LARGEST_PADDING * sum(lengths):
            raise BagError(
                f"{self._topic}: {name} is an array of up to {longest} numbers in {len(values)} "
                f"messages, of {sum(lengths) / len(values):.3g} on average: too large a table; "
                "take them from .messages"
            )
        column = np.full((len(values), longest), np.nan)
        for row, value in zip(column, values, strict=True):
            row[: len(value)] = value
        return column


class Bag:
    """Messages by topic; ``complete`` unless the bag was never closed, for all we know, or damaged.

    ``notes`` say, one line each, what else to know of it, such as a file that is left out.

    Examples
    --------
    >>> bag = read_bag("run1")
    >>> "/joint_states" in bag
    True
    >>> float(bag["/joint_states"].fields["position"][0, 0])
    0.0
    """

    def __init__(
        self,
        path: Path,
        messages: Mapping[str, TopicMessages],
        complete: bool,
        notes: Sequence[str] = (),
    ) -> None:
        self.path = path
        self.complete = complete
        self.notes = tuple(notes)
        self._messages = messages

    def __repr__(self) -> str:
        """Show where it is and how many messages each topic has."""
        counts = ", ".join(f"{name}: {len(found)}" for name, found in self._messages.items())
        state = "" if self.complete else ", incomplete"
        return f"<Bag {self.path}{state}: {counts or 'no topics'}>"

    @property
    def topics(self) -> list[str]:
        """Names of the recorded topics."""
        return list(self._messages)

    def __getitem__(self, topic: str) -> TopicMessages:
        if topic not in self._messages:
            there = listed(self.topics) or "no topics"
            raise BagError(f"{self.path}: {topic} was not recorded; the bag holds {there}")
        return self._messages[topic]

    def __contains__(self, topic: str) -> bool:
        return topic in self._messages

    def __iter__(self) -> Iterator[str]:
        return iter(self._messages)


def read_bag(path: str | Path, recover: bool = False) -> Bag:
    """Read the bag in folder ``path`` (or a single storage file).

    Parameters
    ----------
    path
        The bag's folder, or one of its storage files: MCAP or SQLite, each as rosbag2 compresses
        it.
    recover
        Read a bag whose recording was killed as far as it goes, and a damaged one up to the damage.

    Returns
    -------
    Bag
        Its messages by topic: ``bag["/joint_states"].fields["position"]``.

    Raises
    ------
    BagError
        For a bag that is missing, in a storage that is not read, or, without ``recover``, cut off
        or damaged.
    TypeError
        For what is no path.

    Examples
    --------
    >>> bag = read_bag("run1")
    >>> bag.topics[:2]
    ['/joint_states', '/valve/voltage']
    >>> bag["/joint_states"].save("joint_states.csv")
    """
    contents = Storage()
    bag = file_path(path, BagError)
    files = storage_files(bag)
    for file in files:
        read_storage(file, contents)
    faults = _faults(bag, files, contents)
    if faults and not recover:
        raise BagError(f"{path}: {faults}")
    by_topic = {name: _of_topic(one) for name, one in contents.recorded.items()}
    untold = _untold_end(bag, files)
    notes = [f"{path}: {note}" for note in (left_out(bag, files), untold) if note]
    return Bag(bag, by_topic, not faults and not untold, notes)


def _untold_end(bag: Path, files: Sequence[Path]) -> str:
    """Say so where nothing tells whether a bag was closed: a file of SQLite says nothing of it."""
    folder = bag if bag.is_dir() else bag.parent
    if not any(SQLITE in file.suffixes for file in files) or (folder / METADATA_FILE).is_file():
        return ""
    return (
        f"without {METADATA_FILE}, which a recorder writes last: messages of its end may be missing"
    )


def _faults(bag: Path, files: Sequence[Path], contents: Storage) -> str:
    """Say why a bag is not read as a whole one, if so, and the way to what there is of it."""
    if contents.under_way:
        return contents.under_way
    counts, way = contents.counts, _way(bag, files, contents)
    if not contents.fault:
        return other_counts(bag, files, counts, way)
    return f"{contents.fault}{can_be_recovered(sum(counts.values()), way)}"


def _way(bag: Path, files: Sequence[Path], contents: Storage) -> str:
    """Return the way to a bag that is not whole: recovery ends what is cut off, and no more."""
    packed = any(one.compressed for one in contents.recorded.values())
    ours = bag.is_dir() and all(is_plain(file) and is_within(bag, file) for file in files)
    return RECOVER if ours and not (packed or contents.damaged) else READ_ANYHOW


def _of_topic(recorded: Recorded) -> TopicMessages:
    if recorded.compressed:
        recorded.sort()
    return TopicMessages(
        recorded.topic,
        np.array(recorded.log_time, dtype=np.int64),
        np.array(recorded.publish_time, dtype=np.int64),
        recorded.payloads,
    )


def _numeric_fields(message: Any, prefix: str = "") -> Iterator[str]:
    for name in message.get_fields_and_field_types():
        value = getattr(message, name)
        if hasattr(value, "get_fields_and_field_types"):
            if name != "header":
                yield from _numeric_fields(value, f"{prefix}{name}.")
        elif isinstance(value, bool | int | float) or _is_numbers(value):
            yield f"{prefix}{name}"


def _is_numbers(value: object) -> bool:
    # Sequences of numbers are array.array (variable length) or numpy arrays (fixed length).
    return hasattr(value, "tolist")


def _value(message: Any, name: str) -> Any:
    for part in name.split("."):
        message = getattr(message, part)
    return message
