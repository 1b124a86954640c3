# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The parameters that a node is given when it starts."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import pairwise

from rclpy.node import Node

from rodless_base.one_line import shown
from rodless_base.parameter_file import is_of_rclpy, read_parameter_file, sections_for
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
    simulated = node.get_parameter_or(USE_SIM_TIME).value
    if not isinstance(simulated, bool | None):
        raise ParameterError(f"{USE_SIM_TIME}: {shown(simulated)} refused, must be true or false")
    found = {
        name: parameter.value
        for name, parameter in node.get_parameters_by_prefix("").items()
        if not is_of_rclpy(name)
    }
    if node.get_name() == kind:
        return found
    one_by_one = set(parameter_options(sys.argv, node.get_name()))
    of_files = _values_of_files(node, kind)
    return found | {name: of_files[name] for name in of_files.keys() - one_by_one}


def _values_of_files(node: Node, kind: str) -> dict[str, object]:
    name, namespace = node.get_name(), node.get_namespace()
    values: dict[str, object] = {}
    for file in parameter_files(sys.argv):
        with suppress(OSError, ValueError):  # what ROS has read all the same stays as found
            sections = sections_for(file, kind, namespace)
            renamed = sections and not sections_for(file, name, namespace)
            values |= read_parameter_file(file, kind if renamed else name, namespace=namespace)
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
    names = [kind, *_renamed(arguments, "__node")]
    namespace = "".join(_renamed(arguments, "__ns")[-1:])
    value = None
    for file in parameter_files(arguments):
        for node in names:
            with suppress(OSError, ValueError):
                value = read_parameter_file(file, node, namespace=namespace).get(name, value)
    for node in names:
        value = dict(_options(arguments, node)).get(name, value)
    return value.strip("\"' ") if isinstance(value, str) else value


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
