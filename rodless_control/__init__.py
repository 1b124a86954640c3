"""The controller: laws and reference trajectories, free of ROS, and one ROS node around them."""

from rodless_base.measurement import Measurement
from rodless_base.parameters import ParameterError
from rodless_control import references
from rodless_control.controller import CompiledLaw, Law, ReferencePoint
from rodless_control.controller_parameters import ControllerParameters
from rodless_control.laws.pid import Command, Pid, PidParameters

__all__ = [
    "Command",
    "CompiledLaw",
    "ControllerParameters",
    "Law",
    "Measurement",
    "ParameterError",
    "Pid",
    "PidParameters",
    "ReferencePoint",
    "references",
]


def __dir__() -> list[str]:
    return __all__
