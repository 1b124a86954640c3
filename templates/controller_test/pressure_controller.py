# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A controller that reads pressures too: one voltage for the three messages of each sample.

python3 pressure_controller.py --ros-args -p gain:=60.0 -p damping:=1.0e-6
"""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64

CLOSED_VOLTAGE = 5.08  # V, no flow


class PressureController(Node):
    """Proportional to the error, damped by the difference of the pressures."""

    def __init__(self) -> None:
        """Subscribe to positions, both pressures and set-points."""
        super().__init__("pressure_controller")
        self.gain = self.declare_parameter("gain", 60.0).value  # V/m
        self.damping = self.declare_parameter("damping", 1e-6).value  # V/Pa
        self.target: float | None = None
        # What has come of each sample that is not complete, by its stamp.
        self.samples: dict[tuple[int, int], dict[str, float]] = {}
        self.voltage = self.create_publisher(Float64, "valve/voltage", 10)
        self.create_subscription(Float64, "setpoint", self.take_setpoint, 10)
        self.create_subscription(JointState, "joint_states", self.take_position, 10)
        self.create_subscription(FluidPressure, "chamber_a/pressure", self.take_a, 10)
        self.create_subscription(FluidPressure, "chamber_b/pressure", self.take_b, 10)

    def take_setpoint(self, message: Float64) -> None:
        """Go to another position from now on."""
        self.target = message.data

    def take_position(self, message: JointState) -> None:
        """Take the position of a sample."""
        self.take(message, "position", message.position[message.name.index("carriage")])

    def take_a(self, message: FluidPressure) -> None:
        """Take the pressure in chamber A, Pa absolute."""
        self.take(message, "a", message.fluid_pressure)

    def take_b(self, message: FluidPressure) -> None:
        """Take the pressure in chamber B, Pa absolute."""
        self.take(message, "b", message.fluid_pressure)

    def take(self, message: JointState | FluidPressure, what: str, value: float) -> None:
        """Answer a sample with exactly one voltage once all of it is there, in whatever order."""
        stamp = message.header.stamp
        key = stamp.sec, stamp.nanosec
        sample = self.samples.setdefault(key, {})
        sample[what] = value
        if len(sample) == 3:
            # What a message was lost of never becomes complete.
            self.samples = {other: has for other, has in self.samples.items() if other > key}
            self.answer(sample["position"], sample["a"] - sample["b"])

    def answer(self, position: float, difference: float) -> None:
        """Publish the voltage for a position in m and a pressure difference in Pa."""
        error = 0.0 if self.target is None else self.target - position
        voltage = CLOSED_VOLTAGE + self.gain * error - self.damping * difference
        self.voltage.publish(Float64(data=min(max(voltage, 0.0), 10.0)))


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    try:
        rclpy.spin(PressureController())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
