# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Tests of a controller on the simulated rig: `python3 -m pytest` in this folder.

Replace CONTROLLER by the command that starts yours, and the numbers by what yours must reach.
"""

import sys
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent
CONTROLLER = [sys.executable, str(HERE / "example_controller.py")]
# An installed node, whatever it is written in, with parameters of its own:
# CONTROLLER = ["ros2", "run", "my_package", "my_controller", "--ros-args", "-p", "gain:=100.0"]

# One that reads the pressures too.
PRESSURE_CONTROLLER = [sys.executable, str(HERE / "pressure_controller.py")]

PERIOD = 0.005  # s, of samples and commands
TARGET = 0.02  # m


@pytest.mark.parametrize(
    "controller", [CONTROLLER, PRESSURE_CONTROLLER], ids=["plain", "pressures"]
)
def test_reaches_the_set_point(rig_session, controller):
    """Within 6 s of plant time the carriage comes within 3 mm of the target, and stays there."""
    rig = rig_session("lockstep", controller=controller, plant={"time.period": PERIOD})
    rig.setpoint(TARGET)
    rig.run_for(6.0)
    end = rig.samples().position[-100:]
    assert np.all(np.abs(end - TARGET) < 3e-3)


def test_stays_within_the_limits_of_the_valve(rig_session):
    """A set-point at the far end of the stroke does not ask for more than 0 to 10 V."""
    rig = rig_session("lockstep", controller=CONTROLLER, plant={"time.period": PERIOD})
    rig.setpoint(0.2)
    rig.run_for(1.0)
    voltage = rig.samples().voltage
    voltage = voltage[np.isfinite(voltage)]
    assert voltage.size
    assert voltage.min() >= 0.0
    assert voltage.max() <= 10.0


def test_survives_a_stop_of_the_computer(rig_session):
    """Frozen for half a second of real time in mid-move, it still reaches the target."""
    rig = rig_session(controller=CONTROLLER, plant={"time.period": PERIOD})
    rig.setpoint(TARGET)
    rig.run_until(lambda sample: sample.position > TARGET / 4, "a quarter of the way")
    rig.freeze("controller")
    frozen = rig.run_for(0.5)
    assert frozen.position < TARGET + 3e-3  # the plant has closed the valve
    rig.thaw("controller")
    rig.run_until(lambda sample: abs(sample.position - TARGET) < 3e-3, "the target")
