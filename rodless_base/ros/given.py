# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The parameters that a node is given when it starts."""

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import pairwise

from rclpy.node import Node
from rclpy.parameter import Parameter

from rodless_base.one_line import shown
from rodless_base.parameter_file import is_of_rclpy, parameters_for, sections_for
from rodless_base.parameters import ParameterError
from rodless_base.start import split_ros_arguments

USE_SIM_TIME = "use_sim_time"

REMAPPING = ("-r", "--remap")

# Whose a parameter on the command line is that names no node, or all of them.
EVERYBODY = ("", "*", "**")


def given_parameters(node: Node, kind: str) -> dict[str, object]:
    """Return what files and command line give to ``node``, a ``plant`` or ``controller``.

    ROS finds a node's section by the name the node has now, so a renamed one
    (``-r __node:=cyl1``) would miss the sections ``plant`` of presets and other files. It takes
    them, and says so, from each file without a section of its new name, in the order and in the
    namespace in which a node of the old name would. What the command line gives one by one goes
    before all of them. Raises ParameterError for a ``use_sim_time`` that is neither true nor false,
    of which rclpy only logs that it is left out.
    """
    found = {name: one.value for name, one in node.get_parameters_by_prefix("").items()}
    _check_time_base(found)
    if node.get_name() != kind:
        one_by_one = set(parameter_options(sys.argv, node.get_name()))
        of_files = _values_of_files(node, kind)
        found |= {name: of_files[name] for name in of_files.keys() - one_by_one}
        _check_time_base(found)
        # The one parameter of rclpy's own that the nodes look at.
        node.set_parameters([Parameter(USE_SIM_TIME, value=found[USE_SIM_TIME])])
    return {name: value for name, value in found.items() if not is_of_rclpy(name)}


def _check_time_base(given: Mapping[str, object]) -> None:
    simulated = given[USE_SIM_TIME]
    if not isinstance(simulated, bool):
        raise ParameterError(f"{USE_SIM_TIME}: {shown(simulated)} refused, must be true or false")


def _values_of_files(node: Node, kind: str) -> dict[str, object]:
    name, namespace = node.get_name(), node.get_namespace()
    values: dict[str, object] = {}
    for file in parameter_files(sys.argv):
        with suppress(OSError, ValueError):  # what ROS has read all the same stays as found
            sections = sections_for(file, kind, namespace)
            renamed = sections and not sections_for(file, name, namespace)
            values |= _of_file(file, kind if renamed else name, namespace)
            if renamed:
                node.get_logger().info(f"{file} has no section {name}: taking {sections[-1]}")
    return values


def parameter_files(arguments: Sequence[str]) -> list[str]:
    """Return the parameter files that ``arguments`` give to ROS, in their order.

    Examples
    --------
    >>> parameter_files(["plant", "--ros-args", "--params-file", "a.yaml", "--", "x"])
    ['a.yaml']
    """
    _, for_ros = split_ros_arguments(arguments)
    return [file for option, file in pairwise(for_ros) if option == "--params-file"]


def asked_for(arguments: Sequence[str], kind: str, name: str) -> object:
    """Return what ``arguments`` give parameter ``name`` of a ``plant`` or ``controller``, or None.

    As :func:`given_parameters`, but before there is a node. What no file of parameters is is left
    to ROS, which refuses it.

    Examples
    --------
    >>> asked_for(["--ros-args", "-p", "time.mode:=lockstep"], "plant", "time.mode")
    'lockstep'
    """
    value = _asked(arguments, kind).get(name)
    return value.strip("\"' ") if isinstance(value, str) else value


def empty_lists(arguments: Sequence[str], kind: str) -> list[str]:
    """Return what ``arguments`` give an empty list to, of which ROS cannot tell the type.

    Examples
    --------
    >>> empty_lists(["--ros-args", "-p", "supply.pressure:=[]", "-p", "a:=1"], "plant")
    ['supply.pressure']
    """
    asked = _asked(arguments, kind)
    return [name for name, value in asked.items() if str(value).replace(" ", "") == "[]"]


def _asked(arguments: Sequence[str], kind: str) -> dict[str, object]:
    """Return all that :func:`asked_for` can: values of files, and texts of the command line."""
    names = [kind, *_renamed(arguments, "__node")]
    namespace = "".join(_renamed(arguments, "__ns")[-1:])
    asked: dict[str, object] = {}
    for file in parameter_files(arguments):
        for node in names:
            with suppress(OSError, ValueError):
                asked |= _of_file(file, node, namespace)
    for node in names:
        asked |= _options(arguments, node)
    return asked


def _of_file(path: str, node: str, namespace: str) -> dict[str, object]:
    """Return what a file gives to ``node``; raises OSError or ValueError."""
    return parameters_for(path, node, lambda _name: False, namespace)


def _renamed(arguments: Sequence[str], what: str) -> list[str]:
    """Return what ``arguments`` call a node or its namespace: the last counts."""
    _, for_ros = split_ros_arguments(arguments)
    rules = [rule.partition(":=") for option, rule in pairwise(for_ros) if option in REMAPPING]
    return [to for name, _, to in rules if name.rpartition(":")[2] == what]


def parameter_options(arguments: Sequence[str], node: str) -> list[str]:
    """Return the names of the parameters that ``arguments`` give to ``node`` one by one.

    Examples
    --------
    >>> options = ["--ros-args", "-p", "a.b:=1", "--param", "/left/cyl1:c:=x", "-p", "plant:d:=2"]
    >>> parameter_options(options, "cyl1")
    ['a.b', 'c']
    """
    return [name for name, _ in _options(arguments, node)]


def _options(arguments: Sequence[str], node: str) -> Iterator[tuple[str, str]]:
    """Yield names and texts of :func:`parameter_options`."""
    _, for_ros = split_ros_arguments(arguments)
    for option, rule in pairwise(for_ros):
        left, _, text = rule.partition(":=")
        whose, _, name = left.rpartition(":")
        if option in ("-p", "--param") and whose.rpartition("/")[2] in (*EVERYBODY, node):
            yield name, text
