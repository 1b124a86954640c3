# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Messages and requests over DDS, to nodes in processes of their own.

A short run of what the callbacks get in far greater number without DDS.
"""

from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from draw import Draw
from judge import FoundError
from node_callbacks import TEXTS
from odd_messages import odd_message
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger
from target import Change, Target
from trajectory_msgs.msg import JointTrajectory

from rodless_control import PidParameters
from rodless_lab.session.domain import own_domain
from rodless_lab.session.observer import Observer
from rodless_lab.session.processes import ProcessPlan, run_rig
from rodless_sim import RigParameters

TOPICS = {
    "/valve/voltage": Float64,
    "/setpoint": Float64,
    "/joint_states": JointState,
    "/joint_commands": JointState,
    "/controller/joint_trajectory": JointTrajectory,
    "/chamber_a/pressure": FluidPressure,
    "/diagnostics": DiagnosticArray,
    "/clock": Clock,
}
PARAMETER_SERVICES = {
    "describe_parameters": DescribeParameters,
    "get_parameters": GetParameters,
    "get_parameter_types": GetParameterTypes,
    "list_parameters": ListParameters,
    "set_parameters": SetParameters,
    "set_parameters_atomically": SetParametersAtomically,
}
SERVICES = {
    **{f"/{n}/{s}": k for n in ("plant", "controller") for s, k in PARAMETER_SERVICES.items()},
    "/plant/reset": Trigger,
    "/plant/step": Trigger,
    "/plant/pause": SetBool,
    "/controller/reset": Trigger,
    "/controller/enable": SetBool,
}
KNOWN = (*TEXTS, *RigParameters(), *PidParameters())

RCLError = rclpy_implementation.RCLError

# Events of one input.
LONGEST = 50


class OverDds(Target):
    """A change is the bytes of a message, or a request; after each input both nodes must answer."""

    def __init__(self, folder: Path) -> None:
        """Start both nodes."""
        super().__init__(folder)
        self._stack = ExitStack()
        environment = self._stack.enter_context(own_domain())
        self._rig = self._stack.enter_context(run_rig(ProcessPlan(), environment, folder))
        self._observer = self._stack.enter_context(Observer(environment))
        self._publishers = {
            topic: self._observer.node.create_publisher(kind, topic, 10)
            for topic, kind in TOPICS.items()
        }

    def draw(self, draw: Draw) -> list[Change]:
        """Return messages, and a few requests."""
        return [self._event(draw) for _ in range(LONGEST)]

    def weight(self, changes: list[Change]) -> int:
        """Count messages and requests."""
        return len(changes)

    def _event(self, draw: Draw) -> Change:
        if draw.random() < 0.9:
            topic = draw.choice(list(TOPICS))
            data = bytes(serialize_message(odd_message(draw, TOPICS[topic], KNOWN)))
            return "message", topic, draw.spoilt(data) if draw.random() < 0.2 else data
        service = draw.choice(list(SERVICES))
        return "request", service, odd_message(draw, SERVICES[service].Request, KNOWN)

    def run(self, changes: list[Change]) -> object:
        """Send all; then both nodes answer, and say how they are."""
        for what, name, content in changes:
            if what == "message":
                # The publisher itself refuses bytes that are too many or too few.
                with suppress(RCLError):
                    self._publishers[name].publish(content)
            else:
                fields = {f: getattr(content, f) for f in content.get_fields_and_field_types()}
                self._observer.call(SERVICES[name], name, **fields)
        for node in ("plant", "controller"):
            if not self._observer.call(Trigger, f"/{node}/reset").success:
                raise FoundError(f"{node} does not reset")
        self._check()
        return None

    def _check(self) -> None:
        for name in self._rig.names:
            process: Any = self._rig[name]
            if process.exit_code is not None:
                raise FoundError(f"{name} has ended: {process.output[-1500:]}")
            for line in process.output.splitlines():
                if "Traceback" in line or ("error in a callback" in line and "rodless" in line):
                    raise FoundError(line)

    def close(self) -> None:
        """End the nodes."""
        self._stack.close()
