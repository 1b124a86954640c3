"""The controller: PID and reference trajectories, free of ROS, and one ROS node around them."""

from rodless_base.parameters import ParameterError
from rodless_control import references
from rodless_control.laws.pid import Command, Pid
from rodless_control.parameters import PidParameters

__all__ = ["Command", "ParameterError", "Pid", "PidParameters", "references"]
