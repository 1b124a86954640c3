# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Ask the nodes of a running rig for what they offer as services."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from std_srvs.srv import SetBool, Trigger

from rodless_lab.session.running_rig import (
    OTHER_NODE_TIMEOUT,
    PLANT,
    SILENCE,
    RigError,
    RunningRig,
)


def ask_each(
    rig: RunningRig, services: Mapping[str, bool | None], timeout: float
) -> Iterator[tuple[str, str]]:
    """Call services by ``node/service``; yield each with its answer, or that it is left out.

    A value is what the service is told, None for one that is told nothing. The plant, or where it
    is told nothing the controller, has ``timeout`` (wall-clock s) to be found; the other is left
    out where it is not there. Raises :class:`RigError` where the first is not there, the other is
    and does not show itself, a node has a namesake or refuses, and WaitTimeoutError where one does
    not answer.
    """
    nodes = [service.partition("/")[0] for service in services]
    rig.wait_for_node(PLANT if PLANT in nodes else nodes[0], timeout)
    rig.wait_for(lambda: all(map(rig.is_known, nodes)), OTHER_NODE_TIMEOUT)
    rig.check_alone()
    _check_shown(rig, services)
    for service, value in services.items():
        node = service.partition("/")[0]
        found = rig.is_known(node)
        yield service, _answer(rig, service, value) if found else f"left out, no {node} was found"


def _check_shown(rig: RunningRig, services: Iterable[str]) -> None:
    """Raise RigError where a node is to be left out that is there: it would drive on later."""
    left_out = {
        service: node for service in services if not rig.is_known(node := service.partition("/")[0])
    }
    if left_out:
        rig.wait_for(lambda: rig.diagnostic(PLANT), SILENCE)
    for service, node in left_out.items():
        if rig.hides(node):
            raise RigError(f"{service}: refused, nothing has changed: {rig.hidden(node)}")


def _answer(rig: RunningRig, service: str, value: bool | None) -> str:
    response: Any = (
        rig.observer.call_once(Trigger, service)
        if value is None
        else rig.observer.call(SetBool, service, data=value)
    )
    if not response.success:
        raise RigError(f"{service}: {response.message}")
    return str(response.message)
