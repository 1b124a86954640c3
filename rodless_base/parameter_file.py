# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""ROS parameter files (YAML): find the presets, read one node's section."""

import errno
import os
import re
import stat
from collections.abc import Callable, Iterator
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import yaml

from rodless_base.one_line import described, shown

# A file of all parameters of both nodes has 10 kB and is five levels deep.
LARGEST_FILE = 1_000_000  # bytes
DEEPEST_NESTING = 20  # levels


class _LineError(ValueError):
    """What is wrong with a line of a file."""

    def __init__(self, node: Any, what: str) -> None:
        super().__init__(f"line {node.start_mark.line + 1}: {what}")


class _Loader(yaml.SafeLoader):
    """Reads what ROS reads: ``1e-5`` is a number, and nothing stands for something elsewhere."""

    _depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Refuse aliases, as ROS does, and what is nested beyond reason."""
        event: Any = self.peek_event()  # type: ignore[no-untyped-call]
        if self.check_event(yaml.AliasEvent):
            raise _LineError(event, "aliases (*name) are not for ROS; write the values out")
        if self._depth == DEEPEST_NESTING:
            raise _LineError(event, f"nested more than {DEEPEST_NESTING} levels deep")
        self._depth += 1
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def construct_mapping(self, node: Any, deep: bool = False) -> Any:
        """Refuse a name that stands twice, of which all values but the last would be lost."""
        names: set[str] = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                if key.value in names:
                    raise _LineError(key, f"{shown(key.value)} stands twice; keep one")
                names.add(key.value)
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


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"),
    list("-+.0123456789"),
)


def _number_or_text(loader: _Loader, node: Any) -> object:
    """Return a number; ``190:20:30``, a number to base 60 in YAML 1.1, is a text for ROS."""
    if ":" in node.value:
        return str(node.value)
    integer = node.tag.endswith(":int")
    return loader.construct_yaml_int(node) if integer else loader.construct_yaml_float(node)


_Loader.add_constructor("tag:yaml.org,2002:int", _number_or_text)
_Loader.add_constructor("tag:yaml.org,2002:float", _number_or_text)


def preset_directory() -> Path:
    """Return ``config/`` of the source tree, or its copy inside the installed package."""
    installed = Path(__file__).parent / "config"
    return installed if installed.is_dir() else Path(__file__).parents[1] / "config"


def preset_names() -> list[str]:
    """Return the names of the presets that ship with the package."""
    return sorted(file.stem for file in preset_directory().glob("*.yaml"))


def preset_file(name: str) -> Path:
    """Return the file of preset ``name``; raises FileNotFoundError listing what there is."""
    if not isinstance(name, str) or name not in preset_names():
        raise FileNotFoundError(f"no preset {shown(name)}; there are {', '.join(preset_names())}")
    return preset_directory() / f"{name}.yaml"


# The last part of a section's name that stands for every node.
EVERY_NODE = ("*", "**")


def read_parameter_file(
    path: str | Path,
    node: str,
    foreign: Callable[[str], bool] = lambda _name: False,
    namespace: str | None = None,
) -> dict[str, object]:
    """Return the parameters that the file at ``path`` gives to ``node``, dotted names as keys.

    A section applies when the last part of its name is ``node``, ``*`` or ``**``
    (``plant``, ``/rig/plant``, ``/**/plant``, ``/**``), whatever the namespace before it, unless
    ``namespace`` says which; later sections win. Parameters that every node has are left out, and
    so are those of a section for all nodes that are ``foreign``: another node's. Raises ValueError
    for a file that is not a ROS parameter file, and OSError for one that cannot be read.
    """
    found = parameters_for(path, node, foreign, namespace)
    return {name: value for name, value in found.items() if not is_of_rclpy(name)}


def parameters_for(
    path: str | Path, node: str, foreign: Callable[[str], bool], namespace: str | None
) -> dict[str, object]:
    """Return what :func:`read_parameter_file` does, and what is rclpy's too; raises as it."""
    found: dict[str, object] = {}
    for section, tree in _sections(path):
        addressee = _addressee(section)
        if not _is_in(section, namespace):
            continue
        if addressee == node:
            found |= _flattened(tree)
        elif addressee in EVERY_NODE:
            found |= {k: value for k, value in _flattened(tree).items() if not foreign(k)}
    return found


def section_names(path: str | Path) -> list[str]:
    """Return the names of a file's sections; raises as :func:`read_parameter_file`."""
    return [section for section, _ in _sections(path)]


def _is_in(section: str, namespace: str | None) -> bool:
    """Whether a section is for nodes in ``namespace``; one that names none is for all."""
    named = section.strip("/").rpartition("/")[0]
    if namespace is None or not named:
        return True
    return fnmatchcase(namespace.strip("/"), named.replace("**", "*"))


def read_document(path: str | Path) -> object:
    """Return what a YAML file holds, read as ROS reads parameter files.

    Raises ValueError for what is no YAML, nested or large beyond reason, or has a name twice, and
    OSError for a file that cannot be read.
    """
    try:
        return yaml.load(_text(path), _Loader)
    except yaml.YAMLError as error:
        raise ValueError(f"not YAML: {described(error)}") from error
    except UnicodeDecodeError as error:
        raise ValueError(f"not a text in UTF-8: byte {error.start}") from error


def _sections(path: str | Path) -> list[tuple[str, object]]:
    """Return names and contents of a parameter file's sections; raises ValueError."""
    document = read_document(path)
    if not isinstance(document, dict):
        raise ValueError("not a ROS parameter file: no node sections")
    sections = []
    for section, content in document.items():
        if not isinstance(content, dict) or set(content) != {"ros__parameters"}:
            raise ValueError(f"section {shown(section)} must hold ros__parameters and nothing else")
        sections.append((str(section), content["ros__parameters"] or {}))
    return sections


def _text(path: str | Path) -> str:
    """Return what is in a file; raises ValueError for what is none, or too large for parameters."""
    # A pipe without a writer would make open() wait for ever.
    with os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
        kind = os.fstat(file.fileno()).st_mode
        if stat.S_ISDIR(kind):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not stat.S_ISREG(kind):
            raise ValueError("not a file but a pipe or device; save the parameters to a file")
        content = file.read(LARGEST_FILE + 1)
    if len(content) > LARGEST_FILE:
        raise ValueError(f"no file of parameters: larger than {LARGEST_FILE // 1000} kB")
    return content.decode("utf-8")


def sections_for(path: str | Path, node: str) -> list[str]:
    """Return the names of the sections that address ``node`` by name; [] where it cannot be read.

    ROS itself has refused such a file by then.
    """
    try:
        return [section for section, _ in _sections(path) if _addressee(section) == node]
    except (OSError, ValueError):
        return []


def _addressee(section: str) -> str:
    """Return the node that a section is for, whatever the namespace before it."""
    return section.rsplit("/", 1)[-1]


def number_meant(text: str) -> object:
    """Return the number, or the list of numbers, that ``text`` is for ROS; others as they are.

    `ros2 param` reads values as YAML 1.1, for which 1e-05 is a text, and a list with one such
    number is one text.

    Examples
    --------
    >>> number_meant("1e-05"), number_meant("[2e-06, 0.5]"), number_meant("high")
    (1e-05, [2e-06, 0.5], 'high')
    """
    try:
        value = yaml.load(text, _Loader)
    except (yaml.YAMLError, ValueError):
        return text
    numbers = value if isinstance(value, list) else [value]
    return value if all(type(number) in (int, float) for number in numbers) else text


def is_of_rclpy(name: str) -> bool:
    """Whether ``name`` is a parameter that rclpy itself gives every node."""
    return name in ("use_sim_time", "start_type_description_service") or name.startswith(
        "qos_overrides."
    )


def _flattened(tree: object) -> dict[str, object]:
    """Return a section's parameters by dotted name; raises ValueError for one given twice."""
    found: dict[str, object] = {}
    for name, value in _leaves(tree, ""):
        if name in found:
            raise ValueError(f"{name}: stands twice, nested and dotted; keep one")
        found[name] = value
    return found


def _leaves(tree: object, prefix: str) -> Iterator[tuple[str, object]]:
    if not isinstance(tree, dict):
        raise ValueError(f"{prefix or 'ros__parameters'}: expected names and values")
    for key, value in tree.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            yield from _leaves(value, f"{name}.")
        else:
            yield name, value
