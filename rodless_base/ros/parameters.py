"""Show a parameter set as ROS parameters: declared, described, checked as a whole."""

from collections.abc import Callable
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

from rodless_base.parameter_file import is_of_rclpy
from rodless_base.parameters import (
    LARGEST_INTEGER,
    SMALLEST_INTEGER,
    Parameter,
    ParameterError,
    ParameterSet,
    Value,
)

Set = TypeVar("Set", bound=ParameterSet)


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
        return f"each from {parameter.minimum:g} to {parameter.maximum:g}"
    return ", ".join(parameter.choices)


def ros_value(value: Value) -> object:
    """Return ``value`` in the types ROS parameters know."""
    return list(value) if isinstance(value, tuple) else value


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
        check: Callable[[Set], None] = lambda _: None,
    ) -> None:
        """Declare all of ``kind``; call ``apply`` after each change with the new values.

        ``check`` is called before; the ParameterError it raises refuses what the node's state does
        not allow.
        """
        self._node = node
        self._check_state = check
        self._apply = apply
        self.values = kind(self._given())
        self._declare()
        node.add_pre_set_parameters_callback(self._convert)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._changed)

    def _given(self) -> dict[str, object]:
        return {
            name: parameter.value
            for name, parameter in self._node.get_parameters_by_prefix("").items()
            if not is_of_rclpy(name)
        }

    def _declare(self) -> None:
        for name, value in self.values.items():
            if self._node.has_parameter(name):
                self._node.undeclare_parameter(name)
            self._node.declare_parameter(
                name,
                ros_value(value),
                descriptor(self.values.DECLARATIONS[name]),
                ignore_override=True,
            )

    def _convert(self, parameters: list[RosParameter]) -> list[RosParameter]:
        """Take an integer for a real; name unknown names and wrong types, which rclpy does not."""
        converted = [self._converted(parameter) for parameter in parameters]
        return converted + self._derived(converted)

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
        try:
            value = self.values.DECLARATIONS[name].check(parameter.value)
        except ParameterError as error:
            if parameter.type_.value != self._node.describe_parameter(name).type:
                raise Refusal(str(error)) from error
            return parameter
        return RosParameter(name, value=ros_value(value))

    def _check(self, parameters: list[RosParameter]) -> SetParametersResult:
        try:
            self._check_state(self.values.with_values(self._ours(parameters)))
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _changed(self, parameters: list[RosParameter]) -> None:
        self.values = self.values.with_values(self._ours(parameters))
        self._apply(self.values)

    def _ours(self, parameters: list[RosParameter]) -> dict[str, object]:
        return {
            parameter.name: parameter.value
            for parameter in parameters
            if not is_of_rclpy(parameter.name)
        }
