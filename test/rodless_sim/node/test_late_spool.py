# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the plant node hands out of a rig whose spool does not follow at once: without nodes."""

import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from rodless_base.measurement import Measurement
from rodless_sim import RigParameters, State, simulate
from rodless_sim.node import messages
from rodless_sim.node.engine import Engine

PARAMETERS = RigParameters(
    {
        "valve.dynamics": "second_order",
        "valve.hysteresis": 0.004,
        "valve.dead_time": 1.3e-3,
        "cylinder.initial_position": 0.1,
    }
)
COMMANDS = 5.08 + np.random.default_rng(4).uniform(-1.0, 1.0, 150).round(1)


def test_samples_are_those_of_simulate_and_a_reset_begins_anew() -> None:
    """Bit for bit, command after command; after a reset the spool is closed, and all repeats."""
    samples: list[State] = []

    def take(_: Measurement, state: State) -> None:
        samples.append(state)

    engine = Engine(PARAMETERS, take)
    expected = simulate(PARAMETERS, COMMANDS, 1e-3, 0.1)
    for _ in range(2):
        engine.reset()
        for command in COMMANDS:
            engine.receive(float(command))
            engine.step()
        assert [state.position for state in samples] == expected.position.tolist()
        assert [state.pressure_a for state in samples] == expected.pressure_a.tolist()
        assert [s.spool_voltage for s in samples] == pytest.approx(
            expected.spool_voltage, rel=1e-15
        )
        assert samples[0].spool_voltage == samples[0].voltage == 5.08
        assert [state.voltage for state in samples[1:]] == COMMANDS.tolist()
        samples.clear()


def test_valve_state_has_the_true_spool_and_the_command() -> None:
    """A spool held at 6 V, commanded to 7: 0.21485 mm per volt from 5.05 V, and 7 V."""
    packed = messages.valve_states()(6.0, 7.0, 1_000_000)
    message = deserialize_message(packed, JointState)
    assert message.position[0] == pytest.approx(0.00021485 * 6.0 - 0.00108499)
    assert message.effort[0] == 7.0
