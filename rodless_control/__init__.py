"""The controller: PID and reference trajectories, free of ROS, and one ROS node around them."""

from rodless_base.parameters import ParameterError
from rodless_control import references
from rodless_control.parameters import PidParameters
from rodless_control.pid import Command, Pid

__all__ = ["Command", "ParameterError", "Pid", "PidParameters", "references"]
