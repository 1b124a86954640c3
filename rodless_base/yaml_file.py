# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""YAML as ROS reads it, from files of bounded size and depth."""

import errno
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from rodless_base.file_path import file_path
from rodless_base.one_line import described, shown
from rodless_base.regular_file import NotAFileError, open_file

# A file of all parameters of both nodes has 10 kB and is five levels deep.
LARGEST_FILE = 1_000_000  # bytes
DEEPEST_NESTING = 20  # levels
TOO_DEEP = f"nested more than {DEEPEST_NESTING} levels deep"

MERGE = "tag:yaml.org,2002:merge"


class _LineError(ValueError):
    """What is wrong with a line of a file."""

    def __init__(self, node: Any, what: str) -> None:
        super().__init__(f"line {node.start_mark.line + 1}: {what}")


class BoundedLoader(yaml.SafeLoader):
    """Reads plain values in bounded time, and says where a value stands that cannot be read."""

    _depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Refuse what is nested beyond reason, be it by aliases."""
        event: Any = self.peek_event()  # type: ignore[no-untyped-call]
        alias = self.check_event(yaml.AliasEvent)
        if self._depth == DEEPEST_NESTING:
            raise _LineError(event, TOO_DEEP)
        self._depth += 1
        node: Any = super().compose_node(parent, index)
        self._depth -= 1
        if not alias:
            node.levels = 1 + max((one.levels for one in _within(node)), default=0)
        elif self._depth + getattr(node, "levels", DEEPEST_NESTING) > DEEPEST_NESTING:
            raise _LineError(event, TOO_DEEP)  # what is within itself has no number of levels yet
        return node

    def construct_mapping(self, node: Any, deep: bool = False) -> Any:
        """Refuse merging, which ROS does not know, and which a few lines can make endless."""
        for key, _ in node.value:
            if key.tag == MERGE:
                raise _LineError(key, "merging (<<) is not for ROS; write the values out")
        return super().construct_mapping(node, deep)

    def construct_object(self, node: Any, deep: bool = False) -> Any:
        """Say where the value stands that is not of the type that its tag or its form says."""
        try:
            return super().construct_object(node, deep)
        except (yaml.YAMLError, _LineError):
            raise
        except Exception as error:
            kind = node.tag.rpartition(":")[2]
            raise _LineError(node, f"{shown(node.value)} cannot be read as {kind}") from error


def _within(node: Any) -> Iterator[Any]:
    """Yield the nodes that a mapping or a sequence holds."""
    if isinstance(node, yaml.CollectionNode):
        for one in node.value:
            yield from one if isinstance(one, tuple) else (one,)


class RosLoader(BoundedLoader):
    """Reads what ROS reads: ``1e-5`` is a number, and nothing stands for something elsewhere."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Refuse aliases, as ROS does."""
        event: Any = self.peek_event()  # type: ignore[no-untyped-call]
        if self.check_event(yaml.AliasEvent):
            raise _LineError(event, "aliases (*name) are not for ROS; write the values out")
        return super().compose_node(parent, index)

    def construct_mapping(self, node: Any, deep: bool = False) -> Any:
        """Refuse a name that stands twice, of which all values but the last would be lost."""
        names: set[str] = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                if key.value in names:
                    raise _LineError(key, f"{shown(key.value)} stands twice; keep one")
                names.add(key.value)
        return super().construct_mapping(node, deep)


RosLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    # No two parts in a row that both take digits: trying every way to share them out takes hours.
    re.compile(r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)[eE][-+]?\d+$"),
    list("-+.0123456789"),
)


def number_or_text(loader: BoundedLoader, node: Any) -> object:
    """Return a number; ``190:20:30`` and ``6_000``, numbers in YAML 1.1, are texts elsewhere."""
    if ":" in node.value or "_" in node.value:
        return str(node.value)
    integer = node.tag.endswith(":int")
    return loader.construct_yaml_int(node) if integer else loader.construct_yaml_float(node)


BoundedLoader.add_constructor("tag:yaml.org,2002:int", number_or_text)
BoundedLoader.add_constructor("tag:yaml.org,2002:float", number_or_text)


def read_yaml(path: str | Path, what: str) -> object:
    """Return what the file at ``path`` holds, which should be ``what``, such as "a scenario".

    Raises ValueError, in one line without the path, for a file that is not YAML in UTF-8 or too
    large; OSError for one that cannot be read; TypeError for what is no path.
    """
    try:
        found: object = yaml.load(_text(path, what), RosLoader)
    except yaml.YAMLError as error:
        raise ValueError(f"not YAML: {described(error)}") from error
    except UnicodeDecodeError as error:
        raise ValueError(f"not a text in UTF-8: byte {error.start}") from error
    return found


def yaml_value(text: str) -> object:
    """Return what ``text`` stands for; raises ValueError or yaml.YAMLError."""
    found: object = yaml.load(text, RosLoader)
    return found


def _text(path: str | Path, what: str) -> str:
    """Return what is in a file; raises ValueError for what is none, or too large for ``what``."""
    try:
        descriptor = open_file(file_path(path))
    except NotAFileError as error:
        if error.errno == errno.EISDIR:
            raise
        raise ValueError(f"{error.strerror}; save what it gives to a file") from error
    with os.fdopen(descriptor, "rb") as file:
        content = file.read(LARGEST_FILE + 1)
    if len(content) > LARGEST_FILE:
        raise ValueError(f"not {what}: larger than {LARGEST_FILE // 1000} kB")
    return content.decode("utf-8")


def yaml_text(value: bool | int | float | str | tuple[float, ...]) -> str:
    """Return a parameter's value as it stands in a file, with all digits, so that ROS reads it."""
    plain = list(value) if isinstance(value, tuple) else value
    text: str = yaml.safe_dump(plain, default_flow_style=True, width=10_000)
    return text.removesuffix("...\n").rstrip("\n")
