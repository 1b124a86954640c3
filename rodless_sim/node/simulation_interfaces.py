# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The standard `simulation_interfaces` services, where that package is installed."""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any, Protocol

from rclpy.node import Node

# As many periods as one request may step: the node answers nothing else meanwhile.
MOST_STEPS = 10_000


class Simulation(Protocol):
    """What the services steer: the plant's time keeper."""

    @property
    def paused(self) -> bool:
        """Whether plant time stands still by request."""

    @property
    def ending(self) -> str | None:
        """Why plant time stands still until a reset; None where it does not."""

    @property
    def at_start(self) -> bool:
        """Whether plant time is zero."""

    @property
    def steps_by_itself(self) -> bool:
        """Whether several steps can be taken at once, without an answer to each."""

    def step(self) -> str | None:
        """Advance a paused plant by one period; return what is in the way, if anything."""


def offer_standard_services(
    node: Node,
    simulation: Simulation,
    reset: Callable[[], object],
    pause: Callable[[bool], object],
    ending: Callable[[], bool],
) -> bool:
    """Offer the services below ``node``'s name; return whether the package is there.

    ``reset`` returns the plant to its start, ``pause`` stops its time or lets it run on; ``ending``
    tells whether the node has been asked to end, which many steps would hold up.
    """
    if find_spec("simulation_interfaces") is None:
        return False
    StandardServices(node, simulation, reset, pause, ending)
    return True


class StandardServices:
    """Features, state, step and reset as simulation_interfaces 1.x defines them."""

    def __init__(
        self,
        node: Node,
        simulation: Simulation,
        reset: Callable[[], object],
        pause: Callable[[bool], object],
        ending: Callable[[], bool],
    ) -> None:
        """Create the services."""
        from simulation_interfaces import msg, srv  # noqa: PLC0415  optional

        self._simulation = simulation
        self._begin_anew = reset
        self._pause = pause
        self._ending = ending
        self._msg = msg
        self._srv = srv
        for kind, name, answer in (
            (srv.GetSimulatorFeatures, "get_simulator_features", self._features),
            (srv.GetSimulationState, "get_simulation_state", self._state),
            (srv.SetSimulationState, "set_simulation_state", self._set_state),
            (srv.StepSimulation, "step_simulation", self._step),
            (srv.ResetSimulation, "reset_simulation", self._reset),
        ):
            node.create_service(kind, f"~/{name}", answer)

    def _result(self, code: int | None = None, text: str = "") -> Any:
        result = self._msg.Result
        return result(result=result.RESULT_OK if code is None else code, error_message=text)

    def _features(self, _request: Any, response: Any) -> Any:
        known = self._msg.SimulatorFeatures
        response.features.features = [
            known.SIMULATION_RESET,
            known.SIMULATION_STATE_GETTING,
            known.SIMULATION_STATE_SETTING,
            known.SIMULATION_STATE_PAUSE,
            known.STEP_SIMULATION_SINGLE,
        ]
        if self._simulation.steps_by_itself:
            response.features.features.append(known.STEP_SIMULATION_MULTIPLE)
        return response

    def _state(self, _request: Any, response: Any) -> Any:
        state = self._msg.SimulationState
        if not self._simulation.paused:
            response.state.state = state.STATE_PLAYING
        else:
            at_start = self._simulation.at_start
            response.state.state = state.STATE_STOPPED if at_start else state.STATE_PAUSED
        response.result = self._result()
        return response

    def _set_state(self, request: Any, response: Any) -> Any:
        state = self._msg.SimulationState
        wanted = request.state.state
        response.result = self._result()
        if wanted in (state.STATE_PLAYING, state.STATE_PAUSED):
            self._pause(wanted == state.STATE_PAUSED)
            ending = self._simulation.ending
            if wanted == state.STATE_PLAYING and ending is not None:
                response.result = self._result(self._msg.Result.RESULT_OPERATION_FAILED, ending)
        elif wanted == state.STATE_STOPPED:
            self._pause(True)
            self._begin_anew()
        else:
            unsupported = self._msg.Result.RESULT_FEATURE_UNSUPPORTED
            response.result = self._result(unsupported, f"state {wanted} is not supported")
        return response

    def _step(self, request: Any, response: Any) -> Any:
        result = self._msg.Result
        response.result = self._result()
        if request.steps > 1 and not self._simulation.steps_by_itself:
            text = "in lock-step each step needs a command: step one by one"
            response.result = self._result(result.RESULT_FEATURE_UNSUPPORTED, text)
            return response
        if request.steps > MOST_STEPS:
            text = f"steps: {request.steps} refused, must be at most {MOST_STEPS} at a time"
            response.result = self._result(result.RESULT_OPERATION_FAILED, text)
            return response
        for made in range(request.steps):
            end = f"the plant ends, after {made} of {request.steps} steps"
            obstacle = end if self._ending() else self._simulation.step()
            if obstacle is not None:
                response.result = self._result(result.RESULT_OPERATION_FAILED, obstacle)
                break
        return response

    def _reset(self, request: Any, response: Any) -> Any:
        kind = self._srv.ResetSimulation.Request
        whole = kind.SCOPE_TIME | kind.SCOPE_STATE
        response.result = self._result()
        if request.scope == kind.SCOPE_DEFAULT or request.scope & whole == whole:
            self._begin_anew()
        else:
            unsupported = self._msg.Result.RESULT_FEATURE_UNSUPPORTED
            text = "time and state can only be reset together"
            response.result = self._result(unsupported, text)
        return response
