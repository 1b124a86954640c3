# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a rosbag2 bag says about itself: its topics, and ``metadata.yaml``."""

import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path, PurePath
from typing import Any, NamedTuple

import yaml

from rodless_base.atomic_write import atomic_write
from rodless_base.one_line import OneLineError, in_one_line, shown
from rodless_base.yaml_file import BoundedLoader, number_or_text

METADATA_FILE = "metadata.yaml"

# What rosbag2 puts behind the name of a storage file that it has compressed as a whole.
COMPRESSED = ".zstd"

# How ROS 2 encodes messages.
CDR = "cdr"

SQLITE = ".db3"
STORAGES = (".mcap", SQLITE)

# What holds everything that metadata.yaml says.
_INFORMATION = "rosbag2_bagfile_information"

# How many bags within a folder are named to somebody who took it for one.
_NAMED = 3

# Bytes, which take some 15 s to read. A description of a thousand files, with as many topics, is
# shorter.
_LONGEST_METADATA = 3_000_000

# Bits: rosbag2 has no longer ones of its own, and Python cannot write long ones.
_LONGEST_NUMBER = 64

# rosbag2's own format version in the distribution jazzy; newer ones read it too.
_VERSION = 9

# rosbag2 gives a bag without messages the latest time there is as its start.
_NO_TIME = 2**63 - 1


class BagError(OneLineError):
    """A bag that cannot be read or written; the text names the bag and what is wrong with it."""


@contextmanager
def memory_for(what: object) -> Iterator[None]:
    """Raise :class:`BagError` where memory ends: a file or topic is not damaged by that."""
    try:
        yield
    except MemoryError as error:
        raise BagError(
            f"{what}: needs more memory than there is; read it where there is more"
        ) from error


class DescriptionLoader(BoundedLoader):
    """Reads what rosbag2 writes, texts without quotes that look like something else included."""

    def construct_object(self, node: Any, deep: bool = False) -> Any:
        """Return the text of what is nothing else, such as the 30th of February."""
        try:
            return super().construct_object(node, deep)
        except ValueError:
            if isinstance(node, yaml.ScalarNode):
                return str(node.value)
            raise


def _whole_number(loader: BoundedLoader, node: Any) -> object:
    number = number_or_text(loader, node)
    if isinstance(number, int) and number.bit_length() > _LONGEST_NUMBER:
        return str(node.value)  # such as a serial number
    return number


DescriptionLoader.add_constructor("tag:yaml.org,2002:int", _whole_number)


@dataclass(frozen=True)
class BagTopic:
    """A recorded topic; ``qos`` holds one profile, named as rosbag2 names it, per publisher."""

    name: str
    type_name: str
    type_hash: str = ""
    qos: tuple[Mapping[str, object], ...] = ()
    encoding: str = CDR
    # Of further messages of the name, which cannot be told from the others any more.
    other_types: tuple[str, ...] = ()

    @property
    def form(self) -> str:
        """What its messages are: their type, and how they are encoded where that is not in CDR."""
        return (self.type_name or "no type") + (
            "" if self.encoding == CDR else f" in {shown(self.encoding)}"
        )

    def check_readable(self) -> None:
        """Raise :class:`BagError` where its messages are not all of one type and in CDR."""
        if self.other_types:
            raise BagError(
                f"{self.name}: messages of {' and '.join((self.form, *self.other_types))} under "
                "one name, which cannot be told apart; record again with a name for each"
            )
        if self.encoding != CDR:
            raise BagError(
                f"{self.name}: its messages are in {shown(self.encoding)}, must be in {CDR}, as "
                "ROS 2 writes them"
            )

    @property
    def qos_text(self) -> str:
        """The profiles as the text that a channel of the storage file carries."""
        return yaml.safe_dump([dict(profile) for profile in self.qos], sort_keys=False).strip()


@dataclass(frozen=True)
class FileContents:
    """What one storage file of a bag holds; times in ns, ``None`` without messages."""

    name: str
    first_time: int | None
    last_time: int | None
    topics: Sequence[BagTopic]
    counts: Mapping[str, int]


def information(files: Sequence[FileContents]) -> dict[str, Any]:
    """Return the bag's description, keys and order as rosbag2 writes them."""
    entries = [_file_entry(file) for file in files]
    topics = {topic.name: topic for file in files for topic in file.topics}
    start = min(entry["starting_time"]["nanoseconds_since_epoch"] for entry in entries)
    ends = [file.last_time for file in files if file.last_time is not None]
    return {
        "version": _VERSION,
        "storage_identifier": "mcap",
        "duration": {"nanoseconds": max(ends) - start if ends else 0},
        "starting_time": {"nanoseconds_since_epoch": start},
        "message_count": sum(entry["message_count"] for entry in entries),
        "topics_with_message_count": [
            _topic_entry(topic, sum(file.counts.get(topic.name, 0) for file in files))
            for topic in topics.values()
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file.name for file in files],
        "files": entries,
        "custom_data": None,
        "ros_distro": os.environ.get("ROS_DISTRO", ""),
    }


