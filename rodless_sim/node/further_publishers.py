# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What not every rig publishes: temperatures, and on request the truth and raw voltages."""

from collections.abc import Callable

from sensor_msgs.msg import FluidPressure, JointState, Temperature

from rodless_base.constants import CARRIAGE, PISTON
from rodless_base.frames import prefixed
from rodless_base.measurement import Measurement
from rodless_base.ros.publish import OnDemand
from rodless_base.topics import (
    JOINT_STATES,
    PRESSURE_FRAMES,
    PRESSURES,
    RAW_VOLTAGES,
    TEMPERATURES,
    TRUTH,
)
from rodless_sim.instruments.instruments import raw_voltages
from rodless_sim.instruments.sampling import instruments_and_noise
from rodless_sim.node import messages
from rodless_sim.node.reading_publishers import Make
from rodless_sim.parameters import RigParameters
from rodless_sim.physics.coupling import MAGNETIC
from rodless_sim.physics.cylinder import piston_area
from rodless_sim.physics.heat import ENERGY_BALANCE
from rodless_sim.physics.state import State, piston_of


def joints(values: RigParameters) -> tuple[str, ...]:
    """Return the joints of ``joint_states``: the piston is one where it is a mass of its own."""
    names = (CARRIAGE, PISTON) if values.text("coupling.kind") == MAGNETIC else (CARRIAGE,)
    return tuple(prefixed(values, name) for name in names)


class FurtherPublishers:
    """Publishers of ``sensors.publish_truth`` and ``sensors.publish_raw``; none without them.

    And of the temperatures of chambers that have some: the true ones, no instrument reads them.
    """

    def __init__(self, make: Make, values: RigParameters) -> None:
        """Make those that ``values`` ask for."""
        self._raw: list[OnDemand] = []
        self._truth: dict[str, OnDemand] = {}
        self._joint: list[OnDemand] = []
        self._temperatures: dict[str, OnDemand] = {}
        if values.text("chambers.thermodynamics") == ENERGY_BALANCE:
            self._temperatures = {
                field: make(
                    Temperature,
                    topic,
                    messages.temperatures(prefixed(values, topic.partition("/")[0])),
                )
                for field, topic in TEMPERATURES.items()
            }
        if values["sensors.publish_raw"]:
            self._raw = [
                make(JointState, RAW_VOLTAGES, messages.voltages(("position", *PRESSURES)))
            ]
        if values["sensors.publish_truth"]:
            joint = messages.joint_states(*joints(values))
            self._joint = [make(JointState, f"{TRUTH}{JOINT_STATES}", joint)]
            self._truth = {
                field: make(
                    FluidPressure,
                    f"{TRUTH}{topic}",
                    messages.pressures(prefixed(values, PRESSURE_FRAMES[field])),
                )
                for field, topic in PRESSURES.items()
            }
        self.configure(values)

    def configure(self, values: RigParameters) -> None:
        """Publish with these parameters from now on."""
        self._instruments, _ = instruments_and_noise(values)
        self._piston_area = piston_area(values)

    @property
    def publishers(self) -> list[OnDemand]:
        """All there are."""
        return [*self._temperatures.values(), *self._raw, *self._truth.values(), *self._joint]

    def publish(self, seen: Measurement, state: State, truth: Callable[[], Measurement]) -> None:
        """Publish a sample: what is read, and what is true."""
        for field, publisher in self._temperatures.items():
            publisher.publish(getattr(state, field), seen.stamp)
        for publisher in self._raw:
            publisher.publish(raw_voltages(self._instruments, seen), seen.stamp)
        if any(publisher.subscribers for publisher in (*self._truth.values(), *self._joint)):
            self._publish_truth(truth(), state)

    def _publish_truth(self, true: Measurement, state: State) -> None:
        for field, publisher in self._truth.items():
            publisher.publish(getattr(true, field), 0.0, true.stamp)
        for publisher in self._joint:
            publisher.publish(true, state.velocity, self._piston_area, *piston_of(state))
