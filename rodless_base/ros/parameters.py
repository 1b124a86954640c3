# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Show a parameter set as ROS parameters: declared, described, checked as a whole."""

import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Generic, TypeVar

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.exceptions import ParameterNotDeclaredException
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from rodless_base.parameter_file import is_of_rclpy, number_meant
from rodless_base.parameters import (
    LARGEST_INTEGER,
    SMALLEST_INTEGER,
    Parameter,
    ParameterError,
    ParameterSet,
    Value,
)
from rodless_base.ros.given import given_parameters

Set = TypeVar("Set", bound=ParameterSet)

# The reason of a refusal that ends by itself begins with this.
_NOT_YET = "not yet: "


class NotYetError(ParameterError):
    """A change that can be made in a while: whoever asks is told, and may ask again."""


def is_not_yet(reason: str) -> bool:
    """Whether a change was refused for a :class:`NotYetError`."""
    return reason.startswith(_NOT_YET)


# Returns the whole set of another kind that changes ask for, given what is in force; else None.
Successor = Callable[[Set, Mapping[str, object]], Set | None]


class Refusal(ParameterNotDeclaredException):  # type: ignore[misc]
    """A refusal in our own words: the one exception that rclpy's parameter services pass on."""

    def __init__(self, reason: str) -> None:
        Exception.__init__(self, reason)


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """Describe a parameter: meaning, unit and source in words, its range in numbers."""
    unit = f" [{parameter.unit}]" if parameter.unit else ""
    description = ParameterDescriptor(
        description=f"{parameter.meaning}{unit}; source: {parameter.source}",
        additional_constraints=_constraints(parameter),
        read_only=parameter.fixed,
    )
    if type(parameter.default) is int:
        description.integer_range = [
            IntegerRange(
                from_value=int(max(parameter.minimum, SMALLEST_INTEGER)),
                to_value=int(min(parameter.maximum, LARGEST_INTEGER)),
            )
        ]
    elif isinstance(parameter.default, float):
        description.floating_point_range = [
            FloatingPointRange(from_value=parameter.minimum, to_value=parameter.maximum)
        ]
    return description


def _constraints(parameter: Parameter) -> str:
    """Say what a descriptor has no field for."""
    if isinstance(parameter.default, tuple):
        return f"each {parameter.limits}"
    return ", ".join(parameter.choices)


def ros_value(value: Value) -> object:
    """Return ``value`` in the types ROS parameters know."""
    return list(value) if isinstance(value, tuple) else value


