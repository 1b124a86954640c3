# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""Messages and requests given to the callbacks of both nodes, as the executor would give them."""

import os
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from draw import Draw
from judge import FoundError
from odd_messages import odd_message
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.context import Context
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message, serialize_message
from target import Change, Target

from rodless_base.one_line import traced
from rodless_base.ros.cdr import unpack_float64
from rodless_base.ros.guarded_node import GuardedNode, _passed_our_code
from rodless_base.ros.message_info import delivered_now, wants_info
from rodless_control.node.controller_node import ControllerNode
from rodless_lab.session.domain import own_domain
from rodless_sim.node.plant_node import PlantNode

# Texts that mean something to one node or the other.
TEXTS = (
    "carriage", "/plant", "plant", "controller", "mode", "realtime", "lockstep", "preset",
    "Target frequency (Hz)", "1000", "use_sim_time", "qos_overrides./x.depth", "supply.pressure",
    "sine", "pid", "saturating",
)  # fmt: skip

# Events of one input.
LONGEST = 100


class NodeCallbacks(Target):
    """A change is a message for a subscription, a request for a service, or a timer's turn.

    The nodes are not spun: nothing but the changes happens, one after the other.
    """

    def __init__(self, folder: Path) -> None:
        """Make both nodes, in a domain of their own."""
        super().__init__(folder)
        self._stack = ExitStack()
        os.environ.update(self._stack.enter_context(own_domain()))
        context = Context()
        context.init()
        self._stack.callback(context.try_shutdown)
        options = {"context": context, "use_global_arguments": False}
        period = [Parameter("time.period", value=0.01)]
        self._plant = PlantNode(parameter_overrides=period, **options)
        self._stack.callback(self._plant.close)
        self._controller = ControllerNode(**options)
        self._stack.callback(self._controller.node.destroy_node)
        self._controller._inputs.subscribe()
        self._controller._answers._outbox.send = self._check_command
        self._nodes: dict[str, GuardedNode] = {
            "plant": self._plant.node,
            "controller": self._controller.node,
        }
        self._before = {}
        for name, node in self._nodes.items():
            node.take_error = self._take_error
            self._before[name] = getattr(self, f"_{name}")._parameters.values
        self._texts = [*TEXTS, *self._before["plant"], *self._before["controller"]]

    def draw(self, draw: Draw) -> list[Change]:
        """Return a sequence of events."""
        return [self._event(draw) for _ in range(draw.randint(1, LONGEST))]

    def weight(self, changes: list[Change]) -> int:
        """Count events."""
        return len(changes)

    def _event(self, draw: Draw) -> Change:
        name = draw.choice(list(self._nodes))
        node = self._nodes[name]
        subscriptions, services = list(node.subscriptions), list(node.services)
        number = draw.randrange(len(subscriptions) + len(services) + 1)
        if number < len(subscriptions):
            kind = subscriptions[number].msg_type
            return "message", name, number, self._wire(draw, kind)
        number -= len(subscriptions)
        if number < len(services):
            return "request", name, number, self._wire(draw, services[number].srv_type.Request)
        return "timers", name, 0, b""

    def _wire(self, draw: Draw, kind: Any) -> bytes:
        data = bytes(serialize_message(odd_message(draw, kind, self._texts)))
        return draw.spoilt(data) if draw.random() < 0.1 else data

    def run(self, changes: list[Change]) -> object:
        """Begin anew, and let all happen."""
        self._begin()
        for what, name, number, data in changes:
            node = self._nodes[name]
            if what == "timers":
                for timer in node.timers:
                    timer.callback()
            elif what == "message":
                self._deliver(list(node.subscriptions)[number], data)
            else:
                self._request(list(node.services)[number], data)
        return self._state()

    def _begin(self) -> None:
        for name, node in self._nodes.items():
            values = getattr(self, f"_{name}")._parameters.values
            # Another law has other parameters.
            changed = {n: v for n, v in self._before[name].items() if values.get(n) != v}
            if changed:
                request = SetParametersAtomically.Request(
                    parameters=[
                        Parameter(
                            key, value=list(v) if isinstance(v, tuple) else v
                        ).to_parameter_msg()
                        for key, v in changed.items()
                    ]
                )
                self._call(node, "reset", None)
                answer = self._call(node, "set_parameters_atomically", request)
                if not answer.result.successful:
                    raise FoundError(f"the parameters do not come back: {answer.result.reason}")
            if not self._call(node, "reset", None).success:
                raise FoundError("no reset")
        self._plant._time.pause(True)
        self._controller._answers.enable(True)

    def _call(self, node: GuardedNode, name: str, request: Any) -> Any:
        (service,) = (one for one in node.services if one.srv_name.endswith(f"/{name}"))
        kind = service.srv_type
        return service.callback(request or kind.Request(), kind.Response())

    def _deliver(self, subscription: Any, data: bytes) -> None:
        message: Any = data
        if not subscription.raw:
            try:
                message = deserialize_message(data, subscription.msg_type)
            except Exception:  # rclpy's own, before any callback
                return
        if wants_info(subscription.callback):
            subscription.callback((message, delivered_now(1)))
        else:
            subscription.callback(message)

    def _request(self, service: Any, data: bytes) -> None:
        kind = service.srv_type
        try:
            request = deserialize_message(data, kind.Request)
        except Exception:
            return
        response = service.callback(request, kind.Response())
        # As DDS would send it; and what we say in it is one line.
        serialize_message(response)
        for result in [*getattr(response, "results", []), getattr(response, "result", None)]:
            reason = getattr(result, "reason", "")
            if "\n" in reason or len(reason) > 1500 or (not reason and not result_ok(result)):
                raise FoundError(f"refused with {reason!r}")

    def _take_error(self, error: BaseException) -> str:
        if isinstance(error, FoundError):
            raise error
        if _passed_our_code(error.__traceback__):
            raise FoundError(f"a callback has raised {traced(error)}") from error
        return traced(error)

    def _check_command(self, _publisher: object, message: Any) -> None:
        voltage = unpack_float64(message)
        if not 0.0 <= voltage <= 10.0:
            raise FoundError(f"commanded {voltage} V")

    def _state(self) -> object:
        """Return what must be finite; raise for what no rig has."""
        for node in self._nodes.values():
            for timer in node.timers:
                timer.callback()
        state = self._plant._engine.rig.state
        stroke = self._plant._parameters.values.number("cylinder.stroke")
        if not -1e-6 <= state.position <= stroke + 1e-6:
            raise FoundError(f"the carriage is at {state.position} m")
        failure = self._plant._engine.failure
        if failure is not None and "\n" in failure:
            raise FoundError(f"failed with {failure!r}")
        if self._controller._loop.failure is not None:
            raise FoundError(self._controller._loop.failure)
        return tuple(state)

    def close(self) -> None:
        """Destroy the nodes."""
        self._stack.close()


def result_ok(result: Any) -> bool:
    """Whether a result says that all is well, or says nothing of that kind."""
    return bool(getattr(result, "successful", True))
