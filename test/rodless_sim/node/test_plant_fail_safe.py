# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The plant closes its valve when commands are missing, late or no numbers."""

import math
from collections.abc import Iterator

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from paused_plant import PausedPlant, positions
from running import StartProcess

from rodless_lab.session.observer import Observer
from rodless_sim import RigParameters, simulate

PARAMETERS = RigParameters()
PERIOD = 0.01
CLOSED = PARAMETERS.number("valve.closed_voltage")
TIMEOUT = PARAMETERS.number("valve.command_timeout")

COUNTERS = ("commands lost", "commands not finite", "commands clamped")

# A command sent at a sample is followed until its age exceeds the timeout: that many steps.
FOLLOWED = round(TIMEOUT / PERIOD) + 1


@pytest.fixture(scope="module")
def plant(observer: Observer, start_node: StartProcess) -> Iterator[PausedPlant]:
    """Run a plant that only the test commands."""
    with start_node("plant", {"time.period": PERIOD}):
        yield PausedPlant(observer)


def foretold(voltages: list[float]) -> list[float]:
    """Positions of a rig without ROS that starts afresh and gets these voltages."""
    return list(simulate(PARAMETERS, voltages, PERIOD).position[1:])


def test_without_a_command_nothing_moves(plant: PausedPlant) -> None:
    """The valve is closed: the carriage rests, both chambers hold √((P_s² + P_e²)/2).

    That is no fault, for nobody has asked for anything yet.
    """
    plant.reset()
    assert positions(plant.steps(20)) == [0.0] * 20
    supply, ambient = PARAMETERS.number("supply.pressure"), PARAMETERS.number("atmosphere.pressure")
    settled = math.sqrt((supply**2 + ambient**2) / 2)
    assert plant.pressures[-1].fluid_pressure == pytest.approx(settled, rel=1e-3)
    status = plant.diagnostic()
    assert status.level == DiagnosticStatus.OK
    assert status.message == "paused"


def test_silence_closes_the_valve_after_the_timeout_in_plant_time(plant: PausedPlant) -> None:
    """A command is followed for 0.1 s of plant time; then the valve closes, until the next one.

    While it is closed the diagnostic is an error, afterwards a warning for some seconds.
    """
    plant.reset()
    plant.command(8.0)
    voltages = [8.0] * FOLLOWED + [CLOSED] * 9
    moved = positions(plant.steps(len(voltages)))
    assert moved == foretold(voltages)
    assert moved != foretold([8.0] * len(voltages))
    status = plant.diagnostic()
    assert status.level == DiagnosticStatus.ERROR
    assert "valve closed" in status.message

    plant.command(3.0)
    assert positions(plant.steps(5)) == foretold([*voltages, *[3.0] * 5])[-5:]
    status = plant.diagnostic()
    assert status.level == DiagnosticStatus.WARN
    assert status.message == "paused; in the last 10 s: commands lost"
    counted = {key: plant.count(key) for key in COUNTERS}
    assert counted == {"commands lost": 1, "commands not finite": 0, "commands clamped": 0}


def test_a_fault_that_is_over_lowers_the_level_and_stays_counted_until_reset(
    plant: PausedPlant,
) -> None:
    """Ten seconds later all is well again; ~/reset begins to count anew."""
    plant.reset()
    plant.command(12.0)
    assert plant.diagnostic().level == DiagnosticStatus.WARN
    plant.observer.wait(lambda: plant.last_diagnostic().level == DiagnosticStatus.OK, "the level")
    assert plant.count("commands clamped") == 1
    plant.reset()
    plant.diagnostic()
    assert plant.count("commands clamped") == 0


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_no_number_closes_the_valve(plant: PausedPlant, bad: float) -> None:
    """NaN and infinities close the valve at once, are counted, and nothing crashes."""
    plant.reset()
    plant.command(8.0)
    plant.steps(5)
    plant.command(bad)
    assert positions(plant.steps(10)) == foretold([8.0] * 5 + [CLOSED] * 10)[-10:]
    assert plant.count("commands not finite") == 1
    assert plant.last_diagnostic().level == DiagnosticStatus.ERROR


@pytest.mark.parametrize(
    ("command", "taken"), [(1e308, 10.0), (12.0, 10.0), (-1.0, 0.0), (-1e308, 0.0)]
)
def test_a_command_out_of_range_is_clamped_and_counted(
    plant: PausedPlant, command: float, taken: float
) -> None:
    """The valve takes the nearest of 0 and 10 V."""
    plant.reset()
    plant.command(command)
    assert plant.count("commands clamped") == 1
    assert positions(plant.steps(8)) == foretold([taken] * 8)


def test_a_running_plant_comes_to_rest_when_commands_stop(plant: PausedPlant) -> None:
    """The same in running time: one command, then silence, and the carriage comes to rest."""
    plant.reset()
    plant.diagnostic()
    lost = plant.count("commands lost")
    plant.pause(False)
    plant.send(10.0)
    plant.observer.wait(lambda: plant.count("commands lost") == lost + 1, "the loss")
    plant.observer.wait(lambda: has_come_to_rest(positions(plant.samples[-50:])), "rest")
    plant.pause(True)


def has_come_to_rest(last: list[float]) -> bool:
    """Whether these positions are one and the same, away from the start."""
    return last[0] > 0.0 and last == last[:1] * len(last)
