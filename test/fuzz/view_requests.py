# Copyright 2026 rodless_sim contributors
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this file except
# in compliance with the License. You may obtain a copy of the License at
# http://www.apache.org/licenses/LICENSE-2.0 Unless required by applicable law or agreed to in
# writing, software distributed under the License is distributed on an "AS IS" BASIS, WITHOUT
# WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied. See the License for the specific
# language governing permissions and limitations under the License.

"""What pages of a view ask for, and what topics give it: whatever comes, pages get numbers."""

import asyncio
import json
from collections.abc import Mapping
from concurrent.futures import Future
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import rig_bag
from diagnostic_msgs.msg import DiagnosticArray
from draw import Draw
from judge import FoundError
from odd_messages import odd_message
from rcl_interfaces.msg import ParameterEvent, ParameterType
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64
from target import Change, Target

from rodless_base.parameters import ParameterError
from rodless_base.topics import JOINT_STATES, PRESSURES, REFERENCE, VALVE_STATE
from rodless_control import ControllerParameters
from rodless_lab.runs.measured_run import run_of_trace
from rodless_lab.session.errors import HarnessError
from rodless_lab.session.observer import Observer
from rodless_lab.session.running_rig import RunningRig
from rodless_lab.session.set_parameters import typed_value
from rodless_lab.view import frames
from rodless_lab.view.errors import ViewError
from rodless_lab.view.origins import OwnPagesOnly
from rodless_lab.view.panels import REFERENCES
from rodless_lab.view.requests import Requests
from rodless_lab.view.ros.desk import Desk
from rodless_lab.view.ros.live import LiveRig
from rodless_lab.view.samples import Mark
from rodless_lab.view.state import ViewState
from rodless_sim import RigParameters, simulate

KNOWN = (*RigParameters(), *ControllerParameters(), *REFERENCES, "plant", "controller", "bag")
MESSAGES = {
    JOINT_STATES: JointState,
    VALVE_STATE: JointState,
    REFERENCE: Float64,
    **dict.fromkeys(PRESSURES.values(), FluidPressure),
}
KINDS = {
    bool: ParameterType.PARAMETER_BOOL,
    int: ParameterType.PARAMETER_INTEGER,
    float: ParameterType.PARAMETER_DOUBLE,
    str: ParameterType.PARAMETER_STRING,
    tuple: ParameterType.PARAMETER_DOUBLE_ARRAY,
}
HEADERS = (b"host", b"origin", b"Host", b"cookie", b"")
HOSTS = ("localhost:1", "127.0.0.1", "[::1]:80", "evil.example", "http://localhost:1", "//", "[")

LONGEST = 30


def _kind(value: object) -> int:
    """Return the kind of a parameter; an event may have told of one that no node of ours has."""
    return KINDS.get(type(value), ParameterType.PARAMETER_NOT_SET)


class Nodes:
    """Takes parameters as the nodes do: all that are valid together."""

    def __init__(self, state: ViewState) -> None:
        """Answer at once, and let ``state`` know."""
        self._state = state

    def send_set_point(self, target: float) -> None:
        """Take one that a page has given."""
        if not -1.0 <= target <= 10.0:
            raise FoundError(f"set-point {target} m")

    def set_parameters(self, given: Mapping[str, str]) -> "Future[None]":
        """Set them, or refuse."""
        answer: Future[None] = Future()
        try:
            for node, kind in (("plant", RigParameters), ("controller", ControllerParameters)):
                values = self._state.parameters[node]
                share = {
                    name: typed_value(name, text, _kind(values[name]))
                    for name, text in given.items()
                    if name in values
                }
                if share:
                    self._state.take_parameters(node, dict(kind({**values, **share})))
            answer.set_result(None)
        except (HarnessError, ParameterError) as error:
            answer.set_exception(ViewError(str(error)))
        return answer

    def call(self, services: Mapping[str, bool | None], times: int = 1) -> "Future[None]":
        """Do nothing, a few times at the most."""
        if not (services and 1 <= times <= 1000):
            raise FoundError(f"{services} called {times} times")
        answer: Future[None] = Future()
        answer.set_result(None)
        return answer