def _file_entry(file: FileContents) -> dict[str, Any]:
    start, end = file.first_time, file.last_time
    empty = start is None or end is None
    return {
        "path": file.name,
        "starting_time": {"nanoseconds_since_epoch": _NO_TIME if empty else start},
        "duration": {"nanoseconds": 0 if start is None or end is None else end - start},
        "message_count": sum(file.counts.values()),
    }


def _topic_entry(topic: BagTopic, count: int) -> dict[str, Any]:
    return {
        "topic_metadata": {
            "name": topic.name,
            "type": topic.type_name,
            "serialization_format": CDR,
            "offered_qos_profiles": [dict(profile) for profile in topic.qos],
            "type_description_hash": topic.type_hash,
        },
        "message_count": count,
    }


def information_text(files: Sequence[FileContents]) -> str:
    """Return the description as the text that the storage file itself carries."""
    return yaml.safe_dump(information(files), sort_keys=False)


def write_metadata(bag: Path, files: Sequence[FileContents]) -> None:
    """Write ``metadata.yaml`` whole or not at all; raises OSError."""
    text = yaml.safe_dump({"rosbag2_bagfile_information": information(files)}, sort_keys=False)
    atomic_write(bag / METADATA_FILE, text)


def storage_files(bag: Path) -> list[Path]:
    """Return the storage files of the bag at ``bag`` (its folder, or one file), in order.

    A folder without ``metadata.yaml`` (the recording was killed) is searched. Raises
    :class:`BagError` where there is no bag, one that cannot be read, or one in a storage that is
    neither MCAP nor SQLite.
    """
    with _reading(bag):
        return _checked(_storage_files(bag), bag)


def _storage_files(bag: Path) -> list[Path]:
    if bag.is_file():
        return [bag]
    if not bag.is_dir():
        raise BagError(f"{bag}: no such bag")
    if (bag / METADATA_FILE).is_file():
        return _listed_files(bag)
    found = [path for path in bag.iterdir() if _storage(path)]
    if not found:
        raise BagError(
            f"{bag}: not a bag: neither {METADATA_FILE} nor a storage file in it{_bags_within(bag)}"
        )
    # One that was being compressed when the recording was killed is there plain as well.
    names = {path.name for path in found if path.suffix != COMPRESSED}
    once = [p for p in found if p.suffix != COMPRESSED or _plain_name(p) not in names]
    return sorted(once, key=_file_number)


def _bags_within(folder: Path) -> str:
    """Name the bags in a folder that is none itself, such as that of `rodless demo`."""
    bags = sorted(filter(_holds_a_bag, folder.iterdir()))
    return f"; try {' or '.join(map(str, bags[:_NAMED]))}" if bags else ""


def _holds_a_bag(folder: Path) -> bool:
    with suppress(OSError):  # a folder that may not be read
        return any(one.name == METADATA_FILE or _storage(one) for one in folder.iterdir())
    return False


def unlisted_files(bag: Path, listed: Iterable[Path]) -> list[Path]:
    """Return the storage files in the bag's folder beside its own, which are ``listed``.

    A file of the same name, compressed or not, is no other. Raises as :func:`storage_files`.
    """
    own = {_plain_name(path) for path in listed}
    with _reading(bag):
        found = bag.iterdir() if bag.is_dir() else ()
        others = [path for path in found if _plain_name(path) not in own]
        return sorted(
            (path for path in others if _storage(path) and path.is_file()), key=_file_number
        )


def _listed_files(bag: Path) -> list[Path]:
    listed = _listed(bag, "relative_file_paths")
    if not isinstance(listed, list):
        what = f"relative_file_paths is {shown(listed)}, not a list"
        raise BagError(f"{bag / METADATA_FILE}: {what}")
    return [_inside(bag, name) for name in listed]


def _inside(bag: Path, name: object) -> Path:
    """Return the file of that name in the bag; raises :class:`BagError` for one outside it."""
    outside = f"{bag / METADATA_FILE}: names {shown(name)}, which is not in the bag"
    if not isinstance(name, str) or "\0" in name:
        raise BagError(outside)
    relative = PurePath(name)
    if relative.is_absolute() or ".." in relative.parts:
        raise BagError(outside)
    # Before version 4 rosbag2 put the name of the bag's folder first.
    return bag / relative if (bag / relative).is_file() else bag / relative.name


def _storage(file: Path) -> str:
    """Return the suffix that tells a file's storage, or nothing for one that is not read."""
    suffix = Path(_plain_name(file)).suffix
    return suffix if suffix in STORAGES else ""


def is_plain(file: Path) -> bool:
    """Whether a storage file is MCAP and not compressed as a whole, as recordings here are."""
    return file.suffix == ".mcap"


def is_within(bag: Path, file: Path) -> bool:
    """Whether a storage file lies in the bag's folder, wherever links to it lead."""
    return file.resolve().is_relative_to(bag.resolve())