@contextmanager
def warnings_logged(node: Node) -> Iterator[None]:
    """Let ``node`` say in its log what Python would print as a warning, such as a former unit."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", FutureWarning)
        yield
    for warning in caught:
        node.get_logger().warning(str(warning.message))


class RosParameters(Generic[Set]):
    """The parameters of one node, always equal to a valid ``values``.

    The node must have been built with ``automatically_declare_parameters_from_overrides=True``,
    so that an unknown name given on the command line or in a file is seen. Raises
    :class:`ParameterError` where what was given is not a valid set.
    """

    def __init__(
        self,
        node: Node,
        kind: type[Set],
        apply: Callable[[Set], None],
        given: Mapping[str, object] | None = None,
        successor: Successor[Set] = lambda _values, _changes: None,
        refresh: Callable[[], None] = lambda: None,
    ) -> None:
        """Declare all of ``kind``; call ``apply`` with the new values at each change.

        ``given`` is what :func:`given_parameters` has returned, where that is known already.
        ``apply`` raises :class:`ParameterError` for what cannot be in the present state. It is
        called while the change can still be refused: looked at before and applied after, the state
        could have moved on in between. rclpy has checked types and ranges by then.

        Where ``successor`` returns a set of another kind, or refuses by :class:`ParameterError`,
        the node has that set's parameters from then on in place of its own.

        ``refresh`` is called before each request is looked at: a node that chooses values itself
        calls :meth:`follow` there, for what is asked is held against what is shown.
        """
        self._node = node
        self._apply = apply
        self._successor = successor
        self._refresh = refresh
        self._next: Set | None = None
        self._follows = False
        # Names that follow from those of the request in hand.
        self._following: list[str] = []
        with warnings_logged(node):
            known = given_parameters(node, kind.NODE) if given is None else given
            self.values = kind(self._own(node, kind, known))
        self._declared = self.values.DECLARATIONS
        self._declare(self._declared)
        node.add_pre_set_parameters_callback(self._convert)
        node.add_on_set_parameters_callback(self._change)
        node.add_post_set_parameters_callback(self._redeclare)

    @staticmethod
    def _own(node: Node, kind: type[Set], given: Mapping[str, object]) -> Mapping[str, object]:
        """Return what the node is given, without what a section for all nodes gives to others."""
        foreign = sorted(filter(kind.foreign, given))
        for name in filter(node.has_parameter, foreign):
            node.undeclare_parameter(name)
        if foreign:
            node.get_logger().info(f"leaving out parameters of other nodes: {', '.join(foreign)}")
        return kind.own({name: value for name, value in given.items() if name not in foreign})

    def _declare(self, wanted: Mapping[str, Parameter]) -> None:
        for name, declared in wanted.items():
            if self._node.has_parameter(name):
                self._node.undeclare_parameter(name)
            self._node.declare_parameter(
                name, ros_value(self.values[name]), descriptor(declared), ignore_override=True
            )

    def _redeclare(self, _parameters: list[RosParameter]) -> None:
        """Declare what another kind of set has, once a change to it is in force."""
        before, now = self._declared, self.values.DECLARATIONS
        if before is now:
            return
        self._declared = now
        self._follows = True
        try:
            for name in before.keys() - now.keys():
                self._node.undeclare_parameter(name)
            self._declare({n: one for n, one in now.items() if not _stays(n, before, now)})
        finally:
            self._follows = False

    def follow(self, values: Set) -> None:
        """Show ``values``, which the node itself has chosen and has in force already."""
        changes = values.differences(self.values)
        self._follows = True
        try:
            self._node.set_parameters(
                [RosParameter(name, value=ros_value(value)) for name, value in changes.items()]
            )
        finally:
            self._follows = False
        self.values = values

    def _convert(self, parameters: list[RosParameter]) -> list[RosParameter]:
        """Take an integer, or a number that came as a text, for a real.

        Name unknown names and wrong types, which rclpy does not.
        """
        self._next = None
        if self._follows:
            return parameters
        self._refresh()
        for parameter in parameters:
            if is_of_rclpy(parameter.name) and not self._node.has_parameter(parameter.name):
                raise Refusal(self.values.unknown(parameter.name))
        try:
            self._next = self._successor(self.values, self._ours(parameters))
        except ParameterError as error:
            raise Refusal(str(error)) from error
        if self._next is not None:
            return self._leading_to(self._next, parameters)
        converted = [self._converted(parameter) for parameter in parameters]
        derived = self._derived(converted)
        self._following = [parameter.name for parameter in derived]
        return converted + derived

    def _leading_to(self, values: Set, parameters: list[RosParameter]) -> list[RosParameter]:
        """Return those changes to ``values`` that rclpy can make; the rest is declared anew."""
        before, now = self._declared, values.DECLARATIONS
        for name, declared in before.items():
            same = _stays(name, before, now) and values[name] == self.values[name]
            if declared.fixed and not same:
                raise Refusal(self._fixed(declared, values.get(name)))
        changes = [
            RosParameter(name, value=ros_value(value))
            for name, value in values.items()
            if _stays(name, before, now) and value != self.values[name]
        ]
        return [one for one in parameters if is_of_rclpy(one.name)] + changes

    def _derived(self, parameters: list[RosParameter]) -> list[RosParameter]:
        """Return what follows from these for others, so that the node shows it too."""
        given = self._ours(parameters)
        try:
            values = self.values.with_values(given)
        except ParameterError:
            return []  # refused in a moment
        return [
            RosParameter(name, value=ros_value(value))
            for name, value in values.differences(self.values).items()
            if name not in given
        ]

    def _converted(self, parameter: RosParameter) -> RosParameter:
        name = parameter.name
        if is_of_rclpy(name):
            return parameter
        if name not in self.values:
            raise Refusal(self.values.unknown(name))
        declared = self.values.DECLARATIONS[name]
        if declared.fixed:
            raise Refusal(self._fixed(declared, parameter.value))
        given = parameter.value
        if isinstance(given, str) and not isinstance(declared.default, str | bool):
            given = number_meant(given)
        try:
            with warnings_logged(self._node):
                value = declared.check(given)
        except ParameterError as error:
            if parameter.type_.value != self._node.describe_parameter(name).type:
                raise Refusal(str(error)) from error
            return parameter
        return RosParameter(name, value=ros_value(value))

    def _fixed(self, declared: Parameter, given: object) -> str:
        """Say that a parameter cannot change, and so whether that matters to who gave it."""
        now = ros_value(self.values[declared.name])
        same = "; it has this value already" if given == now else f"; it is {now!r}"
        return f"{declared.name}: read-only, given when the node starts{same}"

    def _change(self, parameters: list[RosParameter]) -> SetParametersResult:
        if self._follows:
            return SetParametersResult(successful=True)
        try:
            values = self._next or self.values.with_values(self._ours(parameters))
            self._apply(values)
        except NotYetError as error:
            return SetParametersResult(successful=False, reason=f"{_NOT_YET}{error}")
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        self.values = values
        self._say_what_follows(parameters)
        return SetParametersResult(successful=True)

    def _say_what_follows(self, parameters: list[RosParameter]) -> None:
        """Log what has changed beside the parameters that were asked for."""
        if self._following:
            named = [p.name for p in parameters if p.name not in self._following]
            also = [self._shown(name) for name in self._following]
            self._node.get_logger().info(f"{', '.join(named)}: changes also {', '.join(also)}")

    def _shown(self, name: str) -> str:
        unit = self.values.DECLARATIONS[name].unit
        return f"{name} {ros_value(self.values[name])} {unit}".rstrip()

    def _ours(self, parameters: list[RosParameter]) -> dict[str, object]:
        return {
            parameter.name: parameter.value
            for parameter in parameters
            if not is_of_rclpy(parameter.name)
        }


def _stays(name: str, before: Mapping[str, Parameter], now: Mapping[str, Parameter]) -> bool:
    """Whether a parameter is declared alike in both, but for its default."""
    if name not in before or name not in now:
        return False
    return replace(before[name], default=now[name].default) == now[name]