class ViewRequests(Target):
    """A change is a request of a page, a message on a topic, or headers of a connection."""

    def __init__(self, folder: Path) -> None:
        """Write a bag that can be played."""
        super().__init__(folder)
        run = simulate(RigParameters(), [6.0] * 40, 1e-3)
        rig_bag.write(folder / "bag", run_of_trace(run, 6e5), setpoint=(0.0, 0.05))
        self._guard = OwnPagesOnly(self._app, "127.0.0.1")
        self._loop = asyncio.new_event_loop()

    @staticmethod
    async def _app(*_arguments: object) -> None:
        """Serve nothing."""

    def draw(self, draw: Draw) -> list[Change]:
        """Return what happens, in its order."""
        ways = (self._of_page, self._of_page, self._of_topic, self._of_nodes, self._of_connection)
        return [draw.choice(ways)(draw) for _ in range(draw.randint(1, LONGEST))]

    def weight(self, changes: list[Change]) -> int:
        """Count what happens."""
        return len(changes)

    def _of_page(self, draw: Draw) -> Change:
        flag = draw.random() < 0.5
        value: object = draw.float() if draw.random() < 0.5 else draw.value()
        names = {draw.text(KNOWN): draw.float() if flag else draw.value()}
        asked: dict[str, tuple[object, ...]] = {
            "set_point": (draw.choice((0.05, value)),),
            "set": (names,),
            "set_reference": (draw.choice(("step", "sine", "move", value)), names),
            "cut_supply": (flag,),
            "pause": (flag,),
            "step": (draw.choice((1, value)),),
            "reset": (),
            "enable": (flag,),
            "open_bags": (draw.choice((["bag"], ["bag", "bag"], [value], value)),),
            "close_bags": (),
            "play": (flag,),
            "seek": (value,),
            "set_speed": (draw.choice((0.5, 2.0, value)),),
        }
        # To read a bag takes longest.
        name = draw.choice([*asked, "set_point", "set", "set", "set_reference"])
        if name == "open_bags" and draw.random() < 0.7:
            name = "seek"
        return "page", name, asked[name]

    def _of_topic(self, draw: Draw) -> Change:
        topic = draw.choice(list(MESSAGES))
        return "topic", topic, odd_message(draw, MESSAGES[topic], ("carriage", "spool"))

    def _of_nodes(self, draw: Draw) -> Change:
        kind = draw.choice((DiagnosticArray, ParameterEvent))
        texts = ("/plant", "/controller", *KNOWN, "speed factor", "set-point (m)", "1", "nodes")
        return "nodes", kind.__name__, odd_message(draw, kind, texts)

    def _of_connection(self, draw: Draw) -> Change:
        headers = [
            (draw.choice(HEADERS), draw.text(HOSTS).encode("utf-8", "replace"))
            for _ in range(draw.randrange(4))
        ]
        return "connection", "", headers

    def run(self, changes: list[Change]) -> object:
        """Let it all happen to a view of its own; refusals are lines, and pages are fed on."""
        view = _View(self.folder)
        for what, name, content in changes:
            try:
                self._happen(view, what, name, content)
                view.feed_page()
            except Exception as error:  # who would hear of it?
                raise FoundError(f"{what} {name} ends in {type(error).__name__}") from error
        return None

    def _happen(self, view: "_View", what: str, name: str, content: Any) -> None:
        if what == "page":
            self._ask(view, name, content)
        elif what == "topic":
            view.live._takers[name](content)
            view.live._add_row()
        elif what == "nodes":
            view.take(name, content)
        else:
            self._connect(content)

    def _ask(self, view: "_View", name: str, arguments: tuple[object, ...]) -> None:
        try:
            answer = getattr(view.requests, name)(*arguments)
            if asyncio.iscoroutine(answer):
                self._loop.run_until_complete(answer)
        except ViewError as error:
            text = str(error)
            if not text or "\n" in text or len(text) > 1500:
                raise FoundError(f"{name} refused with {text!r}") from error

    def _connect(self, headers: list[tuple[bytes, bytes]]) -> None:
        if self._guard.admits(headers):
            own = [value for name, value in headers if name.lower() == b"host"]
            if len(own) != 1 or b"evil" in own[0].lower():
                raise FoundError(f"{headers} are admitted")

    def close(self) -> None:
        """End the loop."""
        self._loop.close()


class _View:
    """Desk, topics and requests of a view, without ROS below them."""

    def __init__(self, folder: Path) -> None:
        self.state = state = ViewState()
        state.take_parameters("plant", dict(RigParameters()), whole=True)
        state.take_parameters("controller", dict(ControllerParameters()), whole=True)
        nodes = Nodes(state)
        self.requests = Requests(state, folder, nodes, nodes)
        self.live: Any = _TopicsAlone(state)
        self._observer: Any = object.__new__(Observer)
        self._observer._diagnostics = {}
        self._observer.subscribe = lambda *_: None
        rig: Any = object.__new__(RunningRig)
        rig.observer, rig._diagnostics, rig.name = self._observer, {}, "/{}".format
        rig._diagnostics = self._observer.diagnostics
        rig.is_known = lambda _node: True
        self._rig = rig
        self._desk = Desk(rig, state)
        self._desk._stale.clear()
        self._desk._run = state.history.run
        self._mark = Mark()

    def take(self, kind: str, message: Any) -> None:
        """Take what nodes say of themselves."""
        if kind == "ParameterEvent":
            self._desk._take_event(message)
            return
        self._observer._take_diagnostics(message)
        for node in ("plant", "controller"):
            self._rig._reported_namesakes(node)
            self._desk._look_at(node)
            self._desk._stale.clear()

    def feed_page(self) -> None:
        """Send what pages are sent; only numbers go through JSON."""
        self.state.speed_factor  # noqa: B018  shown by each page
        news, self._mark = frames.frame(self.state, self._mark)
        json.dumps([frames.setup(self.state), news], allow_nan=False)


class _TopicsAlone(LiveRig):
    """Takes messages; no node brings them."""

    def __init__(self, state: ViewState) -> None:
        self._state: Any = state
        self._values: dict[str, float | None] = {}
        self._stamp = None
        self._terms = ()
        self._node: Any = SimpleNamespace()
        self._takers: Any = {
            JOINT_STATES: self._take_joint,
            VALVE_STATE: self._take_valve,
            REFERENCE: self._value("reference", "data"),
            **{topic: self._value(field, "fluid_pressure") for field, topic in PRESSURES.items()},
        }
