# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What the simulation_interfaces services do, with stand-ins for the messages of that package.

The numbers are those of its .msg and .srv files (version 1.5); over ROS and with the package itself
the same is tested where it is installed.
"""

import math
import sys
from collections.abc import Callable
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from outgoing import Outgoing

from rodless_sim import RigParameters
from rodless_sim.node.engine import Engine
from rodless_sim.node.lockstep import Lockstep
from rodless_sim.node.simulation_interfaces import StandardServices, offer_standard_services

OK, UNSUPPORTED, FAILED = 1, 0, 4
STOPPED, PLAYING, PAUSED, QUITTING = range(4)
TIME, STATE, SPAWNED, ALL = 1, 2, 4, 255


class Result(SimpleNamespace):
    """simulation_interfaces/msg/Result."""

    RESULT_FEATURE_UNSUPPORTED, RESULT_OK, RESULT_OPERATION_FAILED = UNSUPPORTED, OK, FAILED


MESSAGES = SimpleNamespace(
    Result=Result,
    SimulationState=SimpleNamespace(
        STATE_STOPPED=STOPPED, STATE_PLAYING=PLAYING, STATE_PAUSED=PAUSED
    ),
    SimulatorFeatures=SimpleNamespace(
        SIMULATION_RESET=20,
        SIMULATION_STATE_GETTING=24,
        SIMULATION_STATE_SETTING=25,
        SIMULATION_STATE_PAUSE=26,
        STEP_SIMULATION_SINGLE=31,
        STEP_SIMULATION_MULTIPLE=32,
    ),
)
SERVICES = SimpleNamespace(
    GetSimulatorFeatures="features",
    GetSimulationState="get",
    SetSimulationState="set",
    StepSimulation="step",
    ResetSimulation=SimpleNamespace(
        Request=SimpleNamespace(SCOPE_DEFAULT=0, SCOPE_TIME=TIME, SCOPE_STATE=STATE)
    ),
)


class Services:
    """The services of a lock-step plant, called as its node would, and its samples."""

    def __init__(self) -> None:
        self.samples: list[int] = []
        self.handlers: dict[str, Callable[[Any, Any], Any]] = {}
        parameters = RigParameters({"time.mode": "lockstep"})
        engine = Engine(parameters, lambda seen, _: self.samples.append(seen.stamp // 1_000_000))
        self.plant = Lockstep(
            engine,
            1.0,
            lambda: True,
            lambda: {b"1": "/controller"},
            lambda: 1,
            Outgoing(),
            lambda: 0.0,
        )
        self.plant.poll()
        self.told: list[str] = []
        self.ends_after = math.inf  # samples; then the node is asked to end
        StandardServices(
            self,
            self.plant,
            lambda: (self.plant.reset(), self.told.append("reset")),
            lambda paused: (self.plant.pause(paused), self.told.append("paused or not")),
            lambda: len(self.samples) >= self.ends_after,
        )

    def create_service(self, _kind: object, name: str, answer: Callable[[Any, Any], Any]) -> None:
        """Keep what a node would offer."""
        self.handlers[name.removeprefix("~/")] = answer

    def call(self, name: str, **request: object) -> Any:
        """Call a service."""
        response = SimpleNamespace(features=SimpleNamespace(), state=SimpleNamespace(state=None))
        return self.handlers[name](SimpleNamespace(**request), response)

    def set_state(self, state: int) -> int:
        """Ask for a state; return the result's code."""
        wanted = SimpleNamespace(state=state)
        return int(self.call("set_simulation_state", state=wanted).result.result)

    @property
    def state(self) -> int:
        """The state it says it is in."""
        return int(self.call("get_simulation_state").state.state)


@pytest.fixture
def services(monkeypatch: pytest.MonkeyPatch) -> Services:
    """Return the services with stand-ins for what they are made of."""
    package = ModuleType("simulation_interfaces")
    vars(package).update(msg=MESSAGES, srv=SERVICES)
    monkeypatch.setitem(sys.modules, "simulation_interfaces", package)
    return Services()


def test_without_the_package_nothing_is_offered(monkeypatch: pytest.MonkeyPatch) -> None:
    """No service, no word, no error."""
    monkeypatch.setattr("rodless_sim.node.simulation_interfaces.find_spec", lambda _: None)
    assert offer_standard_services(None, None, None, None, None) is False


def test_features_are_those_that_work(services: Services) -> None:
    """Stepping several at a time needs a plant that runs by itself: not claimed in lock-step."""
    claimed = services.call("get_simulator_features").features.features
    assert sorted(claimed) == [20, 24, 25, 26, 31]


