# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the instruments read and what the valve holds, each on its topic."""

from collections.abc import Callable

from sensor_msgs.msg import FluidPressure, JointState

from rodless_base.constants import SPOOL
from rodless_base.frames import prefixed
from rodless_base.measurement import Measurement
from rodless_base.ros.publish import OnDemand
from rodless_base.topics import PRESSURE_FRAMES, PRESSURES, VALVE_STATE
from rodless_sim.node import messages
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.state import State

# Makes a publisher of messages of a type on a topic, by a function that packs them.
Make = Callable[[type, str, Callable[..., bytes]], OnDemand]


class ReadingPublishers:
    """Publishers of the pressures and of the valve's state."""

    def __init__(self, make: Make, values: RigParameters) -> None:
        """Make them."""
        self.pressures = {
            field: make(
                FluidPressure, topic, messages.pressures(prefixed(values, PRESSURE_FRAMES[field]))
            )
            for field, topic in PRESSURES.items()
        }
        self.valve_state = make(
            JointState, VALVE_STATE, messages.valve_states(prefixed(values, SPOOL))
        )
        self.configure(values)

    @property
    def publishers(self) -> list[OnDemand]:
        """All of them."""
        return [*self.pressures.values(), self.valve_state]

    def configure(self, values: RigParameters) -> None:
        """Publish with these parameters from now on."""
        self._variances = {field: pressure_variance(values, field) for field in PRESSURES}

    def publish(self, measurement: Measurement, state: State) -> None:
        """Publish a sample."""
        time = measurement.stamp
        for field, publisher in self.pressures.items():
            if publisher.subscribers:
                publisher.publish(getattr(measurement, field), self._variances[field], time)
        if self.valve_state.subscribers:
            self.valve_state.publish(state.spool_voltage, state.voltage, time)


def pressure_variance(values: RigParameters, field: str) -> float:
    """Variance in Pa² of what differs from reading to reading; 0 for ideal instruments."""
    return values.number("sensors.pressure_noise") ** 2 + values.number(f"fault.{field}.noise") ** 2
