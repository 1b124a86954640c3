# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The time that a lock-step plant waits by is that in which it could have heard an answer."""

from outgoing import Outgoing

from rodless_sim import RigParameters
from rodless_sim.node.awake_clock import STALL, AwakeClock
from rodless_sim.node.engine import Engine
from rodless_sim.node.lockstep import Lockstep


def test_it_goes_with_the_clock_and_leaves_out_stops() -> None:
    """Read every 20 ms it adds up; of 12 s between two readings it counts half a second."""
    wall = 100.0
    clock = AwakeClock(lambda: wall)
    for _ in range(50):
        wall += 0.02
        last = clock()
    assert abs(last - 1.0) < 1e-9
    wall += 12.0
    assert abs(clock() - (1.0 + STALL)) < 1e-9


def test_a_plant_that_was_stopped_blames_nobody() -> None:
    """SIGSTOP for longer than time.command_timeout; a controller that is silent is still found."""
    wall, samples = 0.0, []
    engine = Engine(
        RigParameters({"time.mode": "lockstep"}), lambda seen, _: samples.append(seen.stamp)
    )
    clock = AwakeClock(lambda: wall)
    one = {b"1": "/controller"}
    plant = Lockstep(engine, 2.0, lambda: True, lambda: one, Outgoing(), clock)
    plant.poll()
    wall += 12.0
    assert plant.problem is None
    plant.poll()
    assert samples == [0]
    for _ in range(120):
        wall += 0.02
        plant.poll()
    assert plant.problem is not None
    assert "/controller" in plant.problem
    assert samples == [0, 0]
