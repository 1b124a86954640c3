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

from rodless_base.parameters import Parameter, ParameterError, ParameterSet, Value

Set = TypeVar("Set", bound=ParameterSet)

# Parameters that rclpy itself gives every node.
RCLPY_PARAMETERS = ("use_sim_time", "start_type_description_service", "qos_overrides.")


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """Describe a parameter: meaning, unit and source in words, its range in numbers."""
    unit = f" [{parameter.unit}]" if parameter.unit else ""
    description = ParameterDescriptor(
        description=f"{parameter.meaning}{unit}; source: {parameter.source}",
        additional_constraints=", ".join(parameter.choices),
        read_only=parameter.fixed,
    )
    if type(parameter.default) is int:
        description.integer_range = [
            IntegerRange(from_value=int(parameter.minimum), to_value=int(parameter.maximum))
        ]
    elif isinstance(parameter.default, float):
        description.floating_point_range = [
            FloatingPointRange(from_value=parameter.minimum, to_value=parameter.maximum)
        ]
    return description


def ros_value(value: Value) -> object:
    """Return ``value`` in the types ROS parameters know."""
    return list(value) if isinstance(value, tuple) else value


class RosParameters(Generic[Set]):
    """The parameters of one node, always equal to a valid ``values``.

    The node must have been built with ``automatically_declare_parameters_from_overrides=True``,
    so that an unknown name given on the command line or in a file is seen. Raises
    :class:`ParameterError` where what was given is not a valid set.
    """

    def __init__(self, node: Node, kind: type[Set], apply: Callable[[Set], None]) -> None:
        """Declare all of ``kind``; call ``apply`` after each change with the new values."""
        self._node = node
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
            if not name.startswith(RCLPY_PARAMETERS)
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
        """Take an integer for a real; name what is unknown, which rclpy itself does not."""
        return [self._converted(parameter) for parameter in parameters]

    def _converted(self, parameter: RosParameter) -> RosParameter:
        name, value = parameter.name, parameter.value
        if name.startswith(RCLPY_PARAMETERS):
            return parameter
        if name not in self.values:
            raise ParameterNotDeclaredException(self.values.unknown(name))
        default = self.values.DECLARATIONS[name].default
        if isinstance(default, float) and type(value) is int:
            return RosParameter(name, value=float(value))
        if isinstance(default, tuple) and parameter.type_ == RosParameter.Type.INTEGER_ARRAY:
            return RosParameter(name, value=[float(item) for item in value])
        return parameter

    def _check(self, parameters: list[RosParameter]) -> SetParametersResult:
        try:
            self.values.with_values(self._ours(parameters))
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
            if not parameter.name.startswith(RCLPY_PARAMETERS)
        }
