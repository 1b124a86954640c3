# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""ROS parameter files (YAML): find the presets, read one node's section."""

from collections.abc import Callable, Collection, Iterator, Sequence
from difflib import get_close_matches
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TypeGuard

import yaml

from rodless_base.one_line import listed, shown
from rodless_base.owners import GROUPS
from rodless_base.yaml_file import RosLoader, read_yaml


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

# A longer text is no number, nor a list of a parameter's: reading it as YAML would take seconds.
LONGEST_NUMBERS = 1000

# Where a section keeps its parameters.
PARAMETERS = "ros__parameters"


def read_parameter_file(
    path: str | Path,
    node: str,
    foreign: Callable[[str], bool] = lambda _name: False,
    namespace: str | None = None,
) -> dict[str, object]:
    """Return the parameters that the file at ``path`` gives to ``node``, dotted names as keys.

    A section applies when the last part of its name is ``node``, ``*`` or ``**``
    (``plant``, ``/rig/plant``, ``/**/plant``, ``/**``), whatever the namespace before it, unless
    ``namespace`` says which; later sections win. Namespaces may be nested, too, as in
    ``rig: {plant: {ros__parameters: {...}}}``. Parameters that every node has are left out, and so
    are those of a section for all nodes that are ``foreign``: another node's. Raises ValueError
    for a file that is not a ROS parameter file, that has no section for plant or controller in
    ``namespace``, or, where none is given, has sections for ``node`` in several; and OSError for
    one that cannot be read.
    """
    sections = _sections(path)
    _check_for_one_rig([section for section, _ in sections], (node,), namespace)
    found = _parameters_of(sections, node, foreign, namespace)
    return {name: value for name, value in found.items() if not is_of_rclpy(name)}


def parameters_for(
    path: str | Path, node: str, foreign: Callable[[str], bool], namespace: str | None
) -> dict[str, object]:
    """Return what :func:`read_parameter_file` does, and what is rclpy's too, of any file.

    It may be for other nodes alone, or for those of several rigs.
    """
    return _parameters_of(_sections(path), node, foreign, namespace)


def _nothing_for_rig(sections: Sequence[str], namespace: str | None) -> str:
    """Say that none of a file's sections is for a node of the rig in ``namespace``."""
    where = "" if namespace is None else f" of namespace {namespace or '/'}"
    return f"no section is for the plant or controller{where}; it has {listed(sections) or 'none'}"


def check_for_one_rig(path: str | Path, namespace: str | None = None) -> None:
    """Raise ValueError for a file without a section for a rig, that in ``namespace`` where given.

    Without, for one with sections for several rigs, too.
    """
    _check_for_one_rig(section_names(path), GROUPS, namespace)


def _check_for_one_rig(
    sections: Sequence[str], nodes: Collection[str], namespace: str | None
) -> None:
    """Raise ValueError for a file that has nothing for a rig, or for ``nodes`` of several."""
    for_rig = [section for section in sections if _is_for(section, GROUPS)]
    if not any(_is_in(section, namespace) for section in for_rig):
        raise ValueError(_nothing_for_rig(sections, namespace))
    own = [section for section in for_rig if _is_for(section, nodes)]
    of_one = next((section for section in own if _names_one_rig(section)), None)
    if namespace is None and of_one is not None:
        others = [section for section in own if not _is_in(section, _namespace(of_one))]
        if others:
            raise ValueError(
                f"{of_one} and {listed(others)} are for different rigs; keep the sections of one"
            )


def _parameters_of(
    sections: Sequence[tuple[str, object]],
    node: str,
    foreign: Callable[[str], bool],
    namespace: str | None,
) -> dict[str, object]:
    found: dict[str, object] = {}
    for section, tree in sections:
        addressee = _addressee(section)
        if not _is_in(section, namespace):
            continue
        if addressee == node:
            found |= flattened(tree)
        elif addressee in EVERY_NODE:
            found |= {k: value for k, value in flattened(tree).items() if not foreign(k)}
    return found


def section_names(path: str | Path) -> list[str]:
    """Return the names of a file's sections; raises as :func:`read_parameter_file`."""
    return [section for section, _ in _sections(path)]