def listed_messages(bag: Path) -> int | None:
    """Return how many messages the description says there are; None for a bag without one.

    Raises :class:`BagError` for a bag that cannot be read, or whose description has no such number.
    """
    with _reading(bag):
        if not (bag / METADATA_FILE).is_file():
            return None
        count = _listed(bag, "message_count")
        if type(count) is not int:
            path = bag / METADATA_FILE
            raise BagError(f"{path}: message_count is {shown(count)}, not a number of messages")
        return count


class ListedCounts(NamedTuple):
    """How many messages a description says there are, of each topic and in all; None: nothing."""

    by_topic: Mapping[str, int] | None
    messages: int | None


def listed_counts(bag: Path) -> ListedCounts:
    """Return what the description of the bag says of its messages; raises as above.

    Counts that are none say nothing: another program may have written it.
    """
    with _reading(bag):
        if not (bag / METADATA_FILE).is_file():
            return ListedCounts(None, None)
        information = _information(bag)
        messages = information.get("message_count")
        return ListedCounts(
            _by_topic(information.get("topics_with_message_count")),
            messages if type(messages) is int else None,
        )


def _by_topic(entries: Any) -> Mapping[str, int] | None:
    counts: Counter[str] = Counter()  # others list a topic once for each kind of publisher
    try:
        for one in entries:
            name = one["topic_metadata"]["name"]
            if not isinstance(name, str):
                return None
            counts[name] += int(one["message_count"])
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
    return counts


@contextmanager
def _reading(bag: Path) -> Iterator[None]:
    try:
        yield
    except BagError:
        raise
    except OSError as error:
        path = error.filename or bag
        raise BagError(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:  # a NUL, or half a character
        raise BagError(f"{shown(str(bag))}: no name of a bag: {error}") from error


def _listed(bag: Path, entry: str) -> Any:
    information = _information(bag)
    if entry not in information:
        raise BagError(_no_description(bag / METADATA_FILE, f"it has no {entry}"))
    return information[entry]


def _information(bag: Path) -> dict[Any, Any]:
    path = bag / METADATA_FILE
    try:
        if path.stat().st_size > _LONGEST_METADATA:
            raise ValueError(f"longer than {_LONGEST_METADATA} bytes")
        content = _loaded(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, TypeError, ValueError) as error:
        raise BagError(_no_description(path, _fault(error))) from error
    information = content.get(_INFORMATION) if isinstance(content, dict) else None
    if not isinstance(information, dict):
        raise BagError(_no_description(path, f"it has no entries below {_INFORMATION}"))
    return information


@lru_cache(maxsize=2)
def _loaded(text: str) -> Any:
    """Return what a description says; who reads a bag asks for several things of it."""
    return yaml.load(text, DescriptionLoader)


def _no_description(path: Path, fault: str) -> str:
    return (
        f"{path}: not the description of a rosbag2 bag ({fault}); without it the bag is read as "
        "far as its files go"
    )


def _fault(error: Exception) -> str:
    """Say why a description cannot be read, where Python's words say little to who has a bag."""
    if isinstance(error, UnicodeDecodeError):
        return f"byte {error.start} is no text in UTF-8"
    return in_one_line(str(error).partition("\n")[0])


def _checked(files: Iterable[Path], bag: Path) -> list[Path]:
    checked = list(files)
    for path in checked:
        if not _storage(path):
            name = in_one_line(path.name)
            raise BagError(f"{bag}: {name} is neither MCAP nor SQLite, the storages read here")
        if not path.is_file():
            raise BagError(f"{bag}: its file {in_one_line(path.name)} is missing")
    _check_each_is_another(checked, bag)
    return checked


def _check_each_is_another(files: Iterable[Path], bag: Path) -> None:
    """Refuse a file that would be read twice, under one name or by a link."""
    known: dict[tuple[int, int], Path] = {}
    for path in files:
        about = path.stat()
        key = about.st_dev, about.st_ino
        if key in known:
            raise BagError(f"{bag}: {_is_there_twice(known[key], path)}")
        known[key] = path


def _is_there_twice(first: Path, second: Path) -> str:
    if first.name == second.name:
        way = f"remove {METADATA_FILE}, and all files in the folder are read, each once"
        return f"{METADATA_FILE} lists {in_one_line(first.name)} twice; {way}"
    link = in_one_line((first if first.is_symlink() else second).name)
    names = " and ".join(in_one_line(path.name) for path in (first, second))
    return f"{names} are the same file; remove {link}, and {METADATA_FILE} where it lists both"


def _plain_name(path: Path) -> str:
    """Return the name of a storage file before it was compressed."""
    return path.name.removesuffix(COMPRESSED)


def _file_number(path: Path) -> tuple[int, str]:
    number = Path(_plain_name(path)).stem.rsplit("_", 1)[-1]
    # Python calls some characters digits that make no number, such as a small 2.
    return (int(number) if number.isdecimal() else 0, path.name)
