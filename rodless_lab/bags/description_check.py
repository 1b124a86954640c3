# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What a bag lacks by its own description, and the way to what there is of it."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from rodless_lab.bags.metadata import METADATA_FILE, listed_counts, unlisted_files

# Ways to what a bag holds that is not whole.
RECOVER = "rodless recover"
READ_ANYHOW = "read_bag(..., recover=True)"


def left_out(bag: Path, files: Sequence[Path]) -> str:
    """Say which storage files in the folder are not the bag's by its description, if any."""
    names = ", ".join(file.name for file in unlisted_files(bag, files))
    return names and (
        f"{names} left out: {METADATA_FILE} lists no such file. Where it belongs to the bag, "
        f"remove {METADATA_FILE}, and all files are read"
    )


def other_counts(bag: Path, files: Sequence[Path], found: Mapping[str, int], way: str) -> str:
    """Say where ``files`` have other messages by topic than the description says, and the way out.

    ``way`` is the one to what they hold, were there no description.
    SQLite has no sums that tell damage, and no storage tells that a file is gone. Not looked at is
    what the description says of each file: rosbag2 counts there what it drops for want of memory.
    """
    differ = _other_counts(bag, found)
    missed = left_out(bag, files) if differ else ""
    if missed:
        return f"{differ}; {missed}"
    if way == RECOVER:  # which leaves a bag alone that was closed
        way = f"remove {METADATA_FILE}, then {way}"
    return differ and f"{differ}{can_be_recovered(sum(found.values()), way)}"


def can_be_recovered(count: int, way: str) -> str:
    """Say of how many messages that is true, and how; nothing where there are none."""
    return f"; {count} messages can be recovered ({way})" if count else ""


def _other_counts(bag: Path, found: Mapping[str, int]) -> str:
    by_topic, messages = listed_counts(bag)
    for name, count in (by_topic or {}).items():
        if found.get(name, 0) != count:
            return _counts_differ(f"{name} has", found.get(name, 0), count)
    # Of the topics listed alone: rosbag2 forgets one that was taken off while it recorded.
    held = sum(found.get(name, 0) for name in by_topic or found)
    return "" if messages in (None, held) else _counts_differ("it has", held, messages)


def _counts_differ(what: str, found: int, said: int | None) -> str:
    return (
        f"{what} {found} messages, {METADATA_FILE} says {said}: the bag or its description is "
        "damaged"
    )