def _is_in(section: str, namespace: str | None) -> bool:
    """Whether a section is for nodes in ``namespace``; one that names none is for all."""
    named = _namespace(section)
    if namespace is None or not named:
        return True
    return fnmatchcase(namespace.strip("/"), named.replace("**", "*"))


def _is_for(section: str, nodes: Collection[str]) -> bool:
    """Whether a section is for one of ``nodes``, whatever its namespace."""
    return _addressee(section) in (*nodes, *EVERY_NODE)


def _namespace(section: str) -> str:
    """Return the namespace that a section names, without the slashes about it; may be none."""
    return section.strip("/").rpartition("/")[0]


def _names_one_rig(section: str) -> bool:
    """Whether a section names a namespace, and no pattern of several."""
    return bool(_namespace(section)) and set("*?[").isdisjoint(_namespace(section))


def _sections(path: str | Path) -> list[tuple[str, object]]:
    """Return names and contents of a parameter file's sections; raises ValueError."""
    document = read_yaml(path, "a ROS parameter file")
    if not isinstance(document, dict):
        raise ValueError("not a ROS parameter file: no node sections")
    return list(_nested(document, ""))


def _nested(level: dict[object, object], namespace: str) -> Iterator[tuple[str, object]]:
    """Yield what :func:`_sections` returns of a map of nodes and namespaces; raises ValueError."""
    for key, content in level.items():
        name = f"{namespace.rstrip('/')}/{key}" if namespace else str(key)
        if "//" in name:  # ROS takes no such file
            raise ValueError(f"section {shown(name)} has two slashes in a row; write one")
        if isinstance(content, dict) and set(content) == {PARAMETERS}:
            yield name, content[PARAMETERS] or {}
        elif _holds_sections(content):
            yield from _nested(content, name)
        else:
            raise ValueError(
                f"section {shown(name)} must hold {PARAMETERS} and nothing else, as in "
                "plant: {ros__parameters: {supply.pressure: 6.0e+5}}"
            )


def _holds_sections(content: object) -> TypeGuard[dict[object, object]]:
    """Whether this is what a namespace has: maps only, and no ``ros__parameters``, not misspelt."""
    return (
        isinstance(content, dict)
        and bool(content)
        and all(isinstance(one, dict) for one in content.values())
        and not get_close_matches(PARAMETERS, map(str, content), n=1, cutoff=0.8)
    )


def sections_for(path: str | Path, node: str, namespace: str) -> list[str]:
    """Return the names of the sections that address ``node`` of ``namespace`` by name.

    Raises as :func:`read_parameter_file`.
    """
    found = [section for section, _ in _sections(path) if _is_in(section, namespace)]
    return [section for section in found if _addressee(section) == node]


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
    if len(text) > LONGEST_NUMBERS:
        return text
    try:
        value = yaml.load(text, RosLoader)
    except (yaml.YAMLError, ValueError):
        return text
    numbers = value if isinstance(value, list) else [value]
    return value if all(type(number) in (int, float) for number in numbers) else text


def is_of_rclpy(name: str) -> bool:
    """Whether ``name`` is a parameter that rclpy itself gives every node."""
    return name in ("use_sim_time", "start_type_description_service") or name.startswith(
        "qos_overrides."
    )


def flattened(tree: object) -> dict[str, object]:
    """Return a section's parameters by dotted name; raises ValueError for one given twice."""
    found: dict[str, object] = {}
    for name, value in _leaves(tree, ""):
        if name in found:
            raise ValueError(f"{name}: stands twice, nested and dotted; keep one")
        found[name] = value
    return found


def _leaves(tree: object, prefix: str) -> Iterator[tuple[str, object]]:
    if not isinstance(tree, dict):
        raise ValueError(
            f"{prefix or 'ros__parameters'}: {shown(tree)} refused: expected names and values, "
            "each as `name: value`"
        )
    for key, value in tree.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            if not value:
                raise ValueError(f"{name}: holds nothing; leave it out or give it a value")
            yield from _leaves(value, f"{name}.")
        else:
            yield name, value