def test_states_follow_each_other(services: Services) -> None:
    """Playing, paused, and stopped, which is paused at the start after a reset."""
    assert services.state == PLAYING
    services.plant.receive(6.0)
    assert services.set_state(PAUSED) == OK
    assert services.state == PAUSED
    services.plant.receive(6.0)
    assert services.samples == [0, 1]
    assert services.set_state(STOPPED) == OK
    assert services.state == STOPPED
    assert services.samples == [0, 1, 0]
    assert services.set_state(PLAYING) == OK
    services.plant.receive(6.0)
    assert services.state == PLAYING
    assert services.samples == [0, 1, 0, 1]


def test_diagnostics_hear_of_what_is_done(services: Services) -> None:
    """As by ~/reset and ~/pause: a new run has no faults of the one before."""
    services.call("reset_simulation", scope=0)
    services.set_state(PAUSED)
    services.set_state(STOPPED)
    assert services.told == ["reset", "paused or not", "paused or not", "reset"]
    services.call("reset_simulation", scope=TIME)
    services.set_state(QUITTING)
    assert len(services.told) == 4


def test_a_plant_that_has_failed_does_not_play(services: Services) -> None:
    """Until it is reset; the answer says why, as that of ~/pause does."""
    services.plant._engine.fail("it broke")
    wanted = SimpleNamespace(state=PLAYING)
    result = services.call("set_simulation_state", state=wanted).result
    assert result.result == FAILED
    assert "stands still: it broke" in result.error_message
    services.call("reset_simulation", scope=0)
    services.plant.receive(5.0)  # a reset waits for the answer that is under way
    assert services.set_state(PLAYING) == OK


def test_other_states_are_refused(services: Services) -> None:
    """Quitting is not offered; the plant runs on."""
    assert services.set_state(QUITTING) == UNSUPPORTED
    assert services.state == PLAYING


def test_a_step_is_one_period_of_a_paused_plant(services: Services) -> None:
    """It fails with the reason while the plant plays, and while there is no command to step by."""
    playing = services.call("step_simulation", steps=1).result
    assert (playing.result, playing.error_message) == (FAILED, "pause the plant first")
    services.set_state(PAUSED)
    early = services.call("step_simulation", steps=1).result
    assert early.result == FAILED
    assert "no command" in early.error_message
    services.plant.receive(6.0)
    assert services.call("step_simulation", steps=1).result.result == OK
    assert services.samples == [0, 1]


def test_several_steps_at_once_are_refused_in_lock_step(services: Services) -> None:
    """Each needs the answer to the one before."""
    services.set_state(PAUSED)
    services.plant.receive(6.0)
    assert services.call("step_simulation", steps=2).result.result == UNSUPPORTED
    assert services.samples == [0]


def test_steps_that_would_take_minutes_are_refused(
    services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The node would answer nothing else meanwhile, and not end."""
    monkeypatch.setattr(Lockstep, "steps_by_itself", True)
    services.set_state(PAUSED)
    services.plant.receive(6.0)
    result = services.call("step_simulation", steps=2**64 - 1).result
    assert result.result == FAILED
    assert result.error_message == f"steps: {2**64 - 1} refused, must be at most 10000 at a time"
    assert services.samples == [0]


def test_many_steps_end_where_the_node_is_asked_to(
    services: Services, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It promises to end within 2 s, and says how far it has come."""
    monkeypatch.setattr(Lockstep, "steps_by_itself", True)
    services.set_state(PAUSED)
    monkeypatch.setattr(services.plant, "step", lambda: services.samples.append(0))
    services.ends_after = 4
    result = services.call("step_simulation", steps=10_000).result
    assert result.result == FAILED
    assert result.error_message == "the plant ends, after 3 of 10000 steps"
    assert len(services.samples) == 4


@pytest.mark.parametrize("scope", [0, TIME | STATE, ALL])
def test_a_reset_takes_time_and_state_back(services: Services, scope: int) -> None:
    """With the answer to the last sample, which is dropped."""
    services.plant.receive(6.0)
    assert services.call("reset_simulation", scope=scope).result.result == OK
    services.plant.receive(6.0)
    assert services.samples == [0, 1, 0]


@pytest.mark.parametrize("scope", [TIME, STATE, SPAWNED])
def test_half_a_reset_is_refused(services: Services, scope: int) -> None:
    """Time without state, or the reverse, would be no state the rig was ever in."""
    services.plant.receive(6.0)
    assert services.call("reset_simulation", scope=scope).result.result == UNSUPPORTED
    services.plant.receive(6.0)
    assert services.samples == [0, 1, 2]
