# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""A lock-step plant that stands, and a controller that is still busy with its sample."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from rodless_control import ControllerParameters
from rodless_control.loop import ControlLoop
from rodless_lab.session.session import RigSession
from rodless_sim import Rig, RigParameters, simulate

pytestmark = pytest.mark.ros

StartSession = Callable[..., RigSession]

# It hears a set-point while it works at a sample, and goes by the newest as it answers.
SLOW_CONTROLLER = """
import time
import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

rclpy.init()
node = rclpy.create_node("slow", automatically_declare_parameters_from_overrides=True)
wanted = [5.0]
voltage = node.create_publisher(Float64, "valve/voltage", 10)

def answer(_sample):
    time.sleep(0.1)
    voltage.publish(Float64(data=wanted[-1]))

def take(setpoint):
    wanted.append(6.0)

group = ReentrantCallbackGroup()
node.create_subscription(JointState, "joint_states", answer, 10, callback_group=group)
node.create_subscription(Float64, "setpoint", take, 10, callback_group=group)
executor = MultiThreadedExecutor(4)
executor.add_node(node)
try:
    executor.spin()
except KeyboardInterrupt:
    pass
"""


@pytest.mark.parametrize("paused", [False, True], ids=["relayed", "paused"])
def test_a_set_point_acts_from_the_next_sample_on(
    rig_session: StartSession, tmp_path: Path, paused: bool
) -> None:
    """That at which the plant stands gets the answer to what was known as it came.

    A controller that is still busy with it is waited for: which sample the set-point finds would
    depend on the machine.
    """
    script = tmp_path / "slow_controller.py"
    script.write_text(SLOW_CONTROLLER, encoding="utf-8")
    rig = rig_session(
        "lockstep",
        controller=[sys.executable, str(script)],
        relay_commands=not paused,
        paused=paused,
    )

    def go_on() -> None:
        if paused:
            rig.step(3)
        else:
            rig.run_for(0.003)

    go_on()
    rig.setpoint(0.05)
    go_on()
    assert rig.samples().voltage[:6].tolist() == [5.0] * 4 + [6.0] * 2


@pytest.mark.parametrize("paused", [True, False], ids=["paused", "relayed"])
def test_a_law_that_reads_pressures_takes_over_from_one_sample_to_the_next(
    rig_session: StartSession, paused: bool
) -> None:
    """The plant waits until they come: to the bit the run of the two laws without nodes.

    Samples without pressures were answered by a closed valve, as many as the machine was busy.
    """
    rig = rig_session("lockstep", relay_commands=not paused, paused=paused)
    law = ControllerParameters.for_law("state_feedback")({"controller.law": "state_feedback"})
    loop, plant = ControlLoop(ControllerParameters()), Rig(RigParameters())
    expected = []

    def go_on(count: int) -> None:
        if paused:
            rig.step(count)
        else:
            rig.run_for(count * 1e-3)
        for _ in range(count):
            output = loop.sample(plant.read())
            assert output is not None
            expected.append(output.voltage)
            plant.advance(output.voltage, 1e-3)

    go_on(20)
    rig.setpoint(0.05)
    go_on(1)
    loop.setpoints.receive(0.05)
    go_on(50)
    rig.set_parameters("controller", {"controller.law": "state_feedback"})
    go_on(1)
    loop.change_law(law)
    go_on(50)
    assert rig.samples().voltage[: len(expected)].tolist() == expected
    assert rig.latest.position == plant.state.position


# It ends at once, also while it works at a sample, and is then missed at once.
INTERRUPTED_CONTROLLER = """
import time
import rclpy
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
node = rclpy.create_node("interrupted")
voltage = node.create_publisher(Float64, "valve/voltage", 10)

def answer(_sample):
    time.sleep(0.3)
    voltage.publish(Float64(data=5.5))

node.create_subscription(JointState, "joint_states", answer, 10)
try:
    rclpy.spin(node)
except KeyboardInterrupt:
    node.destroy_node()
    rclpy.shutdown()
"""


def test_a_sample_whose_controller_has_ended_stops_no_reset(
    rig_session: StartSession, tmp_path: Path
) -> None:
    """Started anew before it has answered: after a reset each sample has its answer as before."""
    script = tmp_path / "interrupted_controller.py"
    script.write_text(INTERRUPTED_CONTROLLER, encoding="utf-8")
    rig = rig_session("lockstep", controller=[sys.executable, str(script)], relay_commands=True)
    for _ in range(2):
        rig.run_for(0.002)
        rig.restart("controller")
        rig.reset()
    rig.run_for(0.004)
    run = rig.samples()
    assert run.voltage[:4].tolist() == [5.5] * 4
    commands = [5.5] * 4
    assert run.position.tolist() == simulate(RigParameters(), commands, 1e-3).position.tolist()
