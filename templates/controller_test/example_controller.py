# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A controller as small as one can be: a voltage for each position. Put your own in its place.

python3 example_controller.py --ros-args -p gain:=100.0
"""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

CLOSED_VOLTAGE = 5.08  # V, no flow


class ExampleController(Node):
    """Proportional control: volts per metre of error around the closed valve."""

    def __init__(self) -> None:
        """Subscribe to positions and set-points, in m."""
        super().__init__("example_controller")
        self.gain = self.declare_parameter("gain", 100.0).value  # V/m
        self.target: float | None = None
        self.voltage = self.create_publisher(Float64, "valve/voltage", 10)
        self.create_subscription(Float64, "setpoint", self.take_setpoint, 10)
        self.create_subscription(JointState, "joint_states", self.take_sample, 10)

    def take_setpoint(self, message: Float64) -> None:
        """Go to another position from now on."""
        self.target = message.data

    def take_sample(self, message: JointState) -> None:
        """Answer each sample with exactly one voltage: a lock-step plant waits for it."""
        position = message.position[message.name.index("carriage")]
        error = 0.0 if self.target is None else self.target - position
        voltage = CLOSED_VOLTAGE + self.gain * error
        self.voltage.publish(Float64(data=min(max(voltage, 0.0), 10.0)))


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    try:
        rclpy.spin(ExampleController())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
