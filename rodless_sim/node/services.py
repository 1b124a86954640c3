# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""The plant's services: reset, pause and step."""

from collections.abc import Callable

from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from rodless_sim.node.simulation_interfaces import offer_standard_services
from rodless_sim.node.time_keeper import TimeKeeper


class PlantServices:
    """``~/reset``, ``~/pause`` and ``~/step``, and the standard ones where they are installed."""

    def __init__(
        self,
        node: Node,
        time: TimeKeeper,
        was_reset: Callable[[], None],
        was_paused: Callable[[], None],
        ending: Callable[[], bool],
    ) -> None:
        """Steer ``time``; call ``was_reset`` and ``was_paused`` (or resumed) before answering.

        ``ending`` tells whether the node has been asked to end.
        """
        self._time = time
        self._was_reset = was_reset
        self._was_paused = was_paused
        node.create_service(Trigger, "~/reset", self._reset)
        node.create_service(SetBool, "~/pause", self._pause)
        node.create_service(Trigger, "~/step", self._step)
        offer_standard_services(node, time, self._begin_anew, self._set_paused, ending)

    def _begin_anew(self) -> str:
        when = self._time.reset()
        self._was_reset()
        return when

    def _set_paused(self, paused: bool) -> None:
        self._time.pause(paused)
        self._was_paused()

    def _reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = True
        response.message = self._begin_anew()
        return response

    def _pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._set_paused(request.data)
        response.success = True
        held = self._time.ending
        response.message = held or ("paused" if request.data else "running")
        return response

    def _step(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        obstacle = self._time.step()
        response.success = obstacle is None
        response.message = obstacle or ""
        return response
